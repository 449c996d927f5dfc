//! The `vitrine` command as a user runs it.

mod design;
mod support;
mod view;
mod wrong_input;
