//! The bundled photographs as design requests.

use std::path::Path;

use vitrine::design::{DesignRequest, DesignSettings, Stop, ViewRequest};
use vitrine::optics::Direction;
use vitrine::picture::Picture;
use vitrine::projection::ViewerDistance;
use vitrine::stack::Stack;

/// Reads a bundled photograph for films of `pixels` x `pixels`.
pub(crate) fn photo(name: &str, pixels: usize) -> Picture {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("photos").join(name).with_extension("jpg");
    Picture::read_fitted(&path, pixels, pixels).expect("a bundled photograph")
}

/// Asks for the photographs in their directions (horizontal, vertical) on the paper's stack.
pub(crate) fn request(views: &[(&str, f64, f64)], pixels: usize, settings: DesignSettings) -> DesignRequest {
    let views = views.iter().map(|&(name, horizontal_deg, vertical_deg)| {
        ViewRequest::new(name, photo(name, pixels), Direction { horizontal_deg, vertical_deg })
    });
    DesignRequest {
        stack: Stack { width_px: pixels, height_px: pixels, ..Stack::default() },
        distance: ViewerDistance::Parallel,
        views: views.collect(),
        settings,
        stop: Stop::default(),
    }
}

/// Three views about the vertical axis.
pub(crate) const THREE: [(&str, f64, f64); 3] =
    [("astronaut", 30.0, 0.0), ("coffee", 0.0, 0.0), ("cat", -30.0, 0.0)];

/// Four views about both axes.
pub(crate) const FOUR: [(&str, f64, f64); 4] =
    [("astronaut", 20.0, -20.0), ("coffee", -20.0, -20.0), ("cat", 20.0, 20.0), ("rocket", -20.0, 20.0)];
