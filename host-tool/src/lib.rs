//! Designs, previews, uploads and runs film-stack exhibits.
#![forbid(unsafe_code)]

pub mod build_folder;
pub mod config;
pub mod starter;
