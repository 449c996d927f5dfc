//! Photographs that light is measured in.

use std::fmt;
use std::path::Path;

use image::DynamicImage;
use moxcms::{CmsError, ColorProfile, ProfileText};

use super::decode::{Fault, Undecoded, read};
use super::{Picture, PictureError, colour};
use crate::volume::CHANNELS;

/// A photograph's light, in the colours of the camera's channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Photograph {
    /// Light of each pixel, 0..=1 of what the channel holds.
    pub light: Picture,
    /// How the file's values became light.
    pub tones: Tones,
}

/// How a photograph's values stand for light.
#[derive(Clone, Debug, PartialEq)]
pub enum Tones {
    /// By sRGB's curve (IEC 61966-2-1), for the file has no profile that says otherwise.
    AssumedSrgb,
    /// By the curves of the file's ICC profile, which has this name.
    Profile(String),
    /// Light is this power of a value, as whoever took the photograph says.
    Gamma(f64),
}

impl Photograph {
    /// Reads a JPEG, PNG, TIFF or WebP file; `gamma` goes before what the file says of itself.
    ///
    /// Each channel is decoded by itself. The colours of another profile's channels are not turned to those of sRGB: it
    /// would mix an ink's channel with the others, and push it beyond its end where the profile's gamut is the wider one.
    ///
    /// # Errors
    /// As [`Picture::read`].
    pub fn read(path: &Path, gamma: Option<f64>) -> Result<Self, PictureError> {
        let Undecoded { image, profile } = read(path)?;
        let profile = profile.filter(|_| gamma.is_none());
        let decoded = profile.and_then(|profile| by_profile(&image, &profile).transpose()).transpose();
        let decoded = decoded.map_err(|cause| Fault::Damaged(cause).at(path))?;
        Ok(decoded.unwrap_or_else(|| {
            let values = Picture::from_image(&image, 1);
            match gamma {
                Some(gamma) => {
                    let light = values.map(|value| value.powf(gamma as f32));
                    Self { light, tones: Tones::Gamma(gamma) }
                }
                None => Self { light: values.decoded(), tones: Tones::AssumedSrgb },
            }
        }))
    }
}

impl fmt::Display for Tones {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AssumedSrgb => f.write_str("sRGB, which is assumed: the file has no colour profile"),
            Self::Profile(name) => write!(f, "its colour profile, {name}"),
            Self::Gamma(gamma) => write!(f, "the gamma of {gamma} that was given"),
        }
    }
}

/// Decodes an image by its `profile`; `None` where that is not one of the image's values, as with a file in CMYK.
fn by_profile(image: &DynamicImage, profile: &[u8]) -> Result<Option<Photograph>, String> {
    let fail = |error: CmsError| colour::unusable(&error);
    let read = ColorProfile::new_from_slice(profile).map_err(fail)?;
    let tones = Tones::Profile(name(&read));
    if !colour::is_of_pictures(&read) {
        return Ok(None);
    }
    let curves = match (&read.red_trc, &read.green_trc, &read.blue_trc) {
        (Some(red), Some(green), Some(blue)) if read.is_matrix_shaper() => [red, green, blue],
        // Grey, and tables of colours: only the whole way to sRGB undoes them.
        _ => {
            let converted = colour::to_srgb(image.clone(), profile)?;
            return Ok(Some(Photograph { light: Picture::from_image(&converted, 1).decoded(), tones }));
        }
    };
    let mut light = Picture::from_image(image, 1);
    for (channel, curve) in (0..CHANNELS).zip(curves) {
        let curve = curve.make_linear_evaluator().map_err(fail)?;
        // One for each value that a file of 16 bits may have: of 8 bits each has its own, too.
        let table: Vec<f32> = (0..=u16::MAX)
            .map(|value| curve.evaluate_value(f32::from(value) / FULL).clamp(0.0, 1.0))
            .collect();
        for value in light.channel_mut(channel) {
            *value = table[(*value * FULL).round() as u16 as usize];
        }
    }
    Ok(Some(Photograph { light, tones }))
}

/// The largest value of 16 bits.
const FULL: f32 = u16::MAX as f32;

/// What a profile calls itself.
fn name(profile: &ColorProfile) -> String {
    let name = match &profile.description {
        Some(ProfileText::PlainString(text)) => text.as_str(),
        Some(ProfileText::Localizable(texts)) => texts.first().map_or("", |text| text.value.as_str()),
        Some(ProfileText::Description(text)) if !text.unicode_string.is_empty() => &text.unicode_string,
        Some(ProfileText::Description(text)) => &text.ascii_string,
        None => "",
    };
    let name = name.trim_matches(|letter: char| letter.is_whitespace() || letter == '\0');
    if name.is_empty() { "without a name".to_owned() } else { name.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use image::{ExtendedColorType, ImageEncoder};
    use moxcms::{ToneReprCurve, curve_from_gamma};

    const PIXEL: [u8; 3] = [250, 100, 50];

    fn written(profile: Option<&ColorProfile>, gamma: Option<f64>) -> Photograph {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("photo.png");
        let mut bytes = Vec::new();
        let mut encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        if let Some(profile) = profile {
            encoder.set_icc_profile(profile.encode().unwrap()).unwrap();
        }
        encoder.write_image(&PIXEL, 1, 1, ExtendedColorType::Rgb8).unwrap();
        std::fs::write(&path, bytes).unwrap();
        Photograph::read(&path, gamma).unwrap()
    }

    fn assert_light(photograph: &Photograph, light: impl Fn(f64) -> f64) {
        for (found, value) in photograph.light.values().iter().zip(PIXEL) {
            let wanted = light(f64::from(value) / 255.0);
            assert!((f64::from(*found) - wanted).abs() < 2e-4, "{found}, {wanted} wanted: {photograph:?}");
        }
    }

    fn srgb(value: f64) -> f64 {
        f64::from(super::super::srgb_decode(value as f32))
    }

    #[test]
    fn each_channel_is_decoded_by_the_profiles_own_curve() {
        let mut eighteen = ColorProfile::new_adobe_rgb();
        let curve = curve_from_gamma(1.8);
        (eighteen.red_trc, eighteen.green_trc, eighteen.blue_trc) =
            (Some(curve.clone()), Some(curve.clone()), Some(curve));
        assert_light(&written(Some(&eighteen), None), |value| value.powf(1.8));
        let adobe = written(Some(&ColorProfile::new_adobe_rgb()), None);
        assert_light(&adobe, |value| value.powf(2.199_218_75));
        assert!(adobe.tones.to_string().contains("Adobe RGB"), "{}", adobe.tones);
        // Its red is beyond sRGB's: turned to that, 250 would be at the end and a ninth of green taken off.
        assert_light(&written(Some(&ColorProfile::new_display_p3()), None), srgb);
        eighteen.green_trc = Some(ToneReprCurve::Lut(vec![0, u16::MAX / 4, u16::MAX]));
        let table = written(Some(&eighteen), None);
        let wanted = 100.0 / 255.0 / 2.0;
        assert!((f64::from(table.light.channel(1)[0]) - wanted).abs() < 1e-3, "{table:?}");
    }

    #[test]
    fn without_a_profile_srgb_is_assumed_and_what_is_given_goes_before_all() {
        let plain = written(None, None);
        assert_eq!(plain.tones, Tones::AssumedSrgb);
        assert_light(&plain, srgb);
        for profile in [None, Some(&ColorProfile::new_adobe_rgb())] {
            let given = written(profile, Some(1.8));
            assert_eq!(given.tones, Tones::Gamma(1.8));
            assert_light(&given, |value| value.powf(1.8));
        }
    }

    #[test]
    fn a_grey_profile_is_decoded_and_one_of_other_values_is_none_of_the_pictures() {
        let grey = written(Some(&ColorProfile::new_gray_with_gamma(1.8)), None);
        assert!(matches!(grey.tones, Tones::Profile(_)), "{:?}", grey.tones);
        let wanted = (250.0_f32 / 255.0).powf(1.8);
        assert!((grey.light.channel(1)[0] - wanted).abs() < 2e-3, "{grey:?}");
    }
}
