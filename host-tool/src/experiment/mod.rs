//! Trying materials out.

pub mod films;
