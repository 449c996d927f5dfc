//! Colours by a picture's own ICC profile.

use image::DynamicImage;
use moxcms::{CmsError, ColorProfile, DataColorSpace, Layout, TransformOptions};

/// Values that differ by less than this from sRGB's are left as they are: half a step of 8 bits.
const SAME: f32 = 0.5 / 255.0;

/// Whether a profile is one of values that are still there once a file is decoded: of RGB or grey.
pub(super) fn is_of_pictures(profile: &ColorProfile) -> bool {
    matches!(profile.color_space, DataColorSpace::Rgb | DataColorSpace::Gray)
}

/// What is told of a profile that cannot be used.
pub(super) fn unusable(error: &CmsError) -> String {
    format!("its ICC profile cannot be used ({error}); export it as sRGB")
}

/// Turns a picture from the colours of its ICC `profile` to sRGB. Profiles of other kinds than RGB and grey are left
/// alone: what they describe is no longer there once the file is decoded.
///
/// # Errors
/// When the profile cannot be used.
pub(super) fn to_srgb(image: DynamicImage, profile: &[u8]) -> Result<DynamicImage, String> {
    let fail = |error: CmsError| unusable(&error);
    let profile = ColorProfile::new_from_slice(profile).map_err(fail)?;
    if !is_of_pictures(&profile) {
        return Ok(image);
    }
    let grey = profile.color_space == DataColorSpace::Gray;
    let layout = if grey { Layout::Gray } else { Layout::Rgb };
    let transform = profile
        .create_transform_f32(layout, &ColorProfile::new_srgb(), Layout::Rgb, TransformOptions::default())
        .map_err(fail)?;
    let convert = |pixels: &[[f32; 3]]| -> Result<Vec<f32>, String> {
        let given: Vec<f32> = match grey {
            true => pixels.iter().map(|pixel| pixel[0]).collect(),
            false => pixels.as_flattened().to_vec(),
        };
        let mut converted = vec![0.0; pixels.len() * 3];
        transform.transform(&given, &mut converted).map_err(fail)?;
        Ok(converted)
    };
    let probe: Vec<[f32; 3]> = (0..64)
        .map(|index| [index % 4, index / 4 % 4, index / 16].map(|step| step as f32 / 3.0))
        .map(|pixel| if grey { [pixel[0]; 3] } else { pixel })
        .collect();
    let same = convert(&probe)?.iter().zip(probe.as_flattened()).all(|(a, b)| (a - b).abs() < SAME);
    if same {
        return Ok(image);
    }
    let mut image = image.into_rgba32f();
    let (width, count) = (image.width() as usize, CHANNELS_WITH_ALPHA);
    for row in image.chunks_exact_mut(width * count) {
        let colours: Vec<[f32; 3]> =
            row.chunks_exact(count).map(|pixel| [pixel[0], pixel[1], pixel[2]]).collect();
        let converted = convert(&colours)?;
        for (pixel, colour) in row.chunks_exact_mut(count).zip(converted.chunks_exact(3)) {
            pixel[..3].copy_from_slice(colour);
        }
    }
    Ok(image.into())
}

/// Values of a pixel of the pictures that are converted.
const CHANNELS_WITH_ALPHA: usize = 4;
