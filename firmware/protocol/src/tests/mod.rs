//! Behaviour of frames and of the server; golden bytes of all messages.

mod confirm;
mod controller;
mod frames;
mod golden;
mod malformed;
mod plan_file;
mod rate;
mod samples;
mod server;
mod sizes;
mod update;
