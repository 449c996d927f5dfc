//! Behaviour of frames and of the server; golden bytes of all messages.

mod controller;
mod frames;
mod golden;
mod plan_file;
mod rate;
mod samples;
mod server;
mod sizes;
