//! Reads exhibit.toml, the one file a user writes.
//!
//! Every table but `[[view]]` may be left out, units are in the keys, and all that is wrong is reported at once, each
//! with its place and its remedy.

mod calendar;
mod exhibit;
mod load;
mod problem;
mod reader;
mod tables;

pub use exhibit::{
    CalendarSettings, DesignSettings, Exhibit, FrameSetting, LampSettings, LimitSettings, MethodSetting,
    OpticsSetting, PrintSettings, ScheduleRule, StackSettings, ToneSetting, ViewSettings, ViewerSettings,
};
pub use load::{load, parse};
pub use problem::{ConfigError, Problem};

#[cfg(test)]
mod tests;
