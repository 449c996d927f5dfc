//! Behaviour of updates, above all when the power goes.

mod bench;
mod cuts;
mod images;
mod keys;
mod running;
mod trial;
mod updates;
