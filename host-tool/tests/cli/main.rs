//! The `vitrine` command as a user runs it.

mod book;
mod demo;
mod design;
mod help;
mod ink;
mod link;
mod outlook;
mod support;
mod view;
mod wrong_input;
