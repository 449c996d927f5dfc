//! The `vitrine` command as a user runs it.

mod demo;
mod design;
mod link;
mod support;
mod view;
mod wrong_input;
