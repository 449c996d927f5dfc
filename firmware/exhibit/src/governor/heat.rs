//! Temperatures of the lamp boards and of the enclosure's air, with hysteresis.

use crate::events::{Event, Events};
use crate::inputs::TemperatureReading;
use crate::limits;
use crate::units::{CentiCelsius, Lamp, Level, PerLamp};

/// What is too hot.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BoardHeat {
    too_hot: PerLamp<bool>,
    enclosure_warm: bool,
    enclosure_too_hot: bool,
}

impl BoardHeat {
    pub(super) fn update(
        &mut self,
        boards: PerLamp<Option<TemperatureReading>>,
        enclosure: Option<CentiCelsius>,
        events: &mut Events,
    ) {
        let hot = |was: bool, reading: Option<TemperatureReading>| {
            let bound = if was { limits::BOARD_BACK } else { limits::BOARD_CUT };
            // A sensor that fails tells nothing about the heat: it is dark for a reason of its own.
            reading.and_then(TemperatureReading::celsius).map_or(was, |now| now >= bound)
        };
        self.too_hot = self.too_hot.zip(boards).map(|(was, reading)| hot(was, reading));
        let Some(air) = enclosure else { return };
        let bound = |was: bool, on: CentiCelsius, off: CentiCelsius| air >= if was { off } else { on };
        let warm = bound(self.enclosure_warm, limits::ENCLOSURE_WARN, limits::ENCLOSURE_COOL);
        if warm && !self.enclosure_warm {
            events.push(Event::EnclosureWarm);
        }
        self.enclosure_warm = warm;
        self.enclosure_too_hot = bound(self.enclosure_too_hot, limits::ENCLOSURE_CUT, limits::ENCLOSURE_BACK);
    }

    pub(super) const fn is_too_hot(&self, lamp: Lamp) -> bool {
        *self.too_hot.get(lamp)
    }

    pub(super) const fn is_enclosure_too_hot(&self) -> bool {
        self.enclosure_too_hot
    }
}

/// The most level of a lamp whose board has this temperature: full up to 60 °C, nothing from 75 °C.
pub(super) fn derated(board: Option<TemperatureReading>) -> Level {
    let Some(board) = board.and_then(TemperatureReading::celsius) else { return Level::OFF };
    let (from, to) = (i32::from(limits::DERATE_FROM.0), i32::from(limits::DERATE_TO.0));
    let left = (to - i32::from(board.0)).clamp(0, to - from);
    Level((left * 65_535 / (to - from)) as u16)
}
