//! What a film emits where ultraviolet meets its ink: saturation, yields and the print's blur.
//!
//! Full ink of absorbance a takes up the part `1 - exp(-a)` of the ultraviolet that falls on it, and what it takes up it
//! gives back as light (Wu, Merchant and Castleman, "Microscope Image Processing", 2008, eq. 12.22: the light emitted
//! is `phi I (1 - exp(-A))`). As a part of what full ink emits, the ink v glows with
//!
//! ```text
//! s(v) = (1 - exp(-a v)) / (1 - exp(-a)),
//! ```
//!
//! which is v itself for faint absorption. That glow times the ink's yield spreads in the film as
//! [`Spread`](crate::spread) says. From glow to light all is linear, so designs are solved for the glow, and the ink
//! that gives it is `v = -ln(1 - s (1 - exp(-a))) / a`.

use std::borrow::Cow;

use rayon::prelude::*;

use crate::spread::Spread;
use crate::stack::Stack;
use crate::volume::{CHANNELS, Volume};

/// Absorbance below which the curve differs from a straight line by less than 16 bits tell.
const FAINT: f64 = 1e-5;

/// How a stack's films turn ink into light; `default()` leaves ink as it is, as ideal films do.
#[derive(Clone, Debug, PartialEq)]
pub struct Emission {
    yields: [f32; CHANNELS],
    absorbance: f64,
    print: Spread,
}

impl Default for Emission {
    fn default() -> Self {
        Self { yields: [1.0; CHANNELS], absorbance: 0.0, print: Spread::NONE }
    }
}

impl Emission {
    /// The emission of the stack's own films.
    pub fn of(stack: &Stack) -> Self {
        Self {
            yields: stack.ink_yields.map(|part| part as f32),
            absorbance: stack.ink_absorbance,
            print: Spread::of_variance(stack.blur_variance_px()),
        }
    }

    /// Light of the three inks where they glow alike, 0..=1: red, green, blue.
    pub fn yields(&self) -> [f32; CHANNELS] {
        self.yields
    }

    /// Light that all three inks can give alike, 0..=1: the least yield. It is the whitest white of full ink.
    pub fn white(&self) -> f64 {
        self.yields.into_iter().map(f64::from).fold(1.0, f64::min)
    }

    /// Returns the glow of the ink `ink`, 0..=1, as a part of full ink's.
    pub fn glow(&self, ink: f64) -> f64 {
        if self.is_straight() { ink } else { (-self.absorbance * ink).exp_m1() / (-self.absorbance).exp_m1() }
    }

    /// Returns the ink that glows with `glow`, 0..=1: the inverse of [`Emission::glow`].
    pub fn ink(&self, glow: f64) -> f64 {
        if self.is_straight() {
            glow
        } else {
            -(glow * (-self.absorbance).exp_m1()).ln_1p() / self.absorbance
        }
    }

    /// Returns the glow of a volume's ink.
    pub fn glow_of<'a>(&self, ink: &'a Volume) -> Cow<'a, Volume> {
        if self.is_straight() {
            return Cow::Borrowed(ink);
        }
        let mut glow = ink.clone();
        bend(glow.values_mut(), |ink| self.glow(ink));
        Cow::Owned(glow)
    }

    /// Turns glow into the ink that glows so.
    pub fn turn_into_ink(&self, glow: &mut [f32]) {
        if !self.is_straight() {
            bend(glow, |glow| self.ink(glow));
        }
    }

    /// Returns the light of a volume of glow: times the yields, spread by the print. The map is its own transpose.
    pub fn light_of_glow<'a>(&self, glow: Cow<'a, Volume>) -> Cow<'a, Volume> {
        if self.yields == [1.0; CHANNELS] && self.print.is_none() {
            return glow;
        }
        let mut light = glow.into_owned();
        let size = (light.width(), light.height());
        for channel in 0..CHANNELS {
            self.spread_light(light.channel_mut(channel), channel, size);
        }
        Cow::Owned(light)
    }

    /// Turns the glow of one channel's films, each of so many columns and rows, into its light.
    pub(crate) fn spread_light(&self, films: &mut [f32], channel: usize, (width, height): (usize, usize)) {
        let part = self.yields[channel];
        if part != 1.0 {
            films.par_iter_mut().for_each(|value| *value *= part);
        }
        self.print.apply(films, width, height);
    }

    /// Returns the light of a volume's ink.
    pub fn light<'a>(&self, ink: &'a Volume) -> Cow<'a, Volume> {
        self.light_of_glow(self.glow_of(ink))
    }

    fn is_straight(&self) -> bool {
        self.absorbance < FAINT
    }
}

fn bend(values: &mut [f32], curve: impl Fn(f64) -> f64 + Sync) {
    values.par_iter_mut().for_each(|value| *value = curve(f64::from(*value)) as f32);
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn stack(blur_um: f64, ink_yields: [f64; 3], ink_absorbance: f64) -> Stack {
        Stack {
            films: 2,
            width_px: 9,
            height_px: 7,
            width_mm: 0.9,
            blur_um,
            ink_yields,
            ink_absorbance,
            ..Stack::default()
        }
    }

    fn ramp(stack: &Stack) -> Volume {
        let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
        let values = volume.values_mut().iter_mut().enumerate();
        values.for_each(|(index, value)| *value = (index * 37 % 101) as f32 / 100.0);
        volume
    }

    proptest! {
        #[test]
        fn ink_and_glow_are_each_others_inverse(ink in 0.0..1.0f64, absorbance in 0.0..5.0f64) {
            let emission = Emission::of(&stack(0.0, [1.0; 3], absorbance));
            prop_assert!((emission.ink(emission.glow(ink)) - ink).abs() < 1e-9);
            prop_assert!(emission.glow(ink) >= ink - 1e-12, "the glow rises ever more slowly");
            prop_assert_eq!((emission.glow(0.0), emission.ink(0.0)), (0.0, 0.0));
            prop_assert!((emission.glow(1.0) - 1.0).abs() < 1e-12);
        }

        #[test]
        fn light_of_glow_is_its_own_transpose(blur_um in 0.0..300.0f64, green in 0.1..1.0f64) {
            let stack = stack(blur_um, [0.43, green, 0.89], 0.0);
            let emission = Emission::of(&stack);
            let (one, mut other) = (ramp(&stack), ramp(&stack));
            other.values_mut().reverse();
            let dot = |a: &Volume, b: &Volume| -> f64 {
                a.values().iter().zip(b.values()).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
            };
            let forward = dot(&emission.light(&one), &other);
            let back = dot(&one, &emission.light(&other));
            prop_assert!((forward - back).abs() < 1e-5 * forward, "{} {}", forward, back);
        }
    }

    #[test]
    fn the_glow_follows_its_formula() {
        let emission = Emission::of(&stack(0.0, [1.0; 3], 2.0));
        assert!((emission.glow(0.5) - 0.731_058_578_6).abs() < 1e-9);
    }

    #[test]
    fn defaults_leave_ink_as_it_is() {
        let volume = ramp(&Stack { films: 2, width_px: 9, height_px: 7, ..Stack::default() });
        assert!(matches!(Emission::of(&Stack::default()).light(&volume), Cow::Borrowed(_)));
        assert_eq!(Emission::of(&Stack::default()), Emission::default());
    }

    #[test]
    fn blur_is_in_micrometres_and_yields_are_by_channel() {
        let stack = stack(100.0, [0.5, 1.0, 1.0], 0.0);
        let mut volume = Volume::new(2, 7, 9);
        for channel in [0, 1] {
            volume.film_mut(channel, 1)[3 * 9 + 4] = 1.0;
        }
        let light = Emission::of(&stack).light(&volume);
        // A pixel is 100 µm wide: exp(-1) I_0(1) = 0.4658 of its light stays in its column, as in its row.
        let peak = light.film(1, 1)[3 * 9 + 4];
        assert!((f64::from(peak) - 0.4658f64.powi(2)).abs() < 1e-3, "{peak}");
        assert_eq!(light.film(0, 1)[3 * 9 + 4], 0.5 * peak);
        assert_eq!(light.film(0, 0), &[0.0; 63]);
    }
}
