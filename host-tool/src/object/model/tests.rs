//! Models of every format, whole and broken.

use std::path::PathBuf;
use std::sync::Mutex;

use proptest::prelude::*;

use super::las::tests::las;
use super::*;
use crate::object::shape::Vector;

/// Keeps all that it is given, in the file's order where one thread gives it.
#[derive(Default)]
struct Kept {
    points: Mutex<Vec<Point>>,
    triangles: Mutex<Vec<Triangle>>,
}

impl Sink for Kept {
    fn points(&self, points: &[Point]) {
        self.points.lock().unwrap().extend(points);
    }

    fn triangles(&self, triangles: &[Triangle], _: Option<&Texture>) {
        self.triangles.lock().unwrap().extend(triangles);
    }
}

/// The points and triangles of a model, and what had to be mended or guessed.
type Found = (Vec<Point>, Vec<Triangle>, Vec<String>);

/// A folder with one model in it.
pub(super) struct OnDisk {
    _folder: tempfile::TempDir,
    pub(super) path: PathBuf,
}

impl OnDisk {
    pub(super) fn new(name: &str, bytes: impl AsRef<[u8]>) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        Self { _folder: folder, path }
    }

    pub(super) fn read(&self) -> Result<Found, ModelError> {
        let kept = Kept::default();
        let notes = Model::open(&self.path)?.read(&kept)?;
        let mut points = kept.points.into_inner().unwrap();
        points.sort_by(|a, b| a.position.partial_cmp(&b.position).unwrap_or(std::cmp::Ordering::Equal));
        Ok((points, kept.triangles.into_inner().unwrap(), notes))
    }
}

pub(super) fn read(name: &str, bytes: impl AsRef<[u8]>) -> Found {
    OnDisk::new(name, bytes).read().unwrap()
}

/// The message of a model that cannot be read, without the folder.
pub(super) fn refused(name: &str, bytes: impl AsRef<[u8]>) -> String {
    let on_disk = OnDisk::new(name, bytes);
    let message = on_disk.read().unwrap_err().to_string();
    message.replace(&on_disk.path.display().to_string(), name)
}

fn point(position: Vector, colour: [u8; 3]) -> Point {
    Point { position, colour }
}

pub(super) fn positions(triangles: &[Triangle]) -> Vec<[Vector; 3]> {
    triangles.iter().map(|triangle| triangle.map(|corner| corner.position)).collect()
}

#[test]
fn text_is_read_with_its_comments_separators_and_columns() {
    let (points, _, notes) = read("a.xyz", "# by hand\n\n1 2 3 10 20 30\r\n// more\n4,5;6, 40,50,60");
    assert_eq!(points, [point([1.0, 2.0, 3.0], [10, 20, 30]), point([4.0, 5.0, 6.0], [40, 50, 60])]);
    assert!(notes.is_empty());
    let (points, _, notes) = read("a.txt", "1 2 3\n4 5 6\n");
    assert_eq!(points[0], point([1.0, 2.0, 3.0], [255; 3]));
    assert!(notes[0].contains("no colours"));
    // As scanners write it: the number of points, then an intensity before the colour.
    let (points, _, _) = read("a.pts", "2\n1 2 3 -1200 7 8 9\n4 5 6 800 7 8 9\n");
    assert_eq!(points[1], point([4.0, 5.0, 6.0], [7, 8, 9]));
    let (points, _, _) = read("a.csv", "x,y,z,r,g,b,nx,ny,nz\n1,2,3,7,8,9,0,0,1\n");
    assert_eq!(points, [point([1.0, 2.0, 3.0], [7, 8, 9])]);
    let (points, _, notes) = read("a.xyz", "1 2 3 0.0 0.5 1.0\n");
    assert_eq!(points, [point([1.0, 2.0, 3.0], [0, 128, 255])]);
    assert!(notes[0].contains("0 to 1"));
    assert!(read("a.xyz", "nan 2 3\n").0[0].position[0].is_nan());
}

#[test]
fn text_that_is_wrong_is_refused_with_its_line() {
    assert_eq!(refused("a.xyz", "1 2 3\n4 5 six\n"), "a.xyz, line 2: \"six\" is no number");
    assert_eq!(refused("a.xyz", "1 2 3\n4 5\n"), "a.xyz, line 2: has 2 numbers, but the first point has 3");
    assert_eq!(refused("a.xyz", "1 2 3 4 5\n"), "a.xyz, line 1: has 5 numbers, not 3, 4, 6, 7 or 9");
    assert_eq!(refused("a.xyz", ""), "a.xyz, line 1: there is no point in the text");
    assert!(refused("a.xyz", "1 2 3\n\u{1}\u{2}\u{3}").starts_with("a.xyz, line 2:"));
    // Far behind the part from which the columns are made out.
    let long = format!("{}1 2 x\n", "1 2 3\n".repeat(2_000_000));
    assert_eq!(refused("a.xyz", long), "a.xyz, line 2000001: \"x\" is no number");
    let endless = format!("1 2 3\n{}", "9".repeat(9 << 20));
    assert_eq!(refused("a.xyz", endless), "a.xyz, line 2: is longer than 1048576 bytes");
}

const ASCII_PLY: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\nproperty float x\n\
    property float y\nproperty float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n\
    element face 1\nproperty list uchar int vertex_indices\nend_header\n\
    0 0 0 255 0 0\n1 0 0 0 255 0\n1 1 0 0 0 255\n0 1 0 9 9 9\n4 0 1 2 3\n";

/// The square of [`ASCII_PLY`] in binary.
fn binary_ply(big_endian: bool) -> Vec<u8> {
    let order = if big_endian { "big" } else { "little" };
    let (header, data) = ASCII_PLY.split_once("end_header\n").unwrap();
    let mut bytes = header.replace("ascii", &format!("binary_{order}_endian")).into_bytes();
    bytes.extend(b"end_header\n");
    let mut put = |mut number: Vec<u8>| {
        if big_endian {
            number.reverse();
        }
        bytes.extend(number);
    };
    for line in data.lines().take(4) {
        for (index, word) in line.split(' ').enumerate() {
            match index {
                0..3 => put(word.parse::<f32>().unwrap().to_le_bytes().to_vec()),
                _ => put(vec![word.parse().unwrap()]),
            }
        }
    }
    put(vec![4]);
    (0..4i32).for_each(|index| put(index.to_le_bytes().to_vec()));
    bytes
}

#[test]
fn ply_is_the_same_in_text_and_in_both_byte_orders() {
    let (points, triangles, notes) = read("a.ply", ASCII_PLY);
    assert!(points.is_empty() && notes.is_empty());
    assert_eq!(
        positions(&triangles),
        [
            [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]],
            [[0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]]
        ]
    );
    assert_eq!(triangles[0][1].light, [0.0, 1.0, 0.0]);
    for big_endian in [false, true] {
        assert_eq!(read("a.ply", binary_ply(big_endian)).1, triangles);
    }
}

#[test]
fn ply_without_faces_is_points() {
    let (header, data) = ASCII_PLY.split_once("element face").unwrap();
    let data = data.split_once("end_header\n").unwrap().1;
    let cloud = format!("{header}end_header\n{}", data.replace("4 0 1 2 3\n", ""));
    let (points, triangles, notes) = read("a.ply", &cloud);
    assert_eq!((points.len(), triangles.len()), (4, 0));
    assert_eq!(points[0], point([0.0; 3], [255, 0, 0]));
    assert!(notes.is_empty());
    let no_faces = ASCII_PLY.replace("element face 1", "element face 0").replace("4 0 1 2 3\n", "");
    let (points, _, notes) = read("a.ply", no_faces);
    assert_eq!(points.len(), 4);
    assert!(notes[0].contains("no faces"));
}

#[test]
fn ply_that_is_wrong_is_refused_with_its_place() {
    let refused = |from: &str, to: &str| refused("a.ply", ASCII_PLY.replace(from, to));
    assert_eq!(refused("4 0 1 2 3\n", ""), "a.ply, line 18: the file ends before its last face");
    assert_eq!(refused("4 0 1 2 3", "4 0 1 2 9"), "a.ply, line 18: a face names vertex 9, but there are 4");
    assert_eq!(refused("4 0 1 2 3", "4 0 1 2"), "a.ply, line 18: a face has too few numbers");
    assert_eq!(refused("1 0 0 0 255 0", "1 0 O 0 255 0"), "a.ply, line 15: \"O\" is no number");
    assert_eq!(refused("property float z\n", ""), "a.ply, line 12: a vertex has no x, y and z");
    assert_eq!(refused("end_header\n", ""), "a.ply, line 13: this line belongs into no PLY header");
    assert!(refused("format ascii 1.0\n", "").contains("names no format"));
    assert!(refused("ascii", "utf8").starts_with("a.ply, line 2: the format is none of"));
    assert!(refused("float x", "quad x").contains("line 5: a property has no known type"));
    assert!(refused("vertex 4", "vertex many").contains("line 4: the number of elements"));
}

#[test]
fn a_gltf_of_the_version_before_is_named_as_such() {
    let old = r#"{ "asset": { "version": "1.0.2" }, "accessors": {}, "meshes": {} }"#;
    assert!(refused("a.gltf", old).contains("this is glTF of version 1"), "{}", refused("a.gltf", old));
}

#[test]
fn a_mesh_of_more_vertices_than_are_kept_is_refused() {
    let header = "ply\nformat ascii 1.0\nelement vertex 67108865\nproperty float x\nproperty float y\nproperty float z\n\
        element face 1\nproperty list uchar int vertex_indices\nend_header\n";
    assert!(refused("a.ply", header).contains("more than 67108864 vertices"), "{}", refused("a.ply", header));
    let mesh = OnDisk::new("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    let Content::Obj(model) = Model::open(&mesh.path).unwrap().content else { panic!("{:?}", mesh.path) };
    let kept = Kept::default();
    assert!(model.read_within(3, &kept).is_ok());
    assert!(matches!(model.read_within(2, &kept), Err(ModelError::TooManyVertices { most: 2, .. })));
}

#[test]
fn ply_that_claims_more_than_its_bytes_is_refused_before_anything_is_read() {
    let whole = binary_ply(false);
    let claims = |count: &str| {
        let header = String::from_utf8_lossy(&whole).find("end_header").unwrap();
        let text = String::from_utf8(whole[..header].to_vec())
            .unwrap()
            .replace("vertex 4", &format!("vertex {count}"));
        let mut bytes = text.into_bytes();
        bytes.extend(&whole[header..]);
        super::tests::refused("a.ply", bytes)
    };
    for count in ["6", "150000000", "18446744073709551615"] {
        assert!(
            claims(count).contains(&format!("line 13: the header tells of {count} vertex")),
            "{}",
            claims(count)
        );
    }
    // Each list is held against what is left of the file.
    let mut long = whole.clone();
    let at = long.len() - 17;
    long[at] = 200;
    assert!(super::tests::refused("a.ply", long).contains("a list of 200 items is longer than the rest"));
    for length in [whole.len() - 1, whole.len() - 20] {
        assert!(super::tests::refused("a.ply", &whole[..length]).contains("byte"), "{length}");
    }
}

#[test]
fn what_is_no_model_is_refused() {
    assert_eq!(refused("a.doc", "word"), "a.doc is of no kind that is read");
    assert!(Model::open(std::path::Path::new("/nowhere/a.ply")).is_err());
    // What it begins with counts more than its ending.
    assert_eq!(read("square.txt", ASCII_PLY).1.len(), 2);
}

/// Damages whole models of a format in any way: every outcome is an error or a model, never a panic.
fn survives(name: &str, whole: &[u8], changes: &[(usize, u8)], length: usize) {
    let mut bytes = whole.to_vec();
    for (at, value) in changes {
        let at = at % bytes.len();
        bytes[at] = *value;
    }
    bytes.truncate(length.min(bytes.len()));
    let _ = OnDisk::new(name, bytes).read();
}

fn damage() -> impl Strategy<Value = (Vec<(usize, u8)>, usize)> {
    (
        proptest::collection::vec(any::<(usize, u8)>(), 0..6),
        prop_oneof![3 => Just(usize::MAX), 1 => 0usize..2000],
    )
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn damaged_models_never_panic((changes, length) in damage()) {
        survives("a.ply", ASCII_PLY.as_bytes(), &changes, length);
        survives("a.ply", &binary_ply(false), &changes, length);
        survives("a.ply", &binary_ply(true), &changes, length);
        survives("a.obj", OBJ.as_bytes(), &changes, length);
        survives("a.xyz", b"1 2 3 4 5 6\n1e9 -2 3 4 5 6\n", &changes, length);
    }
}

const OBJ: &str = "# a square\nmtllib paint.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
    usemtl red\nf 1/1 2/2 3/3 4/4\nusemtl brick\nf -4/-4 -3/-3//  -2/-2\n";

/// A folder with files in it, the first of them a model.
pub(super) fn folder(files: &[(&str, &[u8])]) -> OnDisk {
    let on_disk = OnDisk::new(files[0].0, files[0].1);
    for (name, bytes) in &files[1..] {
        std::fs::write(on_disk.path.with_file_name(name), bytes).unwrap();
    }
    on_disk
}

#[test]
fn obj_is_read_with_its_materials_and_textures() {
    let paint = b"newmtl red\nKd 1 0 0\nnewmtl brick\nKd 1 1 1\nmap_Kd brick.png\n";
    let mut brick = Vec::new();
    let pixels = image::RgbImage::from_fn(2, 2, |x, y| image::Rgb([255 * x as u8, 255 * y as u8, 0]));
    pixels.write_to(&mut std::io::Cursor::new(&mut brick), image::ImageFormat::Png).unwrap();
    let on_disk = folder(&[("a.obj", OBJ.as_bytes()), ("paint.mtl", paint), ("brick.png", &brick)]);
    let (_, triangles, notes) = on_disk.read().unwrap();
    assert!(notes.is_empty(), "{notes:?}");
    assert_eq!(triangles.len(), 3);
    assert_eq!(triangles[0][0].light, [1.0, 0.0, 0.0]);
    assert_eq!(
        triangles[2].map(|corner| corner.position),
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]
    );
    // Textures count from below in the file, from above here.
    assert_eq!(triangles[2].map(|corner| corner.texture), [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0]]);
    assert_eq!(Model::open(&on_disk.path).unwrap().files().len(), 3);
    std::fs::remove_file(on_disk.path.with_file_name("brick.png")).unwrap();
    assert!(on_disk.read().unwrap().2[0].contains("texture brick.png is missing"));
    std::fs::remove_file(on_disk.path.with_file_name("paint.mtl")).unwrap();
    assert!(on_disk.read().unwrap().2[0].contains("materials paint.mtl are missing"));
    let (points, _, notes) = read("a.obj", "v 0 0 0 1 0.5 0\nv 1 2 3 255 128 0\n");
    assert_eq!(points.iter().map(|point| point.colour).collect::<Vec<_>>(), [[255, 128, 0]; 2]);
    assert!(notes[0].contains("no faces"));
}

#[test]
fn obj_that_is_wrong_is_refused_with_its_line() {
    assert_eq!(
        refused("a.obj", "v 0 0 0\nf 1 2 3\n"),
        "a.obj, line 2: names vertex 2, but there are 1 so far"
    );
    assert_eq!(
        refused("a.obj", "v 0 0 0\nf 0 1 1\n"),
        "a.obj, line 2: names vertex 0, but there are 1 so far"
    );
    let most = "v 0 0 0\nf 1 -9223372036854775808 1\n";
    assert!(refused("a.obj", most).contains("line 2: names vertex -9223372036854775808"));
    assert_eq!(refused("a.obj", "v 0 zero 0\n"), "a.obj, line 1: \"zero\" is no number");
    assert_eq!(refused("a.obj", "v 0 0\n"), "a.obj, line 1: a vertex has 2 numbers, not 3, 4 or 6");
    let model = b"v 0 0 0\nmtllib m.mtl\nusemtl a\nf 1 1 1\n";
    let on_disk = folder(&[("a.obj", model), ("m.mtl", b"newmtl a\nKd 1 2\n")]);
    assert!(on_disk.read().unwrap_err().to_string().ends_with("m.mtl, line 2: Kd wants three numbers"));
}

#[test]
fn places_in_a_texture_that_are_not_there_are_told_and_do_no_harm() {
    let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0.5 0.25\nf 1/1 2/7 3/-2\n";
    let (_, triangles, notes) = read("a.obj", text);
    assert_eq!(triangles[0].map(|corner| corner.texture), [[0.5, 0.75], [0.0; 2], [0.0; 2]]);
    assert!(notes[0].contains("2 corners name places"), "{notes:?}");
    assert!(refused("a.obj", text.replace("2/7", "2/x")).contains("is no index"));
}

#[test]
fn gltf_with_pictures_of_unknown_formats_says_so() {
    let optional = r#""textures": [{"extensions": {"KHR_texture_basisu": {"source": 0}}}],
        "images": [{"uri": "a.ktx2"}], "extensionsUsed": ["KHR_texture_basisu"],
        "materials": [{"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}],
        "nodes": [{"mesh": 0}], "meshes": [{"primitives": [{"material": 0, "attributes": {"POSITION": 0}}]}],
        "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}],
        "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri":
        "data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]"#;
    let text = |more: &str| format!("{{\"asset\": {{\"version\": \"2.0\"}}, {optional}{more}}}");
    let (_, triangles, notes) = read("a.gltf", text(""));
    assert_eq!(triangles.len(), 1);
    assert!(notes.iter().any(|note| note.contains("no picture in a format that is known")), "{notes:?}");
    let required = text(", \"extensionsRequired\": [\"KHR_texture_basisu\"]");
    assert!(refused("a.gltf", required).contains("the textures are compressed by KHR_texture_basisu"));
}

#[test]
fn text_with_decimal_commas_is_not_taken_for_other_numbers() {
    for line in ["0,5 1,25 3,0", "0,5;1,25;3,0", "0,5\t1,25\t3"] {
        assert!(refused("a.xyz", format!("{line}\n")).contains("line 1: has commas within"), "{line}");
    }
    for line in ["0.5,1.25,3", "0.5, 1.25, 3", "0.5 ,1.25 ,3", "0.5;1.25;3"] {
        assert_eq!(read("a.xyz", format!("{line}\n")).0[0].position, [0.5, 1.25, 3.0], "{line}");
    }
}

#[test]
fn files_outside_of_a_models_folder_are_never_read() {
    for name in ["../../etc/passwd", "/etc/passwd", "..\\secret.mtl", "C:\\secret.mtl", "a/../../b.mtl"] {
        let message = refused("a.obj", format!("v 0 0 0\nmtllib {name}\nusemtl a\nf 1 1 1\n"));
        assert_eq!(message, format!("a.obj names the file {name}, which is not in its folder"));
    }
    let model = b"v 0 0 0\nmtllib m.mtl\nusemtl a\nf 1 1 1\n";
    let on_disk = folder(&[("a.obj", model), ("m.mtl", b"newmtl a\nmap_Kd -s 1 1 1 ../x.png\n")]);
    assert!(on_disk.read().unwrap_err().to_string().contains("m.mtl names the file ../x.png"));
}

const TEXT_STL: &str = "solid square\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 1 1 0\n\
    endloop\nendfacet\nendsolid square\n";

/// The triangle of [`TEXT_STL`] in binary, with the header that many programs write.
fn binary_stl() -> Vec<u8> {
    let mut bytes = b"solid, but binary".to_vec();
    bytes.resize(80, b' ');
    bytes.extend(1u32.to_le_bytes());
    for number in [0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend([0, 0]);
    bytes
}

#[test]
fn stl_is_the_same_in_text_and_in_binary() {
    let (_, triangles, notes) = read("a.stl", TEXT_STL);
    assert_eq!(positions(&triangles), [[[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0]]]);
    assert!(notes[0].contains("white"));
    assert_eq!(read("a.stl", binary_stl()).1, triangles);
}

#[test]
fn stl_that_is_wrong_is_refused_with_its_place() {
    let refused = |from: &str, to: &str| refused("a.stl", TEXT_STL.replace(from, to));
    assert_eq!(refused("vertex 1 1 0\n", ""), "a.stl, line 7: a facet has fewer than three vertices");
    assert_eq!(refused("vertex 1 1 0", "vertex 1 1"), "a.stl, line 6: this line belongs into no STL text");
    assert_eq!(refused("vertex 1 1 0", "vertex 1 1 a"), "a.stl, line 6: a vertex wants three numbers");
    assert!(refused("endsolid square\n", "").contains("ends without endsolid"));
    let mut bytes = binary_stl();
    bytes[0] = b'x';
    bytes[80..84].copy_from_slice(&40_000_000u32.to_le_bytes());
    let message = super::tests::refused("a.stl", &bytes);
    assert_eq!(
        message,
        "a.stl, byte 80: the header tells of 40000000 triangles, which 134 bytes do not hold"
    );
    assert!(super::tests::refused("a.stl", "x").contains("ends within its header"));
}

/// The bytes of a square's buffer: four corners, four colours, the indices of two triangles.
fn square() -> Vec<u8> {
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
    bytes.extend([255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255]);
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|index| index.to_le_bytes()));
    bytes
}

/// A document of [`square`], turned by a quarter about z and moved by its nodes.
fn gltf_document(uri: &str) -> String {
    let uri = if uri.is_empty() { String::new() } else { format!("\"uri\":\"{uri}\",") };
    format!(
        r#"{{"asset":{{"version":"2.0"}},"scene":0,"scenes":[{{"nodes":[0]}}],
        "nodes":[{{"translation":[10,0,0],"children":[1]}},{{"rotation":[0,0,0.70710678,0.70710678],"scale":[2,2,2],"mesh":0}}],
        "meshes":[{{"primitives":[{{"attributes":{{"POSITION":0,"COLOR_0":1}},"indices":2,"material":0}}]}}],
        "materials":[{{"pbrMetallicRoughness":{{"baseColorFactor":[1,0.5,1,1]}}}}],
        "accessors":[{{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3","min":[0,0,0],"max":[1,1,0]}},
        {{"bufferView":1,"componentType":5121,"normalized":true,"count":4,"type":"VEC4"}},
        {{"bufferView":2,"componentType":5123,"count":6,"type":"SCALAR"}}],
        "bufferViews":[{{"buffer":0,"byteLength":48}},{{"buffer":0,"byteOffset":48,"byteLength":16}},
        {{"buffer":0,"byteOffset":64,"byteLength":12}}],
        "buffers":[{{{uri}"byteLength":76}}]}}"#
    )
}

fn glb() -> Vec<u8> {
    let mut document = gltf_document("").into_bytes();
    document.resize(document.len().next_multiple_of(4), b' ');
    let square = square();
    let mut bytes = b"glTF".to_vec();
    bytes.extend(2u32.to_le_bytes());
    bytes.extend((28 + document.len() as u32 + square.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &document), (b"BIN\0", &square)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk.iter());
    }
    bytes
}

#[test]
fn gltf_is_the_same_with_its_buffer_beside_it_within_it_and_in_one_file() {
    let (_, triangles, notes) = read("a.glb", glb());
    assert!(notes.is_empty(), "{notes:?}");
    let rounded =
        |triangle: &[Vector; 3]| triangle.map(|corner| corner.map(|value| (value * 1e4).round() / 1e4));
    let found: Vec<[Vector; 3]> = positions(&triangles).iter().map(rounded).collect();
    assert_eq!(found[0], [[10.0, 0.0, 0.0], [10.0, 2.0, 0.0], [8.0, 2.0, 0.0]]);
    assert_eq!(triangles[0].map(|corner| corner.light), [[1.0, 0.0, 0.0], [0.0, 0.5, 0.0], [0.0, 0.0, 1.0]]);
    use base64::Engine;
    let within = base64::engine::general_purpose::STANDARD.encode(square());
    let uri = format!("data:application/octet-stream;base64,{within}");
    assert_eq!(read("a.gltf", gltf_document(&uri)).1, triangles);
    let document = gltf_document("my%20square.bin");
    let on_disk = folder(&[("a.gltf", document.as_bytes()), ("my square.bin", &square())]);
    assert_eq!(on_disk.read().unwrap().1, triangles);
    assert_eq!(Model::open(&on_disk.path).unwrap().files().len(), 2);
}

#[test]
fn gltf_that_is_wrong_is_refused_with_its_place() {
    let whole = String::from_utf8_lossy(&glb()).into_owned();
    assert!(whole.contains("POSITION"));
    let refused = |from: &str, to: &str| {
        let document = gltf_document("square.bin");
        assert!(document.contains(from), "{from}");
        let document = document.replacen(from, to, 1);
        let on_disk = folder(&[("a.gltf", document.as_bytes()), ("square.bin", &square())]);
        let message = on_disk.read().unwrap_err().to_string();
        message.replace(&on_disk.path.display().to_string(), "a.gltf")
    };
    for (from, to, wanted) in [
        ("\"POSITION\":0", "\"POSITION\":7", "a.gltf, accessors[7]: it is named, but not there"),
        ("\"POSITION\":0", "\"NORMAL\":0", "it has no POSITION"),
        ("\"mesh\":0", "\"mesh\":3", "meshes[3]: a node names this mesh"),
        ("\"children\":[1]", "\"children\":[0]", "nodes[0]: the node stands in two places, or within itself"),
        ("\"children\":[1]", "\"children\":[9]", "nodes[9]: a scene or node names this node"),
        (
            "\"count\":4",
            "\"count\":4000000000",
            "accessors[0]: it tells of more items than the buffers can hold",
        ),
        ("\"count\":4", "\"count\":40", "accessors[0]: its items reach beyond its bufferView"),
        ("\"byteLength\":48", "\"byteLength\":480", "accessors[0]: its bufferView lies beyond the buffers"),
        (
            "\"byteLength\":76",
            "\"byteLength\":2000000000",
            "buffers[0]: it tells of 2000000000 bytes, but there are 76",
        ),
        ("square.bin", "none.bin", "none.bin"),
        ("square.bin", "../square.bin", "names the file ../square.bin"),
        ("square.bin", "%2e%2e/square.bin", "names the file ../square.bin"),
        ("\"asset\"", "asset", "a.gltf, line 1"),
        (
            "\"scene\":0",
            "\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]",
            "is compressed by KHR_draco",
        ),
        ("\"count\":6", "\"count\":5", ""),
    ] {
        if wanted.is_empty() {
            continue;
        }
        let message = refused(from, to);
        assert!(message.contains(wanted), "{from} -> {to}: {message}");
    }
    let mut bytes = glb();
    bytes[8] = 3;
    assert!(read("a.glb", &bytes).1.len() == 2, "a wrong length of the whole does no harm");
    bytes[12] = 0xff;
    bytes[15] = 0xff;
    assert_eq!(
        super::tests::refused("a.glb", &bytes),
        "a.glb, byte 12: a chunk reaches beyond the end of the file"
    );
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]
    #[test]
    fn damaged_meshes_and_scans_never_panic((changes, length) in damage()) {
        survives("a.stl", TEXT_STL.as_bytes(), &changes, length);
        survives("a.stl", &binary_stl(), &changes, length);
        survives("a.glb", &glb(), &changes, length);
        survives("a.las", &las(2, 9, 255, false), &changes, length);
        survives("a.laz", &las(2, 90, 60_000, true), &changes, length);
        survives("a.laz", &las(7, 90, 60_000, true), &changes, length);
    }
}
