use super::*;
use proptest::prelude::*;

fn photo(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("photos").join(name)
}

proptest! {
    #[test]
    fn a_written_png_comes_back(pixels in proptest::collection::vec(any::<u8>(), 3 * 5 * 4)) {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("picture.png");
        write_png_rgb8(&path, &pixels, 5, 4).unwrap();
        let picture = Picture::read(&path).unwrap();
        prop_assert_eq!((picture.width(), picture.height()), (5, 4));
        prop_assert_eq!(picture.rgb8(), pixels);
    }
}

#[test]
fn a_photograph_of_the_right_size_passes_unchanged() {
    let read = Picture::read(&photo("cat.jpg")).unwrap();
    let fitted = Picture::read_fitted(&photo("cat.jpg"), 512, 512).unwrap();
    assert_eq!(read, fitted);
}

#[test]
fn a_wide_picture_is_cropped_about_its_centre() {
    let mut wide = Picture::new(9, 3);
    for channel in 0..CHANNELS {
        for row in 0..3 {
            wide.channel_mut(channel)[row * 9 + 3..row * 9 + 6].fill(0.5);
        }
    }
    let square = wide.fitted(3, 3).unwrap();
    assert!(square.values().iter().all(|value| (value - 0.5).abs() < 1e-4), "{:?}", square.values());
}

#[test]
fn resizing_averages_light_not_code_values() {
    let mut stripes = Picture::new(64, 64);
    for (index, value) in stripes.values_mut().iter_mut().enumerate() {
        *value = if index % 2 == 0 { 1.0 } else { 0.0 };
    }
    let small = stripes.fitted(8, 8).unwrap();
    let middle = small.channel(1)[4 * 8 + 4];
    assert!((srgb_decode(middle) - 0.5).abs() < 0.02, "{middle}");
}

#[test]
fn a_much_larger_picture_is_averaged_in_light_before_it_is_resized() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("large.png");
    // Rows of black and white pixels above, white below; odd, so that some are left over.
    let pixels: Vec<u8> = (0..67 * 131)
        .flat_map(|index| [if index / 67 > 64 || index / 67 % 2 == 0 { 255 } else { 0 }; 3])
        .collect();
    write_png_rgb8(&path, &pixels, 67, 131).unwrap();
    assert_eq!(Picture::check(&path).unwrap(), [67, 131]);
    let small = Picture::read_for(&path, 4, 8).unwrap();
    assert_eq!((small.width(), small.height()), (16, 32));
    assert!((srgb_decode(small.channel(0)[3 * 16 + 3]) - 0.5).abs() < 1e-3);
    assert!((small.channel(2)[30 * 16 + 3] - 1.0).abs() < 1e-3);
    let fitted = Picture::read_fitted(&path, 4, 8).unwrap();
    assert_eq!((fitted.width(), fitted.height()), (4, 8));
}

#[test]
fn a_picture_of_too_many_pixels_is_refused_before_it_is_decoded() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("bomb.png");
    let mut bytes = Vec::new();
    // The beginning of a PNG of 40,000 x 40,000 pixels.
    let mut encoder = png::Encoder::new(&mut bytes, 40_000, 40_000);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_chunk(png::chunk::IDAT, &[0x78, 0x01]).unwrap();
    std::fs::write(&path, &bytes).unwrap();
    let message = Picture::read(&path).unwrap_err().to_string();
    assert!(message.contains("40000 x 40000 pixels") && message.contains("scale it down"), "{message}");
}

#[test]
fn a_cut_photograph_is_an_error_that_names_the_file() {
    let bytes = std::fs::read(photo("coffee.jpg")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.jpg");
    for length in [bytes.len() / 2, bytes.len() - 40, 10] {
        std::fs::write(&path, &bytes[..length]).unwrap();
        let message = Picture::read(&path).unwrap_err().to_string();
        assert!(message.contains("cut.jpg") && message.contains("copy or export it again"), "{message}");
    }
}

#[test]
fn a_text_file_is_no_picture() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("notes.png");
    std::fs::write(&path, "these are notes").unwrap();
    assert!(matches!(Picture::read(&path), Err(PictureError::Damaged { .. })));
    assert!(matches!(Picture::read(&folder.path().join("none.png")), Err(PictureError::Unreadable { .. })));
}

#[test]
fn transparent_parts_lie_over_black_and_sixteen_bits_are_kept() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("half.png");
    let pixel = image::Rgba([40_001u16, 65_535, 0, 32_768]);
    image::ImageBuffer::from_pixel(2, 2, pixel).save(&path).unwrap();
    let picture = Picture::read(&path).unwrap();
    let alpha = 32_768.0 / 65_535.0;
    assert!((picture.channel(0)[0] - 40_001.0 / 65_535.0 * alpha).abs() < 1e-6);
    assert!((picture.channel(1)[3] - alpha).abs() < 1e-6);
    assert_eq!(picture.channel(2)[0], 0.0);
}

#[test]
fn the_cameras_orientation_is_applied() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("turned.jpg");
    let image = image::RgbImage::from_fn(16, 8, |x, _| image::Rgb([if x < 8 { 250 } else { 5 }; 3]));
    let mut jpeg = Vec::new();
    image::codecs::jpeg::JpegEncoder::new_with_quality(&mut jpeg, 95).encode_image(&image).unwrap();
    // An EXIF segment with orientation 6: turn a quarter clockwise.
    let exif = b"Exif\0\0MM\0\x2a\0\0\0\x08\0\x01\x01\x12\0\x03\0\0\0\x01\0\x06\0\0\0\0\0\0";
    let mut turned = jpeg[..2].to_vec();
    turned.extend([0xFF, 0xE1, 0, exif.len() as u8 + 2]);
    turned.extend(exif);
    turned.extend(&jpeg[2..]);
    std::fs::write(&path, turned).unwrap();
    let picture = Picture::read(&path).unwrap();
    assert_eq!((picture.width(), picture.height()), (8, 16));
    assert!(picture.channel(0)[0] > 0.9 && picture.channel(0)[15 * 8] < 0.1);
}

#[test]
fn a_picture_is_drawn_out_about_its_centre() {
    let mut picture = Picture::new(5, 3);
    picture.channel_mut(0)[5..10].copy_from_slice(&[0.0, 1.0, 2.0, 3.0, 4.0]);
    assert_eq!(picture.drawn_out(1.0, 1.0), picture);
    assert_eq!(picture.drawn_out(0.5, 1.0).channel(0)[5..10], [1.0, 1.5, 2.0, 2.5, 3.0]);
    assert_eq!(picture.drawn_out(2.0, 1.0).channel(0)[5..10], [0.0, 0.0, 2.0, 4.0, 0.0]);
    assert_eq!(picture.drawn_out(1.0, 2.0).channel(0)[5..10], picture.channel(0)[5..10]);
    assert_eq!(picture.drawn_out(1.0, 0.5).channel(0)[2], 1.0);
}

#[test]
fn colours_of_another_profile_become_srgb() {
    use moxcms::ColorProfile;
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("wide.png");
    let written = |profile: Option<Vec<u8>>, pixel: [u8; 3]| {
        let mut bytes = Vec::new();
        let mut encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        if let Some(profile) = profile {
            encoder.set_icc_profile(profile).unwrap();
        }
        encoder.write_image(&pixel, 1, 1, image::ExtendedColorType::Rgb8).unwrap();
        std::fs::write(&path, bytes).unwrap();
        Picture::read(&path)
    };
    let pixel = [200, 100, 50];
    let plain = written(None, pixel).unwrap();
    assert_eq!(written(Some(ColorProfile::new_srgb().encode().unwrap()), pixel).unwrap(), plain);
    let wide = written(Some(ColorProfile::new_display_p3().encode().unwrap()), pixel).unwrap();
    // Display P3 (200, 100, 50) is sRGB (214.9, 92.6, 31.0), by its published primaries and sRGB's curve.
    for (value, wanted) in wide.values().iter().zip([214.9, 92.6, 31.0]) {
        assert!((value * 255.0 - wanted).abs() < 1.6, "{:?}", wide.values());
    }
    let damaged = written(Some(vec![7; 200]), pixel).unwrap_err().to_string();
    assert!(damaged.contains("ICC profile") && damaged.contains("export it as sRGB"), "{damaged}");
}

#[test]
fn rows_of_another_size_are_those_of_a_picture_fitted_to_it() {
    let rows = 10..37;
    for fitted_to in [(512, 512), (700, 300)] {
        let path = photo("cat.jpg");
        let prepared = Picture::read_rows(&path, fitted_to.0, fitted_to.1).unwrap();
        // The same shape: the crop does not change.
        let size = (fitted_to.0 / 4, fitted_to.1 / 4);
        let wanted = Picture::read_fitted(&path, size.0, size.1).unwrap().rows(rows.clone());
        let found = prepared.rows(size, rows.clone());
        let far = found.values().iter().zip(wanted.values()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(far < 2e-3, "{fitted_to:?}: {far}");
    }
}
