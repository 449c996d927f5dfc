//! An exhibit.toml for a folder of one's own pictures.

use std::collections::HashSet;
use std::fmt::Write;
use std::path::Path;

use vitrine_exhibit::plan::MAX_VIEWS;

use super::{EXHIBIT_TOML, StarterError};
use crate::config::LONGEST_NAME;
use crate::picture::{Picture, PictureError};
use crate::plain::{self, is_plain};

/// Endings of the files that are taken for pictures.
const ENDINGS: [&str; 6] = ["png", "jpg", "jpeg", "tif", "tiff", "webp"];
/// The longer side of the films, as in the commented exhibit.toml.
const PIXELS: f64 = 512.0;
/// The width of a film that is wider than high, as in the commented exhibit.toml, in mm.
const WIDTH_MM: f64 = 35.0;
/// No change from side to side so near to the middle, as in the commented exhibit.toml.
const DEAD_ZONE_DEG: f64 = 5.0;
/// A view's id has at most so many characters.
const LONGEST_ID: usize = 24;

/// One picture that an exhibit is to show.
#[derive(Clone, Debug)]
pub struct OwnPicture {
    /// Its file's name.
    pub file_name: String,
    /// The file.
    pub bytes: Vec<u8>,
    /// Width divided by height.
    pub aspect: f64,
}

/// The pictures of a folder.
#[derive(Clone, Debug)]
pub struct OwnPictures {
    /// Those to be shown, by name; numbers within names count as numbers.
    pub pictures: Vec<OwnPicture>,
    /// Names of the other files, which are left out.
    pub left_out: Vec<String>,
}

/// Reads the pictures in `folder`, by name. Hidden files are none.
///
/// # Errors
/// Fails when the folder cannot be read, holds no picture or more than a plan holds views, and when a picture is damaged.
pub fn own_pictures(folder: &Path) -> Result<OwnPictures, StarterError> {
    let unreadable = |source| StarterError::Unreadable { path: folder.to_owned(), source };
    let (mut paths, mut left_out, mut folder_within) = (Vec::new(), Vec::new(), None);
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let name = file_name(&path);
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_lowercase());
        if name.starts_with('.') {
            continue;
        } else if path.is_dir() {
            folder_within = Some(plain::name(&name).into_owned());
        } else if path.is_file() && ending.is_some_and(|ending| ENDINGS.contains(&ending.as_str())) {
            paths.push(path);
        } else {
            left_out.push(plain::name(&name).into_owned());
        }
    }
    alphanumeric_sort::sort_path_slice(&mut paths);
    alphanumeric_sort::sort_str_slice(&mut left_out);
    if !(1..=MAX_VIEWS).contains(&paths.len()) {
        return Err(StarterError::PictureCount {
            path: folder.to_owned(),
            found: paths.len(),
            left_out: match (left_out.first(), folder_within) {
                (Some(name), _) => format!(" (and {} other files such as {name})", left_out.len()),
                (None, Some(name)) => format!(" (folders such as {name} are not looked into)"),
                (None, None) => String::new(),
            },
            most: MAX_VIEWS,
        });
    }
    if let Some(path) = paths.iter().find(|path| !is_plain(&file_name(path))) {
        return Err(StarterError::Name(path.clone()));
    }
    let read = |path: &std::path::PathBuf| -> Result<OwnPicture, StarterError> {
        let [width, height] = Picture::check(path)?;
        let bytes =
            std::fs::read(path).map_err(|cause| PictureError::Unreadable { path: path.clone(), cause })?;
        Ok(OwnPicture { file_name: file_name(path), bytes, aspect: width as f64 / height as f64 })
    };
    Ok(OwnPictures { pictures: paths.iter().map(read).collect::<Result<_, _>>()?, left_out })
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

/// The commented exhibit.toml with these pictures as its views, from the right to the left, and films of their shape.
pub(super) fn exhibit_toml(name: &str, pictures: &[OwnPicture]) -> String {
    let begin = EXHIBIT_TOML.find("\n[[view]]").map_or(0, |at| at + 1);
    let end = EXHIBIT_TOML.find("\n[stack]").map_or(EXHIBIT_TOML.len(), |at| at + 1);
    let mut views = String::new();
    let mut taken = HashSet::new();
    for (picture, horizontal_deg) in pictures.iter().zip(angles(pictures.len())) {
        let id = id(&picture.file_name, &mut taken);
        let pattern = quoted(&picture.file_name);
        // Writing to a string does not fail.
        let _ = write!(
            views,
            "[[view]]\nid = \"{id}\"\npattern = {pattern}\nhorizontal_deg = {horizontal_deg:.1}\n\n"
        );
    }
    let [width, height] = shape(pictures);
    let width_mm = WIDTH_MM * f64::from(width) / PIXELS;
    let name = if name.is_empty() { "My exhibit" } else { name };
    let name = plain::shortened(name, LONGEST_NAME);
    let mut text = format!("{}{views}{}", &EXHIBIT_TOML[..begin], &EXHIBIT_TOML[end..])
        .replace("name = \"Three photographs\"", &format!("name = {}", quoted(name)));
    text = with_value(&text, "pixels", &format!("[{width}, {height}]"));
    text = with_value(&text, "width_mm", &format!("{width_mm:.1}"));
    let nearest_deg = angles(pictures.len()).map(f64::abs).filter(|&angle| angle > 0.0).fold(90.0, f64::min);
    if nearest_deg < DEAD_ZONE_DEG {
        text = with_value(&text, "dead_zone_deg", &format!("{:.1}", nearest_deg.floor()));
    }
    text
}

/// The text with another value of `key`; the comment behind it stays where it is.
fn with_value(text: &str, key: &str, value: &str) -> String {
    let set = |line: &str| match line.split_once(" = ").filter(|(begin, _)| *begin == key) {
        Some((_, rest)) => {
            let (_, comment) = rest.split_once('#').unwrap_or_default();
            let column = line.len() - comment.len() - 1;
            format!("{:<column$}#{comment}\n", format!("{key} = {value}"))
        }
        None => format!("{line}\n"),
    };
    text.lines().map(set).collect()
}

/// Directions spread evenly: the further apart, the better views part, and the less of the exhibit's front is theirs.
fn angles(count: usize) -> impl Iterator<Item = f64> {
    let widest = match count {
        1 => 0.0,
        2 => 25.0,
        3 => 30.0,
        4 | 5 => 40.0,
        _ => 45.0,
    };
    let step = 2.0 * widest / (count.max(2) - 1) as f64;
    (0..count).map(move |index| widest - step * index as f64)
}

/// Pixels of the films: of the pictures' middle shape, within 1 to 2, so that least is cropped.
fn shape(pictures: &[OwnPicture]) -> [u32; 2] {
    let mut aspects: Vec<f64> = pictures.iter().map(|picture| picture.aspect).collect();
    aspects.sort_by(f64::total_cmp);
    let aspect = aspects.get(aspects.len() / 2).map_or(1.0, |aspect| aspect.clamp(0.5, 2.0));
    if aspect >= 1.0 {
        [PIXELS as u32, (PIXELS / aspect).round() as u32]
    } else {
        [(PIXELS * aspect).round() as u32, PIXELS as u32]
    }
}

/// An id of the letters and digits of a file's name, written in ASCII, which no other view has.
fn id(file_name: &str, taken: &mut HashSet<String>) -> String {
    let stem = Path::new(file_name).file_stem().map(|stem| deunicode::deunicode(&stem.to_string_lossy()));
    let stem = stem.unwrap_or_default().to_lowercase();
    let words =
        stem.split(|c: char| !(c.is_ascii_alphanumeric() || c == '_')).filter(|word| !word.is_empty());
    let id: String = words.collect::<Vec<_>>().join("-").chars().take(LONGEST_ID - 3).collect();
    let id = match id.trim_end_matches('-') {
        "" => "view".to_owned(),
        id => id.to_owned(),
    };
    let numbered = (2..).map(|number| format!("{id}-{number}"));
    let id = std::iter::once(id.clone()).chain(numbered).find(|id| !taken.contains(id)).unwrap_or(id);
    taken.insert(id.clone());
    id
}

/// A text as TOML writes it.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config;

    fn picture(file_name: &str, aspect: f64) -> OwnPicture {
        OwnPicture { file_name: file_name.to_owned(), bytes: Vec::new(), aspect }
    }

    #[test]
    fn ids_are_plain_and_differ() {
        let mut taken = HashSet::new();
        let ids: Vec<String> =
            ["Ähre 1.JPG", "ähre_1.png", "-.png", "IMG.jpg", "img.png", "img.webp", "Zoë – & 日本.png"]
                .map(|name| id(name, &mut taken))
                .into();
        assert_eq!(ids, ["ahre-1", "ahre_1", "view", "img", "img-2", "img-3", "zoe-ri-ben"]);
        let longest = id(&format!("{}.png", "x".repeat(99)), &mut taken);
        assert!(longest.len() <= LONGEST_ID);
    }

    #[test]
    fn views_are_spread_from_right_to_left() {
        assert_eq!(angles(1).collect::<Vec<_>>(), [0.0]);
        assert_eq!(angles(3).collect::<Vec<_>>(), [30.0, 0.0, -30.0]);
        let many: Vec<f64> = angles(16).collect();
        assert_eq!((many[0], many[15]), (45.0, -45.0));
    }

    /// A folder of the bundled photograph under these names.
    fn folder_of(names: &[&str]) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            std::fs::write(folder.path().join(name), super::super::PHOTOGRAPHS[0].1).unwrap();
        }
        folder
    }

    #[test]
    fn the_file_is_valid_whatever_the_pictures_are_called() {
        let names = ["a \"quoted\" \\ one.jpg", "b.jpg", "c.jpg", "[[view]].jpg"];
        let folder = folder_of(&names);
        let pictures = own_pictures(folder.path()).unwrap().pictures;
        assert_eq!(pictures.iter().map(|picture| picture.aspect).collect::<Vec<_>>(), [1.0; 4]);
        let text = exhibit_toml("My \"own\"", &pictures);
        let exhibit = config::parse(&folder.path().join("exhibit.toml"), &text).unwrap();
        assert_eq!(exhibit.name, "My \"own\"");
        let text = exhibit_toml(&"🦋".repeat(24), &pictures);
        let exhibit = config::parse(&folder.path().join("exhibit.toml"), &text).unwrap();
        assert_eq!(exhibit.name, "🦋".repeat(12));
        assert_eq!(exhibit.views.len(), 4);
        assert_eq!(exhibit.stack.pixels, [512, 512]);
        assert_eq!(exhibit.views[0].horizontal_deg, 40.0);
    }

    #[test]
    fn the_file_is_valid_however_many_pictures_there_are() {
        let folder = folder_of(&["a.jpg"]);
        for count in 1..=MAX_VIEWS {
            let text = exhibit_toml("Many", &vec![picture("a.jpg", 1.0); count]);
            let exhibit = config::parse(&folder.path().join("exhibit.toml"), &text);
            assert_eq!(exhibit.unwrap().views.len(), count);
        }
    }

    #[test]
    fn pictures_come_as_a_person_counts_and_what_is_none_is_told() {
        let folder = folder_of(&["p10.jpg", "p2.jpg", "._p2.jpg", "film.mp4", "p1.heic"]);
        std::fs::create_dir(folder.path().join("more.png")).unwrap();
        let own = own_pictures(folder.path()).unwrap();
        let names: Vec<&str> = own.pictures.iter().map(|picture| picture.file_name.as_str()).collect();
        assert_eq!(
            (names, own.left_out),
            (vec!["p2.jpg", "p10.jpg"], vec!["film.mp4".into(), "p1.heic".into()])
        );
        let none = own_pictures(folder_of(&["film.mp4"]).path()).unwrap_err().to_string();
        assert!(none.contains("0 pictures (and 1 other files such as film.mp4)"), "{none}");
        let around = tempfile::tempdir().unwrap();
        std::fs::create_dir(around.path().join("photos")).unwrap();
        let none = own_pictures(around.path()).unwrap_err().to_string();
        assert!(none.contains("0 pictures (folders such as photos are not looked into)"), "{none}");
    }

    #[test]
    fn films_have_the_shape_of_the_pictures() {
        let text = exhibit_toml("", &[picture("a.png", 1.5), picture("b.png", 1.5), picture("c.png", 0.1)]);
        assert!(text.contains("pixels = [512, 341]") && text.contains("width_mm = 35.0"), "{text}");
        let text = exhibit_toml("", &[picture("a.png", 0.75)]);
        assert!(text.contains("pixels = [384, 512]") && text.contains("width_mm = 26.2"), "{text}");
    }
}
