//! The header of a PLY file.

use std::io::{BufRead, Read};
use std::path::Path;

use crate::object::model::error::{ModelError, Place};

/// The longest header, in bytes: comments may be long, but not without end.
const LONGEST_HEADER: u64 = 1 << 20;
/// The most properties of an element.
const MOST_PROPERTIES: usize = 1000;

/// What stands before the data.
#[derive(Debug)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// Bytes of the header.
    pub(super) bytes: u64,
    /// Lines of the header.
    pub(super) lines: u64,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Encoding {
    Ascii,
    Binary { big_endian: bool },
}

/// A kind of things that the file lists.
#[derive(Debug)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
    /// Of a list: the kind of the number of its items.
    pub(super) list: Option<Kind>,
}

/// The kinds of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of a number.
    pub(super) fn bytes(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// What a colour of this kind has at full: 255, 65,535 or 1.
    pub(super) fn full(self) -> f64 {
        match self {
            Self::I8 | Self::U8 | Self::I32 | Self::U32 => 255.0,
            Self::I16 | Self::U16 => 65_535.0,
            Self::F32 | Self::F64 => 1.0,
        }
    }

    /// The number at the start of `bytes`; no number where they are too few.
    #[inline]
    pub(super) fn read(self, bytes: &[u8], big_endian: bool) -> f64 {
        fn array<const N: usize>(bytes: &[u8], big_endian: bool) -> [u8; N] {
            let mut array: [u8; N] = bytes.first_chunk().copied().unwrap_or([0xff; N]);
            if big_endian {
                array.reverse();
            }
            array
        }
        match self {
            Self::I8 => f64::from(i8::from_le_bytes(array(bytes, big_endian))),
            Self::U8 => f64::from(u8::from_le_bytes(array(bytes, big_endian))),
            Self::I16 => f64::from(i16::from_le_bytes(array(bytes, big_endian))),
            Self::U16 => f64::from(u16::from_le_bytes(array(bytes, big_endian))),
            Self::I32 => f64::from(i32::from_le_bytes(array(bytes, big_endian))),
            Self::U32 => f64::from(u32::from_le_bytes(array(bytes, big_endian))),
            Self::F32 => f64::from(f32::from_le_bytes(array(bytes, big_endian))),
            Self::F64 => f64::from_le_bytes(array(bytes, big_endian)),
        }
    }
}

impl Element {
    /// Whether there are things of this name in it.
    pub(super) fn is_filled(&self, name: &str) -> bool {
        self.name == name && self.count > 0
    }

    /// Bytes of one of these in a binary file, where each has as many.
    pub(super) fn fixed_bytes(&self) -> Option<usize> {
        let fixed = self.properties.iter().all(|property| property.list.is_none());
        fixed.then(|| self.least_bytes())
    }

    /// The fewest bytes of one of these in a binary file: that of empty lists.
    fn least_bytes(&self) -> usize {
        self.properties.iter().map(|property| property.list.unwrap_or(property.kind).bytes()).sum()
    }

    /// Bytes before the property of this index, where all before it are single numbers.
    pub(super) fn offset(&self, index: usize) -> usize {
        self.properties.iter().take(index).map(|property| property.kind.bytes()).sum()
    }
}

impl Header {
    /// Whether the file is a text that holds nothing but vertices, each of the same numbers.
    pub(super) fn is_text_cloud(&self) -> bool {
        let mut filled = self.elements.iter().filter(|element| element.count > 0);
        let vertices = filled.next().filter(|element| element.name == "vertex");
        self.encoding == Encoding::Ascii
            && filled.next().is_none()
            && vertices.is_some_and(|element| element.fixed_bytes().is_some())
    }

    /// Reads the header; `reader` then stands before the data.
    pub(super) fn read(path: &Path, reader: &mut impl BufRead) -> Result<Self, ModelError> {
        let mut limited = reader.take(LONGEST_HEADER);
        let (mut encoding, mut elements) = (None, Vec::<Element>::new());
        let (mut bytes, mut lines) = (0, 0);
        let mut line = Vec::new();
        loop {
            line.clear();
            let got = limited.read_until(b'\n', &mut line);
            let got = got.map_err(|source| ModelError::Unreadable { path: path.to_owned(), source })?;
            lines += 1;
            bytes += got as u64;
            let fail = |what: &str| Err(ModelError::damaged(path, Place::Line(lines), what));
            if got == 0 {
                return fail("the header has no end_header");
            }
            let text = String::from_utf8_lossy(&line);
            let words: Vec<&str> = text.split_ascii_whitespace().collect();
            match words.as_slice() {
                ["ply"] if lines == 1 => {}
                _ if lines == 1 => return fail("a PLY file begins with a line \"ply\""),
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, _] => {
                    encoding = Some(match *name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Binary { big_endian: false },
                        "binary_big_endian" => Encoding::Binary { big_endian: true },
                        _ => {
                            return fail(
                                "the format is none of ascii, binary_little_endian and binary_big_endian",
                            );
                        }
                    });
                }
                ["element", name, count] => match count.parse() {
                    Ok(count) => {
                        elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
                    }
                    Err(_) => return fail("the number of elements is no whole number"),
                },
                ["property", rest @ ..] => {
                    let property = match rest {
                        ["list", count, kind, name] => {
                            Kind::named(count).zip(Kind::named(kind)).map(|(count, kind)| Property {
                                name: (*name).to_owned(),
                                kind,
                                list: Some(count),
                            })
                        }
                        [kind, name] => Kind::named(kind).map(|kind| Property {
                            name: (*name).to_owned(),
                            kind,
                            list: None,
                        }),
                        _ => None,
                    };
                    match (property, elements.last_mut()) {
                        (Some(property), Some(element)) if element.properties.len() < MOST_PROPERTIES => {
                            element.properties.push(property);
                        }
                        (None, _) => return fail("a property has no known type"),
                        (_, None) => return fail("a property stands before any element"),
                        _ => return fail("an element has too many properties"),
                    }
                }
                ["end_header"] => break,
                _ => return fail("this line belongs into no PLY header"),
            }
        }
        let Some(encoding) = encoding else {
            return Err(ModelError::damaged(path, Place::Line(lines), "the header names no format"));
        };
        if elements.iter().any(|element| element.count > 0 && element.properties.is_empty()) {
            return Err(ModelError::damaged(path, Place::Line(lines), "an element has no properties"));
        }
        Ok(Self { encoding, elements, bytes, lines })
    }

    /// Holds the numbers of elements of a binary file against its length in bytes.
    pub(super) fn check_length(&self, path: &Path, length: u64) -> Result<(), ModelError> {
        let least = self.elements.iter().try_fold(self.bytes, |sum, element| {
            sum.checked_add(element.count.checked_mul(element.least_bytes() as u64)?)
        });
        match least {
            Some(least) if least <= length => Ok(()),
            _ => {
                let counts =
                    self.elements.iter().map(|element| format!("{} {}", element.count, element.name));
                let what = format!(
                    "the header tells of {}, which the {length} bytes of the file cannot hold",
                    counts.collect::<Vec<_>>().join(", ")
                );
                Err(ModelError::damaged(path, Place::Line(self.lines), what))
            }
        }
    }
}
