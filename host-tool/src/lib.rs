//! Designs, previews, uploads and runs film-stack exhibits.
#![forbid(unsafe_code)]
