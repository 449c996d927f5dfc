//! Textures of glTF: which are read, and how they lie.

use crate::config::ObjectSettings;
use crate::object::Model;
use crate::object::model::tests::{OnDisk, folder};

/// Two nodes with a triangle each, of the material `shown`; the other of the two is of nothing in the scene. `transform`
/// stands in the texture that is shown.
fn document(shown: usize, transform: &str) -> String {
    use base64::Engine;
    let corners = [[0.0f32, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]].concat();
    let places = [[0.0f32, 0.0], [1.0, 0.0], [0.0, 0.5]].concat();
    let bytes: Vec<u8> = corners.iter().chain(&places).flat_map(|value| value.to_le_bytes()).collect();
    let data = base64::engine::general_purpose::STANDARD.encode(bytes);
    format!(
        r#"{{"asset": {{"version": "2.0"}}, "scene": 0, "scenes": [{{"nodes": [0]}}],
        "nodes": [{{"children": [1]}}, {{"mesh": {shown}}}, {{"mesh": {other}}}],
        "meshes": [{{"primitives": [{{"material": 0, "attributes": {{"POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_1": 1}}}}]}},
            {{"primitives": [{{"material": 1, "attributes": {{"POSITION": 0}}}}]}}],
        "materials": [{{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 0, "texCoord": 3{transform}}}}}}},
            {{"pbrMetallicRoughness": {{"baseColorTexture": {{"index": 1}}}}}}],
        "textures": [{{"source": 0}}, {{"source": 1}}], "images": [{{"uri": "brick.png"}}, {{"uri": "../outside.png"}}],
        "accessors": [{{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3", "min": [0, 0, 0], "max": [1, 1, 0]}},
            {{"bufferView": 0, "byteOffset": 36, "componentType": 5126, "count": 3, "type": "VEC2"}}],
        "bufferViews": [{{"buffer": 0, "byteLength": 60}}],
        "buffers": [{{"byteLength": 60, "uri": "data:application/octet-stream;base64,{data}"}}]}}"#,
        other = 1 - shown,
    )
}

fn with_brick(document: &str) -> OnDisk {
    let mut brick = Vec::new();
    let pixels = image::RgbImage::from_pixel(2, 2, image::Rgb([255, 0, 0]));
    pixels.write_to(&mut std::io::Cursor::new(&mut brick), image::ImageFormat::Png).unwrap();
    folder(&[("a.gltf", document.as_bytes()), ("brick.png", &brick)])
}

#[test]
fn textures_that_the_scene_does_not_show_are_not_looked_for() {
    let (_, triangles, notes) = with_brick(&document(0, "")).read().unwrap();
    assert_eq!((triangles.len(), notes), (1, Vec::<String>::new()));
    let refused = with_brick(&document(1, "")).read().unwrap_err().to_string();
    assert!(refused.ends_with("names the file ../outside.png, which is not in its folder"), "{refused}");
}

#[test]
fn textures_are_moved_turned_and_scaled() {
    let places = |transform: &str| {
        let text = document(0, &format!(", \"extensions\": {{\"KHR_texture_transform\": {{{transform}}}}}"));
        let (_, triangles, notes) = with_brick(&text).read().unwrap();
        assert!(notes.is_empty(), "{notes:?}");
        triangles[0].map(|corner| corner.texture.map(|value| (value * 1e4).round() / 1e4))
    };
    // The coordinates that it names count in place of those of the texture, which are not there.
    assert_eq!(places(""), [[0.0, 0.0]; 3]);
    assert_eq!(places("\"texCoord\": 1"), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]]);
    let moved = "\"texCoord\": 0, \"offset\": [0.25, 0.5], \"scale\": [2, 4]";
    assert_eq!(places(moved), [[0.25, 0.5], [2.25, 0.5], [0.25, 2.5]]);
    // A quarter against the clock takes what is to the right upwards: down is positive.
    let turned = "\"texCoord\": 0, \"rotation\": 1.5707963267948966";
    assert_eq!(places(turned), [[0.0, 0.0], [0.0, -1.0], [0.5, 0.0]]);
}

#[test]
fn a_material_of_gloss_has_the_colour_that_it_scatters() {
    let text = document(1, "").replace(
        "{\"pbrMetallicRoughness\": {\"baseColorTexture\": {\"index\": 1}}}",
        "{\"extensions\": {\"KHR_materials_pbrSpecularGlossiness\": {\"diffuseFactor\": [0.5, 0.25, 1, 1],
        \"diffuseTexture\": {\"index\": 0}}}}",
    );
    let on_disk = with_brick(&text);
    assert_eq!(on_disk.read().unwrap().1[0][0].light, [0.5, 0.25, 1.0]);
    assert_eq!(Model::open(&on_disk.path).unwrap().files().len(), 2);
}

#[test]
fn a_model_of_lines_alone_says_so() {
    let text = document(0, "").replace("{\"material\": 0, \"attributes\"", "{\"mode\": 1, \"attributes\"");
    let on_disk = with_brick(&text);
    let stack = crate::stack::Stack::default();
    let Err(refused) = crate::object::slice(&on_disk.path, &ObjectSettings::default(), &stack, &[]) else {
        panic!("lines were laid");
    };
    assert!(refused.to_string().contains("primitives[0] is lines: they are left out"), "{refused}");
}
