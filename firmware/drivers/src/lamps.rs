//! The two lamps behind one enable line.
//!
//! Dark means both dimming outputs at zero *and then* the enable line low; light means the dimming outputs first and
//! the enable line last, so that a stale level never shows. An output that fails does not keep the others from going
//! dark.

use embedded_hal::digital::OutputPin;
use embedded_hal::pwm::SetDutyCycle;

/// The output that could not be set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LampError {
    /// Dimming of the lamp on the viewer's side.
    TopDimming,
    /// Dimming of the lamp behind the stack.
    BottomDimming,
    /// The enable line of both drivers.
    Enable,
}

/// How long each lamp's output is high, in counts of its timer: 0 never, the output's `max_duty_cycle` always.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Of the lamp on the viewer's side.
    pub top: u16,
    /// Of the lamp behind the stack.
    pub bottom: u16,
}

/// Both lamps and their enable line.
pub struct LampPair<Top, Bottom, Enable> {
    top: Top,
    bottom: Bottom,
    enable: Enable,
}

impl<Top: SetDutyCycle, Bottom: SetDutyCycle, Enable: OutputPin> LampPair<Top, Bottom, Enable> {
    /// Takes the outputs and makes them dark.
    ///
    /// # Errors
    /// The first output that could not be made dark.
    pub fn new(top: Top, bottom: Bottom, enable: Enable) -> Result<Self, LampError> {
        let mut pair = Self { top, bottom, enable };
        pair.dark()?;
        Ok(pair)
    }

    /// Lights both lamps; a pair of zeros is dark. After an error both lamps are dark, as far as they obey.
    ///
    /// # Errors
    /// The first output that could not be set.
    pub fn light(&mut self, counts: Counts) -> Result<(), LampError> {
        if counts == Counts::default() {
            return self.dark();
        }
        let lit = self.try_light(counts);
        if lit.is_err() {
            // The first error is the one to report.
            let _ = self.dark();
        }
        lit
    }

    /// Makes both lamps dark: tries every output, whatever the others answer.
    ///
    /// # Errors
    /// The first output that could not be set.
    pub fn dark(&mut self) -> Result<(), LampError> {
        let top = self.top.set_duty_cycle_fully_off().map_err(|_| LampError::TopDimming);
        let bottom = self.bottom.set_duty_cycle_fully_off().map_err(|_| LampError::BottomDimming);
        let enable = self.enable.set_low().map_err(|_| LampError::Enable);
        top.and(bottom).and(enable)
    }

    /// Gives the outputs back.
    pub fn release(self) -> (Top, Bottom, Enable) {
        (self.top, self.bottom, self.enable)
    }

    fn try_light(&mut self, counts: Counts) -> Result<(), LampError> {
        let top = counts.top.min(self.top.max_duty_cycle());
        let bottom = counts.bottom.min(self.bottom.max_duty_cycle());
        self.top.set_duty_cycle(top).map_err(|_| LampError::TopDimming)?;
        self.bottom.set_duty_cycle(bottom).map_err(|_| LampError::BottomDimming)?;
        self.enable.set_high().map_err(|_| LampError::Enable)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use core::cell::RefCell;
    use core::convert::Infallible;

    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    enum Event {
        Top(u16),
        Bottom(u16),
        Enable(bool),
    }

    type Log = RefCell<heapless::Vec<Event, 16>>;

    struct Dimming<'a> {
        log: &'a Log,
        event: fn(u16) -> Event,
        works: bool,
    }

    #[derive(Debug)]
    struct Broken;
    impl embedded_hal::pwm::Error for Broken {
        fn kind(&self) -> embedded_hal::pwm::ErrorKind {
            embedded_hal::pwm::ErrorKind::Other
        }
    }
    impl embedded_hal::pwm::ErrorType for Dimming<'_> {
        type Error = Broken;
    }
    impl SetDutyCycle for Dimming<'_> {
        fn max_duty_cycle(&self) -> u16 {
            62_500
        }
        fn set_duty_cycle(&mut self, duty: u16) -> Result<(), Broken> {
            if !self.works {
                return Err(Broken);
            }
            self.log.borrow_mut().push((self.event)(duty)).unwrap();
            Ok(())
        }
    }

    struct Line<'a>(&'a Log);
    impl embedded_hal::digital::ErrorType for Line<'_> {
        type Error = Infallible;
    }
    impl OutputPin for Line<'_> {
        fn set_low(&mut self) -> Result<(), Infallible> {
            self.0.borrow_mut().push(Event::Enable(false)).unwrap();
            Ok(())
        }
        fn set_high(&mut self) -> Result<(), Infallible> {
            self.0.borrow_mut().push(Event::Enable(true)).unwrap();
            Ok(())
        }
    }

    fn pair(log: &Log, top_works: bool) -> Result<LampPair<Dimming<'_>, Dimming<'_>, Line<'_>>, LampError> {
        LampPair::new(
            Dimming { log, event: Event::Top, works: top_works },
            Dimming { log, event: Event::Bottom, works: true },
            Line(log),
        )
    }

    #[test]
    fn starts_dark_with_the_enable_line_last() {
        let log = Log::default();
        pair(&log, true).unwrap();
        assert_eq!(log.borrow().as_slice(), [Event::Top(0), Event::Bottom(0), Event::Enable(false)]);
    }

    #[test]
    fn enables_only_after_both_levels_stand() {
        let log = Log::default();
        let mut lamps = pair(&log, true).unwrap();
        log.borrow_mut().clear();
        lamps.light(Counts { top: 62_500, bottom: 1 }).unwrap();
        assert_eq!(log.borrow().as_slice(), [Event::Top(62_500), Event::Bottom(1), Event::Enable(true)]);
    }

    #[test]
    fn two_zeros_are_dark() {
        let log = Log::default();
        let mut lamps = pair(&log, true).unwrap();
        log.borrow_mut().clear();
        lamps.light(Counts::default()).unwrap();
        assert!(log.borrow().contains(&Event::Enable(false)));
        assert!(!log.borrow().contains(&Event::Enable(true)));
    }

    #[test]
    fn a_failing_output_darkens_the_others() {
        let log = Log::default();
        assert_eq!(pair(&log, false).err(), Some(LampError::TopDimming));
        assert_eq!(log.borrow().as_slice(), [Event::Bottom(0), Event::Enable(false)]);

        let mut lamps = pair(&log, true).unwrap();
        lamps.top.works = false;
        log.borrow_mut().clear();
        assert_eq!(lamps.light(Counts { top: 1, bottom: 1 }), Err(LampError::TopDimming));
        assert_eq!(log.borrow().as_slice(), [Event::Bottom(0), Event::Enable(false)]);
    }

    #[test]
    fn more_than_always_is_always() {
        let log = Log::default();
        let mut lamps = pair(&log, true).unwrap();
        log.borrow_mut().clear();
        lamps.light(Counts { top: u16::MAX, bottom: 62_500 }).unwrap();
        assert_eq!(log.borrow().as_slice(), [Event::Top(62_500), Event::Bottom(62_500), Event::Enable(true)]);
    }
}
