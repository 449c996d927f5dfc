//! Messages with a different value in each field, and every variant of an enum.

use std::{string::String as Text, vec::Vec};

use heapless::String;
use serde::de::DeserializeOwned;
use vitrine_exhibit::{
    Presence, Snapshot,
    clock::ClockRecord,
    events::{Cut, Cuts, DarkReason, Event},
    interlock::InterlockState,
    settings::{ServicePort, Settings},
    units::{
        CentiCelsius, CentiDegrees, Dose, Irradiance, Lamp, Level, Milliseconds, Millivolts, PerLamp,
        UtcSeconds,
    },
    viewer::Bearing,
};

use crate::{
    firmware::{FirmwareState, Outcome, Progress},
    message::{Hello, LogEntry, LogPage, MAX_LOG_ENTRIES},
    status::{ClockSource, ClockState, PlanState, Status},
};

/// Every variant of an enum, its fields as small as they can be. Variants are found by their index in postcard, so
/// that a new one is found too.
pub(super) fn every_variant<T: DeserializeOwned>() -> Vec<T> {
    (0..=127)
        .map_while(|index| {
            let mut bytes = [0; 512];
            bytes[0] = index;
            postcard::take_from_bytes(&bytes).ok().map(|(value, _)| value)
        })
        .collect()
}

pub(super) fn text<const N: usize>(text: &str) -> String<N> {
    text.try_into().expect("short enough")
}

pub(super) fn hello() -> Hello {
    Hello {
        version: 1,
        fingerprint: 0x1234_5678,
        serial_number: text("E660C0D1C7591B28"),
        firmware: text("0.1.0"),
        name: text("Three photographs"),
    }
}

pub(super) fn firmware() -> FirmwareState {
    FirmwareState {
        version: text("0.2.0"),
        digest: core::array::from_fn(|i| i as u8),
        progress: Progress::Settled(Outcome::Confirmed),
    }
}

pub(super) fn clock() -> ClockState {
    ClockState {
        now: Some(UtcSeconds(1_795_379_862)),
        source: ClockSource::Battery,
        record: ClockRecord { last_error_s: Some(-3), ..ClockRecord::default() },
    }
}

pub(super) fn settings() -> Settings {
    Settings {
        place: text("Hall 3, left case"),
        service_port: ServicePort::Network,
        top_beta_kelvin: 3_435,
        bottom_beta_kelvin: 3_436,
        supply_divider_permille: 11_050,
        ultraviolet_gain_permille: 1_080,
        viewer_yaw: CentiDegrees(2_400),
        viewer_pitch: CentiDegrees(-300),
        viewer_beside_mm: 25,
    }
}

/// Settings with the most bytes that any have.
pub(super) fn largest_settings() -> Settings {
    Settings {
        place: text(&Text::from_utf8(std::vec![b'p'; 32]).expect("ASCII")),
        service_port: ServicePort::Network,
        top_beta_kelvin: u16::MAX,
        bottom_beta_kelvin: u16::MAX,
        supply_divider_permille: u16::MAX,
        ultraviolet_gain_permille: u16::MAX,
        viewer_yaw: CentiDegrees(i16::MIN),
        viewer_pitch: CentiDegrees(i16::MIN),
        viewer_beside_mm: u16::MAX,
    }
}

pub(super) fn status() -> Status {
    let mut cuts = Cuts::default();
    cuts.insert(Cut::Slew);
    Status {
        snapshot: Snapshot {
            uptime_ms: 1_000_001,
            now: Some(UtcSeconds(1_795_379_862)),
            presence: Presence::Somebody,
            bearing: Some(Bearing::new(-3_012, 155)),
            viewers: 2,
            view: Some(1),
            levels: PerLamp::new(Level(40_000), Level(12_345)),
            irradiance: PerLamp::new(Irradiance(6_103), Irradiance(1_883)),
            enabled: true,
            dark: None,
            cuts: PerLamp::new(cuts, Cuts::default()),
            boards: PerLamp::new(Some(CentiCelsius(4_150)), None),
            enclosure: Some(CentiCelsius(2_560)),
            supply: Some(Millivolts(24_010)),
            ultraviolet: Some(Irradiance(5_900)),
            interlock: InterlockState::Armed,
            day_dose: PerLamp::new(Dose(21_000_000_001), Dose(21_000_000_002)),
            life_dose: PerLamp::new(Dose(4_000_000_000_003), Dose(4_000_000_000_004)),
            lit_s: PerLamp::new(360_001, 360_002),
            full_s: PerLamp::new(180_003, 180_004),
            power_cycles: 57,
            watchdog_resets: 1,
            lease: Milliseconds(59_000),
            ultraviolet_lost: false,
            viewer_sensor_lost: true,
        },
        clock: clock(),
        plan: Some(PlanState {
            crc: 0xcafe_f00d,
            length: 401,
            name: text("Three photographs"),
            views: 3,
            view_id: text("astronaut"),
        }),
        log_next: 1_234,
        damaged_frames: 5,
    }
}

/// A status with the largest value in each field that a controller can tell.
pub(super) fn largest_status() -> Status {
    let mut all = Cuts::default();
    Cuts::ALL.into_iter().for_each(|cut| all.insert(cut));
    Status {
        snapshot: Snapshot {
            uptime_ms: u64::MAX,
            now: Some(UtcSeconds(i64::MAX)),
            presence: Presence::Unknown,
            bearing: Some(Bearing::new(i16::MIN, i16::MIN)),
            viewers: u8::MAX,
            view: Some(u8::MAX),
            levels: PerLamp::new(Level::FULL, Level::FULL),
            irradiance: PerLamp::new(Irradiance(u32::MAX), Irradiance(u32::MAX)),
            enabled: true,
            dark: Some(DarkReason::TooHot(Lamp::Bottom)),
            cuts: PerLamp::new(all, all),
            boards: PerLamp::new(Some(CentiCelsius(i16::MIN)), Some(CentiCelsius(i16::MIN))),
            enclosure: Some(CentiCelsius(i16::MIN)),
            supply: Some(Millivolts(u16::MAX)),
            ultraviolet: Some(Irradiance(u32::MAX)),
            interlock: InterlockState::Armed,
            day_dose: PerLamp::new(Dose(u64::MAX), Dose(u64::MAX)),
            life_dose: PerLamp::new(Dose(u64::MAX), Dose(u64::MAX)),
            lit_s: PerLamp::new(u32::MAX, u32::MAX),
            full_s: PerLamp::new(u32::MAX, u32::MAX),
            power_cycles: u32::MAX,
            watchdog_resets: u32::MAX,
            lease: Milliseconds(u32::MAX),
            ultraviolet_lost: true,
            viewer_sensor_lost: true,
        },
        clock: ClockState {
            now: Some(UtcSeconds(i64::MAX)),
            source: ClockSource::Computer,
            record: ClockRecord {
                set_at: Some(UtcSeconds(i64::MIN)),
                drift_ppb: i32::MIN,
                last_error_s: Some(i32::MIN),
            },
        },
        plan: Some(PlanState {
            crc: u32::MAX,
            length: u32::MAX,
            name: text(&Text::from_utf8(std::vec![b'n'; 48]).expect("ASCII")),
            views: u8::MAX,
            view_id: text(&Text::from_utf8(std::vec![b'v'; 24]).expect("ASCII")),
        }),
        log_next: u32::MAX,
        damaged_frames: u32::MAX,
    }
}

/// A page with as many of the largest entries as it holds.
pub(super) fn largest_log_page() -> LogPage {
    let mut page = LogPage { oldest: u32::MAX - 100, next: u32::MAX, ..LogPage::default() };
    for number in 0..MAX_LOG_ENTRIES as u32 {
        let entry = LogEntry {
            sequence: u32::MAX - 100 + number,
            time: Some(UtcSeconds(i64::MAX)),
            uptime_s: u32::MAX,
            event: Event::DayDose {
                lamp: Lamp::Bottom,
                day: u32::MAX,
                joules_m2: u32::MAX,
                lit_hours: u32::MAX,
            },
        };
        page.entries.push(entry).expect("room for all");
    }
    page
}
