//! From a model, points or a mesh, to the ink of the films.
//!
//! A model is read piece by piece ([`Model`]), turned, scaled and laid into the stack ([`Placement`]), and its points go
//! to the films by the paper's rule: with Z_n the lower face of layer n, counted from the lowest film, a point of
//! Z_n <= z < Z_(n+1) goes to film n ([`Layers`]). Meshes become points on their surface as close as the films' pixels.
//! What lies outside is counted and told ([`Tally`]).

mod around;
mod fill;
mod hidden;
mod layers;
mod levels;
mod model;
mod placement;
mod shape;
mod slice;
mod strips;
mod surface;
mod texture;
mod views;

pub use hidden::Sight;
pub use layers::{Layers, Tally};
pub use model::{Model, ModelError, Place};
pub use placement::Placement;
pub use shape::Box3;
pub use slice::{ObjectReport, Sliced, foretold, slice};
pub use strips::{ObjectStrip, ObjectStrips};
pub use views::Shown;
