//! Designs, previews, uploads and runs film-stack exhibits.
#![forbid(unsafe_code)]

pub mod build_folder;
mod canvas;
pub mod chart;
pub mod config;
pub mod controller;
mod deflate;
pub mod demo;
pub mod design;
pub mod emission;
pub mod experiment;
pub mod firmware;
pub mod ink;
pub mod link;
pub mod material;
pub mod measure;
pub mod object;
pub mod optics;
pub mod picture;
pub mod plain;
pub mod print;
pub mod projection;
pub mod self_test;
mod simd;
mod spread;
pub mod stack;
pub mod starter;
pub mod volume;
pub mod year;
