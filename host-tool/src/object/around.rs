//! The box around a model, found or held against what its file tells.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::layers::Layers;
use super::placement::Placement;
use super::shape::{Box3, Point, Sink, Triangle};
use super::texture::Texture;
use crate::config::ObjectSettings;

/// Points that are kept of a cloud while its box is looked for, so that it need not be read again: 384 MiB of them.
const MOST_KEPT: usize = 12 << 20;

/// How far a box that is told may be from the one that is found, as a part of its size: headers are rounded.
const TOLERANCE: f64 = 1e-6;

/// The box around a turned model, and its points if they are all of it and not too many.
pub(super) struct Around {
    turn_deg: [f64; 3],
    turn: Placement,
    seen: Mutex<Seen>,
}

struct Seen {
    around: Box3,
    /// None once there are too many, or anything else.
    points: Option<Vec<Vec<Point>>>,
    count: usize,
}

impl Around {
    pub(super) fn new(settings: &ObjectSettings) -> Self {
        let seen = Seen { around: Box3::EMPTY, points: Some(Vec::new()), count: 0 };
        let turn_deg = settings.turn_deg;
        Self { turn_deg, turn: Placement::turned(turn_deg), seen: Mutex::new(seen) }
    }

    /// The box around what fills `told` before it is turned; none where that is not told by the box alone.
    pub(super) fn turned(&self, told: &Box3) -> Option<Box3> {
        let is_square = self.turn_deg.iter().all(|angle| angle.rem_euclid(90.0) == 0.0);
        let turned = self.box_of([told.least, told.most].into_iter());
        (is_square && !turned.is_empty()).then_some(turned)
    }

    /// Whether `told` is the box that was found.
    pub(super) fn is(&self, told: &Box3) -> bool {
        let found = self.found();
        let near = |one: [f64; 3], other: [f64; 3]| {
            let size = told.size();
            (0..3).all(|axis| (one[axis] - other[axis]).abs() <= TOLERANCE * size[axis])
        };
        near(found.least, told.least) && near(found.most, told.most)
    }

    /// The box around all that was seen.
    pub(super) fn found(&self) -> Box3 {
        self.seen().around
    }

    /// The points of a cloud, if they are kept.
    pub(super) fn kept(self) -> Option<Vec<Vec<Point>>> {
        self.seen.into_inner().unwrap_or_else(PoisonError::into_inner).points
    }

    fn box_of(&self, positions: impl Iterator<Item = [f64; 3]>) -> Box3 {
        let mut around = Box3::EMPTY;
        positions.for_each(|position| around.hold(self.turn.place(position)));
        around
    }

    fn seen(&self) -> MutexGuard<'_, Seen> {
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes points that are not kept.
    fn pass(&self, points: &[Point]) {
        let around = self.box_of(points.iter().map(|point| point.position));
        let mut seen = self.seen();
        seen.around = seen.around.with(around);
        seen.points = None;
    }
}

impl Sink for Around {
    fn points(&self, points: &[Point]) {
        let around = self.box_of(points.iter().map(|point| point.position));
        let mut seen = self.seen();
        seen.around = seen.around.with(around);
        seen.count += points.len();
        if seen.count > MOST_KEPT {
            seen.points = None;
        }
        if let Some(kept) = &mut seen.points {
            kept.push(points.to_vec());
        }
    }

    fn triangles(&self, triangles: &[Triangle], _: Option<&Texture>) {
        let around = self.box_of(triangles.iter().flatten().map(|corner| corner.position));
        let mut seen = self.seen();
        seen.around = seen.around.with(around);
        seen.points = None;
    }
}

/// Films whose model is watched while it is laid into them.
pub(super) struct Watched<'a> {
    pub(super) around: &'a Around,
    pub(super) layers: &'a Layers,
}

impl Sink for Watched<'_> {
    fn points(&self, points: &[Point]) {
        self.around.pass(points);
        self.layers.points(points);
    }

    fn triangles(&self, triangles: &[Triangle], texture: Option<&Texture>) {
        self.around.triangles(triangles, texture);
        self.layers.triangles(triangles, texture);
    }
}
