//! One axis of the map from a film to the picture: where each pixel of the picture samples the film.

/// Positions `p(i) = c + scale (i - c) + shift` on a film of `len` pixels with middle c, for every picture
/// index i, kept as runs in which `floor(p(i)) - i` does not change, so that loops over a run are plain.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    len: usize,
    part: Part,
    scale: f64,
    shift: f64,
    runs: Vec<Run>,
    /// Of each picture index: the weight of the upper of the two film pixels between which it samples.
    fraction: Vec<f32>,
    /// Of each picture index that meets the film: the lower film pixel.
    lower: Vec<Option<u32>>,
    samplers: Samplers,
    identity: bool,
}

/// Which pixels of a longer axis these are.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Pixels of the longer axis.
    pub(super) whole: usize,
    /// The pixel of the whole picture at index 0; where there is none of it, nobody looks.
    pub(super) picture: i64,
    /// The pixel of the whole film at index 0; where there is none of it, there is no light.
    pub(super) film: i64,
}

/// Of each film pixel: the picture indices that sample it, with their weights.
#[derive(Clone, Debug)]
struct Samplers {
    /// Of each film pixel, where its samplers begin; at the end, where the last one's end.
    starts: Vec<u32>,
    all: Vec<(u32, f32)>,
}

impl Samplers {
    /// `samples` are film pixels with the picture indices that sample them, in the order of the picture's.
    fn of(len: usize, samples: impl Iterator<Item = (usize, u32, f32)> + Clone) -> Self {
        let mut starts = vec![0; len + 1];
        samples.clone().for_each(|(film, _, _)| starts[film + 1] += 1);
        for film in 0..len {
            starts[film + 1] += starts[film];
        }
        let mut ends = starts.clone();
        let mut all = vec![(0, 0.0); starts[len] as usize];
        for (film, picture, weight) in samples {
            all[ends[film] as usize] = (picture, weight);
            ends[film] += 1;
        }
        Self { starts, all }
    }

    fn of_pixel(&self, film: usize) -> &[(u32, f32)] {
        &self.all[self.starts[film] as usize..self.starts[film + 1] as usize]
    }
}

#[derive(Clone, Debug)]
struct Run {
    /// First picture index of the run, and the one after its last.
    start: usize,
    end: usize,
    /// Lower film pixel of the first picture index.
    film_start: usize,
    /// The fraction of the whole run, when it is the same.
    fraction: Option<f32>,
}

/// Positions this near to a pixel centre are taken as lying on it.
const SNAP: f64 = 1e-7;

impl Axis {
    pub(super) fn new(len: usize, scale: f64, shift: f64) -> Self {
        Self::of_part(len, Part { whole: len, picture: 0, film: 0 }, scale, shift)
    }

    /// As [`Axis::new`], for `len` pixels of a longer axis; `scale` and `shift` are those of the whole.
    pub(super) fn of_part(len: usize, part: Part, scale: f64, shift: f64) -> Self {
        let last = part.whole as f64 - 1.0;
        let middle = last / 2.0;
        let mut axis = Self {
            len,
            part,
            scale,
            shift,
            runs: Vec::new(),
            fraction: vec![0.0; len],
            lower: vec![None; len],
            samplers: Samplers::of(0, std::iter::empty()),
            identity: false,
        };
        for i in 0..len {
            let looked_at = (part.picture + i as i64) as f64;
            let position = middle + scale * (looked_at - middle) + shift;
            let snapped =
                if (position - position.round()).abs() < SNAP { position.round() } else { position };
            let held = snapped - part.film as f64;
            let exists = [looked_at, snapped].iter().all(|at| (0.0..=last).contains(at));
            if !exists || !(0.0..=len as f64 - 1.0).contains(&held) || scale <= 0.0 {
                continue;
            }
            let lower = (held.floor() as usize).min(len - 2);
            axis.put(i, lower, (held - lower as f64) as f32);
        }
        for run in &mut axis.runs {
            let fractions = &axis.fraction[run.start..run.end];
            run.fraction = fractions.iter().all(|f| f == &fractions[0]).then_some(fractions[0]);
        }
        axis.samplers = Samplers::of(len, axis.samples());
        // An unmoved axis samples its last pixel as the upper one of the pair before it.
        axis.identity = axis.lower.iter().all(Option::is_some)
            && axis.samples().all(|(film, picture, weight)| picture as usize == film && weight == 1.0);
        axis
    }

    /// Every film pixel that counts for a picture index, with that index and its weight.
    fn samples(&self) -> impl Iterator<Item = (usize, u32, f32)> + Clone {
        let met = self.lower.iter().zip(&self.fraction).enumerate();
        met.flat_map(|(picture, (lower, &fraction))| {
            let both = lower.map(|lower| [(lower, 1.0 - fraction), (lower + 1, fraction)]);
            both.into_iter().flatten().map(move |(film, weight)| (film as usize, picture as u32, weight))
        })
        .filter(|(_, _, weight)| *weight != 0.0)
    }

    /// The lower of the two film pixels that picture index `index` samples, where it meets the film.
    pub(super) fn lower(&self, index: usize) -> Option<usize> {
        self.lower.get(index).copied().flatten().map(|lower| lower as usize)
    }

    /// Whether every picture index samples the film's pixel of the same index alone.
    pub(super) fn is_identity(&self) -> bool {
        self.identity
    }

    /// Returns the part of a pixel that its samples share with each neighbour, on the average.
    pub(super) fn shared(&self) -> f64 {
        let met = self.fraction.iter().zip(&self.lower).filter(|(_, lower)| lower.is_some());
        let shares: Vec<f64> = met.map(|(&fraction, _)| f64::from(fraction * (1.0 - fraction))).collect();
        shares.iter().sum::<f64>() / shares.len().max(1) as f64
    }

    /// Returns the axis that traces the other way: from a film's pixel to where it appears in the picture.
    pub(super) fn inverse(&self) -> Self {
        let part = Part { picture: self.part.film, film: self.part.picture, ..self.part };
        Self::of_part(self.len, part, 1.0 / self.scale, -self.shift / self.scale)
    }

    /// Adds `weight` times the interpolated film line to the picture line.
    #[inline(always)]
    pub(super) fn add(&self, film: &[f32], weight: f32, picture: &mut [f32]) {
        for run in &self.runs {
            let len = run.end - run.start;
            let target = &mut picture[run.start..run.end];
            let lower = &film[run.film_start..run.film_start + len];
            let upper = &film[run.film_start + 1..run.film_start + 1 + len];
            match run.fraction {
                Some(fraction) => {
                    let (a, b) = (weight * (1.0 - fraction), weight * fraction);
                    for ((value, &l), &u) in target.iter_mut().zip(lower).zip(upper) {
                        *value += a * l + b * u;
                    }
                }
                None => {
                    let fractions = &self.fraction[run.start..run.end];
                    for (((value, &l), &u), &f) in target.iter_mut().zip(lower).zip(upper).zip(fractions) {
                        *value += weight * (l + f * (u - l));
                    }
                }
            }
        }
    }

    /// Adds `weight` times the transpose of the interpolation, applied to the picture line, to the film line.
    #[inline(always)]
    pub(super) fn add_transposed(&self, picture: &[f32], weight: f32, film: &mut [f32]) {
        for run in &self.runs {
            let len = run.end - run.start;
            let source = &picture[run.start..run.end];
            let target = &mut film[run.film_start..run.film_start + len + 1];
            let (first, before, after) = (source[0], &source[..len - 1], &source[1..]);
            match run.fraction {
                Some(fraction) => {
                    let (a, b) = (weight * (1.0 - fraction), weight * fraction);
                    target[0] += a * first;
                    for ((value, &here), &before) in target[1..len].iter_mut().zip(after).zip(before) {
                        *value += a * here + b * before;
                    }
                    target[len] += b * source[len - 1];
                }
                None => {
                    let fractions = &self.fraction[run.start..run.end];
                    target[0] += weight * (first - fractions[0] * first);
                    let near = after.iter().zip(&fractions[1..]);
                    let far = before.iter().zip(&fractions[..len - 1]);
                    for ((value, (&here, &f)), (&before, &g)) in target[1..len].iter_mut().zip(near).zip(far)
                    {
                        *value += weight * ((here - f * here) + g * before);
                    }
                    target[len] += weight * fractions[len - 1] * source[len - 1];
                }
            }
        }
    }

    /// Returns the film line that picture row `row` samples, or nothing when it meets none; `line` gives the
    /// film's rows.
    #[inline(always)]
    pub(super) fn gather<'a>(
        &self,
        row: usize,
        line: impl Fn(usize) -> &'a [f32],
        scratch: &'a mut [f32],
    ) -> Option<&'a [f32]> {
        let lower = self.lower[row]? as usize;
        let fraction = self.fraction[row];
        if fraction == 0.0 {
            return Some(line(lower));
        }
        if fraction == 1.0 {
            return Some(line(lower + 1));
        }
        for ((value, &l), &u) in scratch.iter_mut().zip(line(lower)).zip(line(lower + 1)) {
            *value = l + fraction * (u - l);
        }
        Some(scratch)
    }

    /// Returns the sum of the picture rows that sample film row `row`, or nothing when none does.
    #[inline(always)]
    pub(super) fn gather_transposed<'a>(
        &self,
        row: usize,
        picture: &'a [f32],
        scratch: &'a mut [f32],
    ) -> Option<&'a [f32]> {
        let width = scratch.len();
        let line = |at: u32| &picture[at as usize * width..(at as usize + 1) * width];
        match self.samplers.of_pixel(row) {
            [] => None,
            [(only, 1.0)] => Some(line(*only)),
            [(first, a), (second, b)] => {
                for ((value, &x), &y) in scratch.iter_mut().zip(line(*first)).zip(line(*second)) {
                    *value = a * x + b * y;
                }
                Some(scratch)
            }
            samplers => {
                scratch.fill(0.0);
                for &(at, weight) in samplers {
                    scratch.iter_mut().zip(line(at)).for_each(|(value, &x)| *value += weight * x);
                }
                Some(scratch)
            }
        }
    }

    fn put(&mut self, picture: usize, lower: usize, fraction: f32) {
        self.fraction[picture] = fraction;
        self.lower[picture] = Some(lower as u32);
        match self.runs.last_mut() {
            Some(run) if run.end == picture && lower == run.film_start + (picture - run.start) => {
                run.end += 1;
            }
            _ => self.runs.push(Run { start: picture, end: picture + 1, film_start: lower, fraction: None }),
        }
    }
}
