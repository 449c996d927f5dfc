//! The `vitrine` command as a user runs it.

mod answers;
mod book;
mod demo;
mod design;
mod dry_run;
mod firmware;
mod help;
mod ink;
mod link;
mod names;
mod outlook;
mod ports;
mod print;
mod slice;
mod strips;
mod support;
mod turn;
mod view;
mod wrong_input;
