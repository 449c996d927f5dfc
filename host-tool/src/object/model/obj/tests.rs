//! Which materials and textures are read.

use crate::object::model::Model;
use crate::object::model::tests::folder;

const SQUARE: &str = "mtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\n";
const PAINT: &[u8] =
    b"newmtl red\nKd 1 0 0\nnewmtl out\nmap_Kd ../../brick.png\nnewmtl lost\nmap_Kd lost.png\n";

#[test]
fn what_no_face_is_painted_with_is_not_looked_for() {
    for faces in ["usemtl red\nf 1 2 3\n", "usemtl out\nusemtl lost\nusemtl red\nf 1 2 3\nusemtl out\n"] {
        let on_disk = folder(&[("a.obj", format!("{SQUARE}{faces}").as_bytes()), ("paint.mtl", PAINT)]);
        let (_, triangles, notes) = on_disk.read().unwrap();
        assert_eq!((triangles[0][0].light, notes), ([1.0, 0.0, 0.0], Vec::<String>::new()));
    }
    let paths = |faces: &str| {
        let on_disk = folder(&[("a.obj", format!("{SQUARE}{faces}").as_bytes()), ("paint.mtl", PAINT)]);
        let refused = on_disk.read().unwrap_err().to_string();
        assert!(refused.ends_with("names the file ../../brick.png, which is not in its folder"), "{refused}");
    };
    paths("usemtl out\nf 1 2 3\n");
    paths("usemtl red\nf 1 2 3\nusemtl out\nf 1 2 3\n");
    // No face has a material: the materials may be anywhere.
    let on_disk = folder(&[("a.obj", SQUARE.replace("paint", "../paint").as_bytes())]);
    assert_eq!(on_disk.read().unwrap().0.len(), 3);
}

#[test]
fn a_texture_of_several_materials_is_read_and_told_once() {
    let paint = b"newmtl one\nmap_Kd lost.png\nnewmtl two\nKd 0 1 0\nmap_Kd lost.png\n";
    let text = format!("{SQUARE}usemtl one\nf 1 2 3\nusemtl two\nf 1 2 3\n");
    let on_disk = folder(&[("a.obj", text.as_bytes()), ("paint.mtl", paint)]);
    let (_, triangles, notes) = on_disk.read().unwrap();
    assert_eq!(notes, ["the texture lost.png is missing or damaged: its colours are left out"]);
    assert_eq!(triangles[1][0].light, [0.0, 1.0, 0.0]);
    assert_eq!(Model::open(&on_disk.path).unwrap().files().len(), 2);
}
