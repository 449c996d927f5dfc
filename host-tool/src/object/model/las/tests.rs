//! Scans, whole and broken.

use crate::object::model::tests::{read, refused};

/// A cloud of `count` points as a LAS file, or a LAZ file where `compressed` is; colours have `full` as the largest.
pub(in crate::object) fn las(format: u8, count: u16, full: u16, compressed: bool) -> Vec<u8> {
    let mut builder = ::las::Builder::from((1, 4));
    builder.point_format = ::las::point::Format::new(format).unwrap();
    builder.point_format.is_compressed = compressed;
    let coordinate = |offset| ::las::Transform { scale: 0.01, offset };
    builder.transforms =
        ::las::Vector { x: coordinate(500_000.0), y: coordinate(5_000_000.0), z: coordinate(0.0) };
    let bytes = std::io::Cursor::new(Vec::new());
    let mut writer = ::las::Writer::new(bytes, builder.into_header().unwrap()).unwrap();
    for index in 0..count {
        let colour = ::las::Color::new(full, full / 2, 0);
        let point = ::las::Point {
            x: 500_000.0 + f64::from(index),
            y: 5_000_000.0 - f64::from(index) * 0.5,
            z: f64::from(index % 7),
            color: builder_has_colour(format).then_some(colour),
            gps_time: (format != 2 && format != 0).then_some(1.0),
            ..::las::Point::default()
        };
        writer.write_point(point).unwrap();
    }
    writer.close().unwrap();
    writer.into_inner().unwrap().into_inner()
}

fn builder_has_colour(format: u8) -> bool {
    matches!(format, 2 | 3 | 7)
}

#[test]
fn las_is_read_in_every_format_and_compressed_as_well() {
    for format in [0, 1, 2, 3, 6, 7] {
        for compressed in [false, true] {
            let name = if compressed { "a.laz" } else { "a.las" };
            let (points, _, notes) = read(name, las(format, 300, 65_535, compressed));
            assert_eq!(points.len(), 300, "{format} {compressed}");
            let [x, y, z] = points[299].position;
            let off = (x - 500_299.0).abs() + (y - 4_999_850.5).abs() + (z - 5.0).abs();
            assert!(off < 1e-6, "{format} {compressed}: {:?}", points[299]);
            if builder_has_colour(format) {
                assert_eq!((points[7].colour, notes.len()), ([255, 127, 0], 0), "{format} {compressed}");
            } else {
                assert!(notes[0].contains("no colours"), "{notes:?}");
            }
        }
    }
    let (points, _, notes) = read("a.las", las(2, 10, 200, false));
    assert_eq!(points[0].colour, [200, 100, 0]);
    assert!(notes[0].contains("8 bits"));
    assert!(read("a.las", las(2, 10, 0, false)).2[0].contains("all black"));
}

#[test]
fn las_that_claims_more_than_its_bytes_is_refused() {
    let whole = las(2, 50, 255, false);
    let claims = |count: u32| {
        let mut bytes = whole.clone();
        bytes[107..111].copy_from_slice(&count.to_le_bytes());
        refused("a.las", bytes)
    };
    for count in [51, 100_000_000, u32::MAX] {
        assert!(
            claims(count).contains(&format!("byte 107: the header tells of {count} points")),
            "{}",
            claims(count)
        );
    }
    assert!(refused("a.las", &whole[..whole.len() - 1]).contains("cannot hold"));
    assert!(refused("a.las", &whole[..100]).contains("the header cannot be read"));
    let mut scale = whole.clone();
    scale[131..139].copy_from_slice(&f64::NAN.to_le_bytes());
    assert!(refused("a.las", scale).contains("no finite numbers"));
    let compressed = las(7, 50, 255, true);
    assert!(refused("a.laz", &compressed[..compressed.len() / 2]).contains("a.laz"));
    // Behind the table's place and the first point, what no compression writes.
    let mut impossible = las(2, 50, 255, true);
    let points = u32::from_le_bytes(*impossible[96..].first_chunk().unwrap()) as usize;
    impossible[points + 8 + 26..][..4].fill(0xff);
    assert!(refused("a.laz", &impossible).contains("one of the points from 1 on: "));
}
