//! People, animals and things that are warm.

use serde::Deserialize;

use super::{SENSOR_HEIGHT_M, WarmArea};

/// What a warm body is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Kind {
    /// A person of any height: clothes and a bare head; sways a little.
    Person,
    /// A dog: low, warm and restless.
    Dog,
    /// A radiator under a window; quite still.
    Radiator,
    /// A patch of sun on the wall, at eye level; quite still.
    SunOnWall,
    /// A patch of sun on the floor; quite still.
    SunOnFloor,
}

/// Where a body is at a time: seconds, horizontal angle in degrees as seen from the stack, distance in m.
#[derive(Clone, Copy, Debug, Deserialize)]
pub struct Waypoint(pub f64, pub f64, pub f64);

/// A warm body on its way.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Body {
    /// What it is.
    pub kind: Kind,
    /// Its height.
    #[serde(default = "default_height")]
    pub height_m: f64,
    /// How much of a person's usual swaying there is; 0 is dead still.
    #[serde(default = "usual")]
    pub sway: f64,
    /// How much of its usual warmth it shows.
    #[serde(default = "usual")]
    pub warmth: f64,
    /// Its way; between two waypoints it walks straight, before the first and after the last it is not there.
    pub path: Vec<Waypoint>,
}

const fn default_height() -> f64 {
    1.7
}

const fn usual() -> f64 {
    1.0
}

/// A rectangle of a body: half width, lower and upper edge, temperature above the room's.
struct Part(f64, f64, f64, f64);

impl Body {
    /// A person who stands at an angle and distance from the start on.
    pub fn standing(horizontal_deg: f64, distance_m: f64) -> Self {
        let at = |time| Waypoint(time, horizontal_deg, distance_m);
        Self {
            kind: Kind::Person,
            height_m: default_height(),
            sway: usual(),
            warmth: usual(),
            path: vec![at(0.0), at(1e9)],
        }
    }

    /// Where the body is: to the right of the stack and before it, in m.
    pub fn position(&self, time_s: f64) -> Option<[f64; 2]> {
        let legs = self.path.iter().zip(self.path.iter().skip(1));
        let mut current = legs.filter(|(from, to)| from.0 <= time_s && time_s < to.0);
        let (from, to) = current.next_back()?;
        let part = (time_s - from.0) / (to.0 - from.0);
        let place = |at: &Waypoint| {
            let angle = at.1.to_radians();
            [at.2 * angle.sin(), at.2 * angle.cos()]
        };
        let (a, b) = (place(from), place(to));
        let sway = match self.kind {
            // People sway by centimetres and shift their weight from foot to foot every now and then.
            Kind::Person | Kind::Dog => {
                let phase = self.height_m * 7.0;
                self.sway
                    * (0.02 * (time_s * 2.6 + phase).sin() + 0.04 * (time_s * 0.3 + phase).sin().powi(3))
            }
            Kind::Radiator | Kind::SunOnWall | Kind::SunOnFloor => 0.0,
        };
        Some([a[0] + (b[0] - a[0]) * part + sway, a[1] + (b[1] - a[1]) * part])
    }

    /// The horizontal angle at which the stack sees it, in degrees.
    pub fn horizontal_deg(&self, time_s: f64) -> Option<f64> {
        self.position(time_s).map(|[x, z]| x.atan2(z).to_degrees())
    }

    /// The angle at which the stack sees its eyes, in degrees above the horizontal.
    pub fn vertical_deg(&self, time_s: f64) -> Option<f64> {
        let eyes = self.height_m - 0.11 - SENSOR_HEIGHT_M;
        self.position(time_s).map(|[x, z]| (eyes / x.hypot(z)).atan().to_degrees())
    }

    /// What a sensor sees of it that stands beside the stack.
    pub fn seen_from(&self, sensor_m: f64, time_s: f64) -> Vec<WarmArea> {
        let Some([x, z]) = self.position(time_s) else { return Vec::new() };
        let (across, distance_m) = (x - sensor_m, (x - sensor_m).hypot(z));
        let azimuth = across.atan2(z).to_degrees();
        let elevation = |height: f64| ((height - SENSOR_HEIGHT_M) / distance_m).atan().to_degrees();
        let area = |Part(half_width, from, to, above_c)| {
            let half = f64::atan(half_width / distance_m).to_degrees();
            WarmArea {
                azimuth: [azimuth - half, azimuth + half],
                elevation: [elevation(from), elevation(to)],
                above_c: above_c * self.warmth,
                distance_m,
            }
        };
        self.parts().into_iter().map(area).collect()
    }

    fn parts(&self) -> Vec<Part> {
        let top = self.height_m;
        match self.kind {
            Kind::Person => {
                vec![
                    Part(0.21, 0.0, top - 0.28, 6.0),
                    Part(0.06, top - 0.3, top - 0.2, 9.0),
                    Part(0.085, top - 0.25, top, 11.0),
                ]
            }
            Kind::Dog => vec![Part(0.3, 0.15, 0.55, 8.0), Part(0.1, 0.0, 0.15, 6.0)],
            Kind::Radiator => vec![Part(0.5, 0.2, 0.9, 20.0)],
            Kind::SunOnWall => vec![Part(0.4, 1.0, 1.8, 6.0)],
            Kind::SunOnFloor => vec![Part(0.5, 0.0, 0.1, 8.0)],
        }
    }
}
