//! The paper's Eq. 1.

use rayon::prelude::*;

use super::request::{DesignRequest, Progress};
use crate::projection::Rays;
use crate::volume::Volume;

/// Makes every voxel the product of the patterns' values where the voxel appears in the views; a voxel that
/// lies outside of a view's pattern stays without ink, for its light would fall beside that picture.
///
/// The values are code values or light, as the request's tone says.
pub fn product(request: &DesignRequest, report: &mut dyn FnMut(Progress)) -> Volume {
    let stack = &request.stack;
    report(Progress::at("multiplying the patterns", 0, 1));
    let targets = request.targets();
    let rays: Vec<Rays> = (0..request.views.len()).map(|view| request.rays(view).traced_back()).collect();
    let mut volume = Volume::new(stack.films, stack.height_px, stack.width_px);
    volume.values_mut().par_chunks_mut(stack.film_len()).enumerate().for_each(|(index, plane)| {
        let (channel, film) = (index / stack.films, index % stack.films);
        plane.fill(1.0);
        for (rays, target) in rays.iter().zip(&targets) {
            rays.multiply_film(film, target.channel(channel), plane);
        }
    });
    report(Progress::at("multiplying the patterns", 1, 1));
    volume
}
