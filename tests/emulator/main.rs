//! The controller's real image on an emulated RP2040, its pins measured.
//!
//! Needs the image (`firmware/build.sh`), Node.js and the emulator (`npm ci` in this folder); README.md tells more.

mod bench;
mod boot;
mod chain;
mod cuts;
mod day;
mod drift;
mod erases;
mod exhibit;
mod fades;
mod faults;
mod flash;
mod floods;
mod hosts;
mod hours;
mod interlock;
mod live;
mod malformed;
mod measures;
mod mind;
mod quick;
mod radar;
mod room;
mod signals;
mod trace;
mod update;
