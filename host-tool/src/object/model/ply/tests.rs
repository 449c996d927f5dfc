//! Elements in any order.

use proptest::prelude::*;

use crate::object::model::tests::{positions, read, refused};

/// A square of two faces and a third one, with an element that nobody knows, in the order that is given: `f` are faces,
/// `v` vertices, `e` edges.
fn ply(order: &str, encoding: &str) -> Vec<u8> {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];
    let mut header = format!("ply\nformat {encoding} 1.0\n");
    let mut data = Vec::new();
    let (is_text, big_endian) = (encoding == "ascii", encoding == "binary_big_endian");
    let put = |numbers: &[(f64, usize)], data: &mut Vec<u8>| {
        for (number, bytes) in numbers {
            let mut written = match bytes {
                _ if is_text => format!("{number} ").into_bytes(),
                1 => vec![*number as u8],
                2 => (*number as i16).to_le_bytes().to_vec(),
                _ => (*number as f32).to_le_bytes().to_vec(),
            };
            if big_endian {
                written.reverse();
            }
            data.extend(written);
        }
        if is_text {
            data.push(b'\n');
        }
    };
    for element in order.chars() {
        match element {
            'f' => {
                header += "element face 2\nproperty uchar mark\nproperty list uchar short vertex_indices\n";
                put(&[(7.0, 1), (4.0, 1), (0.0, 2), (1.0, 2), (2.0, 2), (3.0, 2)], &mut data);
                put(&[(7.0, 1), (3.0, 1), (3.0, 2), (0.0, 2), (1.0, 2)], &mut data);
            }
            'v' => {
                header += "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n";
                corners.iter().for_each(|corner| put(&corner.map(|value| (f64::from(value), 4)), &mut data));
            }
            _ => {
                header += "element edge 1\nproperty list uchar short ends\n";
                put(&[(2.0, 1), (0.0, 2), (1.0, 2)], &mut data);
            }
        }
    }
    [format!("{header}end_header\n").into_bytes(), data].concat()
}

const ENCODINGS: [&str; 3] = ["ascii", "binary_little_endian", "binary_big_endian"];

#[test]
fn elements_may_stand_in_any_order() {
    for encoding in ENCODINGS {
        let wanted = read("a.ply", ply("vf", encoding));
        assert_eq!(wanted.1.len(), 3);
        for order in ["fv", "vfe", "efv", "fev", "fve", "evf"] {
            let found = read("a.ply", ply(order, encoding));
            assert_eq!(positions(&found.1), positions(&wanted.1), "{order} {encoding}");
            assert_eq!((found.0.len(), found.2), (0, wanted.2.clone()), "{order} {encoding}");
        }
        // Faces on either side of the vertices.
        assert_eq!(read("a.ply", ply("fvf", encoding)).1.len(), 6);
    }
}

#[test]
fn faces_before_their_vertices_are_refused_at_their_own_place() {
    let text = String::from_utf8(ply("fv", "ascii")).unwrap();
    let damaged = text.replace("7 3 3 0 1", "7 3 9 0 1");
    assert_eq!(refused("a.ply", damaged), "a.ply, line 12: a face names vertex 9, but there are 4");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn damage_before_the_vertices_never_panics(
        order in prop_oneof![Just("fv"), Just("fev"), Just("fvf")],
        encoding in proptest::sample::select(&ENCODINGS[..]),
        at in any::<proptest::sample::Index>(),
        value in any::<u8>(),
        kept in any::<proptest::sample::Index>(),
    ) {
        let mut bytes = ply(order, encoding);
        let length = bytes.len();
        bytes[at.index(length)] = value;
        let _ = crate::object::model::tests::OnDisk::new("a.ply", &bytes).read();
        bytes.truncate(kept.index(length));
        let _ = crate::object::model::tests::OnDisk::new("a.ply", &bytes).read();
    }
}
