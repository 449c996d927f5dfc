//! Reads exhibit.toml, the one file a user writes.
//!
//! Every table but `[[view]]` or `[object]` may be left out, units are in the keys, and all that is wrong is reported at once, each
//! with its place and its remedy.

mod calendar;
mod contradictions;
mod exhibit;
mod hold;
mod ink;
mod load;
mod materials;
mod object;
mod plan;
mod problem;
mod reader;
mod request;
mod schema;
mod tables;
mod visitors;
mod zone;

pub use exhibit::{
    CalendarSettings, DesignSettings, Exhibit, FrameSetting, LampSetting, LampSettings, LimitSettings,
    MethodSetting, OpticsSetting, PagingSetting, PrintSettings, ScheduleRule, StackSettings, ToneSetting,
    ViewSettings, ViewerSettings,
};
pub use hold::Hold;
pub use ink::{GamutSetting, HalftoneSetting, InkSettings};
pub use load::{load, object_exhibit, parse};
pub use object::{CentreSetting, HiddenSetting, LARGEST_POINT_MM, ObjectSettings, UNIT_MM, parse_colour};
pub use plan::{PlanPairs, emphasis};
pub use problem::{ConfigError, Problem};
pub use reader::closest;
pub use request::distance;
pub use schema::schema;
pub use tables::LONGEST_NAME;
pub use tables::MOST_VOXELS_ON_DISK;
pub use zone::{ZoneError, time_zone};

#[cfg(test)]
mod tests;
