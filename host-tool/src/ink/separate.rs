//! From film values to the coverage of each ink.
//!
//! With yields y, curves f and film values v, ink i is to give the part w_i = v_i W / y_i of its own full light, where
//! W is the light of the weakest ink at its fullest. How much ink that takes depends on how dots are laid:
//!
//! - Dots that are full or empty ([`Dots::Binary`]), and planes that a raster image processor screens
//!   ([`Dots::Continuous`]): an ink's light follows the part of the spot that it covers, and no other ink's: the
//!   coverage is the inverse of f_i at w_i.
//! - Dots of several sizes ([`Dots::Levels`]): all inks of a spot share its dots, which are all filled to the same
//!   amount t, as little as will do, and ink i takes the part p_i of them. Its light is p_i f_i(t), so t solves
//!   sum w_i / f_i(t) = 1, and the coverage is p_i t. Small dots are what Hersch et al. print to evade quenching.

use super::YIELDS;
use super::curve::Curve;
use crate::volume::CHANNELS;

/// Steps of a search by halving: enough for 16-bit values.
const HALVINGS: usize = 18;

/// From this part of the reach on, [`Gamut::Compress`] gives way.
const KNEE: f32 = 0.8;

/// What becomes of colours that need more ink than the limit. All of them keep the ratio of red, green and blue.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gamut {
    /// They are dimmed to the brightest that the limit allows; all others stay as they are.
    #[default]
    Clip,
    /// As they near the limit, and beyond it, they are dimmed ever more, so that differences remain: with r the need
    /// as a part of the limit, r > 0.8 becomes 0.8 + 0.2 (1 - exp(-(r - 0.8) / 0.2)).
    Compress,
    /// All values are dimmed by the one factor that makes white reach the limit: films stay in proportion.
    Fit,
}

/// How the printer lays dots.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dots {
    /// Planes of coverage, which a raster image processor screens.
    Continuous,
    /// Dots that are full or empty.
    Binary,
    /// Dots of this many levels from none to full, 3..=256.
    Levels(u16),
}

/// The inks, and how they are laid.
#[derive(Clone, Debug, PartialEq)]
pub struct Inks {
    /// Light of each ink at its fullest under the same ultraviolet light: red, green, blue, each greater than 0.
    pub yields: [f64; CHANNELS],
    /// Light of each ink by its coverage.
    pub curves: [Curve; CHANNELS],
    /// The most that the coverages of a spot add up to, greater than 0: at most 1 where dots lie side by side.
    pub limit: f64,
    /// What becomes of colours beyond the limit.
    pub gamut: Gamut,
    /// How dots are laid.
    pub dots: Dots,
}

impl Default for Inks {
    /// The paper's inks, without quenching, at full coverage.
    fn default() -> Self {
        let curves = [Curve::linear(), Curve::linear(), Curve::linear()];
        Self { yields: YIELDS, curves, limit: 1.0, gamut: Gamut::Clip, dots: Dots::Continuous }
    }
}

/// Turns film values into coverages. It holds no state: any row may be separated at any time, on any thread.
#[derive(Clone, Debug)]
pub struct Separator {
    /// Light of each ink, as a part of its own full light, where the film value is 1.
    shares: [f32; CHANNELS],
    curves: [Curve; CHANNELS],
    limit: f32,
    gamut: Gamut,
    /// Whether the inks of a spot share dots of one amount.
    sharing: bool,
    straight: bool,
}

impl Separator {
    /// Prepares the separation for `inks`.
    pub fn new(inks: &Inks) -> Self {
        let sharing = matches!(inks.dots, Dots::Levels(_));
        let fullest = inks.curves.iter().map(Curve::fullest);
        let mut limit = inks.limit as f32;
        if sharing {
            // Beyond it an ink glows less by more.
            limit = fullest.fold(limit, f32::min);
        }
        let full = |ink: usize| inks.yields[ink] as f32 * inks.curves[ink].light(limit.min(1.0));
        let white = (0..CHANNELS).map(full).fold(f32::INFINITY, f32::min);
        let mut separator = Self {
            shares: inks.yields.map(|ink| white / ink as f32),
            curves: inks.curves.clone(),
            limit,
            gamut: inks.gamut,
            sharing,
            straight: inks.curves.iter().all(Curve::is_straight)
                && inks.curves.iter().all(|c| c.fullest() == 1.0),
        };
        if inks.gamut == Gamut::Fit {
            let need = separator.need(separator.shares).max(1.0);
            separator.shares = separator.shares.map(|share| share / need);
        }
        separator
    }

    /// Light of each ink, as a part of its own full light, where the film value is 1.
    pub fn shares(&self) -> [f32; CHANNELS] {
        self.shares
    }

    /// Light of each ink by its coverage.
    pub fn curves(&self) -> &[Curve; CHANNELS] {
        &self.curves
    }

    /// Separates a row: `film` and `planes` are red, green and blue values of equal length; film values outside 0..=1
    /// count as the nearest in it. Gives the number of spots that the limit has dimmed.
    pub fn separate(&self, film: [&[f32]; CHANNELS], planes: [&mut [f32]; CHANNELS]) -> usize {
        let [red, green, blue] = planes;
        let mut dimmed = 0;
        let film = film[0].iter().zip(film[1]).zip(film[2]);
        for (((red, green), blue), ((&r, &g), &b)) in red.iter_mut().zip(green).zip(blue).zip(film) {
            let (coverages, was_dimmed) = self.spot([r, g, b]);
            [*red, *green, *blue] = coverages;
            dimmed += usize::from(was_dimmed);
        }
        dimmed
    }

    /// Separates one spot; also says whether the limit has dimmed it.
    pub fn spot(&self, film: [f32; CHANNELS]) -> ([f32; CHANNELS], bool) {
        let mut wanted = [0, 1, 2].map(|ink| within(film[ink]) * self.shares[ink]);
        if wanted == [0.0; CHANNELS] {
            return (wanted, false);
        }
        let need = self.need(wanted);
        let given = match self.gamut {
            Gamut::Compress if need > KNEE => {
                KNEE + (1.0 - KNEE) * (1.0 - (-(need - KNEE) / (1.0 - KNEE)).exp())
            }
            _ => need.min(1.0),
        };
        let dimmed = need > 1.0 + 1e-5;
        if given < need {
            wanted = wanted.map(|light| light * (given / need));
        }
        let coverages = self.coverages(wanted);
        // Rounding alone may lead over the limit.
        let excess = (coverages.iter().sum::<f32>() / self.limit).max(1.0);
        (coverages.map(|coverage| coverage / excess), dimmed)
    }

    /// The coverages that give the light `wanted`, which is within the limit.
    fn coverages(&self, wanted: [f32; CHANNELS]) -> [f32; CHANNELS] {
        if self.straight {
            return wanted;
        }
        if !self.sharing {
            return [0, 1, 2].map(|ink| self.curves[ink].coverage(wanted[ink]));
        }
        let amount = halve(self.limit, |amount| self.parts(wanted, amount).iter().sum::<f32>() > 1.0);
        self.parts(wanted, amount).map(|part| part * amount)
    }

    /// The parts of the dots that the inks take where all dots are filled to `amount`.
    fn parts(&self, wanted: [f32; CHANNELS], amount: f32) -> [f32; CHANNELS] {
        [0, 1, 2].map(|ink| wanted[ink] / self.curves[ink].light(amount).max(f32::MIN_POSITIVE))
    }

    /// What the light `wanted` needs as a part of what the limit allows: light times 1 / need would just do.
    fn need(&self, wanted: [f32; CHANNELS]) -> f32 {
        if self.straight {
            return wanted.iter().sum::<f32>() / self.limit;
        }
        if self.sharing {
            return self.parts(wanted, self.limit).iter().sum();
        }
        let brightest = wanted.iter().copied().fold(0.0, f32::max);
        let fits = |scale: f32| {
            let total: f32 = (0..CHANNELS).map(|ink| self.curves[ink].coverage(wanted[ink] * scale)).sum();
            total <= self.limit
        };
        // No ink glows more than fully.
        let most = 1.0 / brightest;
        if fits(most) { brightest } else { 1.0 / halve(most, fits).max(f32::MIN_POSITIVE) }
    }
}

/// The nearest value in 0..=1; what is no number counts as 0.
fn within(value: f32) -> f32 {
    if value > 0.0 { value.min(1.0) } else { 0.0 }
}

/// The largest value in 0..=`most` for which `more` holds of all below it.
fn halve(most: f32, more: impl Fn(f32) -> bool) -> f32 {
    let (mut low, mut high) = (0.0, most);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if more(middle) {
            low = middle;
        } else {
            high = middle;
        }
    }
    high
}

#[cfg(test)]
mod tests;
