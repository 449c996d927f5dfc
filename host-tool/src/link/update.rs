//! Bringing new firmware to a controller, and waiting until it runs for good.

use std::{
    thread,
    time::{Duration, Instant},
};

use vitrine_protocol::{
    Refusal, Request, Response, firmware,
    firmware::{FirmwareState, Outcome},
    plan_file,
};

use super::{Address, Client, LinkError, Progress, Stage};
use crate::firmware::SignedImage;

/// How often is looked what the controller does.
const LOOK: Duration = Duration::from_millis(200);

/// The longest that an update takes after the restart: keeping one image and installing another, a minute on trial, and
/// going back. Each of three copies erases 80 sectors of 400 ms at worst and writes 1,280 pages of 3 ms at worst (W25Q16JV
/// data sheet, 9.6): 36 s.
const LONGEST_UPDATE: Duration = Duration::from_secs(3 * 36 + 60 + 12);

/// What became of an update.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Installed {
    /// It runs and has confirmed itself.
    Confirmed(FirmwareState),
    /// It is not to stay, and why; what runs in its place.
    Not(Outcome, FirmwareState),
}

impl Client {
    /// What firmware runs, and how far is its update?
    ///
    /// # Errors
    /// Those of the link.
    pub fn firmware(&mut self) -> Result<FirmwareState, LinkError> {
        match self.ask(&Request::Firmware)? {
            Response::Firmware(state) => Ok(state),
            _ => Err(self.wrong_answer()),
        }
    }

    /// Sends new firmware; the controller reads back what it writes, verifies the whole, and installs it at its next start. An
    /// update that broke off is continued.
    ///
    /// # Errors
    /// Those of the link, and the controller's refusal.
    pub fn send_firmware(
        &mut self,
        image: &SignedImage,
        progress: &mut dyn FnMut(Progress),
    ) -> Result<(), LinkError> {
        let crc = plan_file::crc(&image.bytes);
        let begin = Request::BeginUpdate { length: image.bytes.len() as u32, crc };
        self.send_and_commit(&begin, &image.bytes, crc, progress)
    }

    /// Restarts the controller, which ends this connection.
    ///
    /// # Errors
    /// Those of the link.
    pub fn restart(mut self) -> Result<(), LinkError> {
        match self.ask(&Request::Restart) {
            Ok(Response::Done) => Ok(()),
            Ok(_) => Err(self.wrong_answer()),
            // It may be gone before its answer is through.
            Err(error) if error.is_passing() => Ok(()),
            Err(error) => Err(error),
        }
    }
}

/// Brings new firmware to a controller: sends it, restarts the controller, waits until it is there again and until the new
/// firmware has confirmed itself. `find` tells where the controller is, each time anew: a serial port may come back under
/// another name.
///
/// # Errors
/// Those of the link, the controller's refusal, and a controller that does not come back.
pub fn update(
    mut client: Client,
    image: &SignedImage,
    find: &dyn Fn() -> Result<Address, LinkError>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Installed, LinkError> {
    let address = client.address().clone();
    client.send_firmware(image, progress)?;
    client.restart()?;
    let begun = Instant::now();
    loop {
        thread::sleep(LOOK);
        match look(find) {
            Ok(state) => match state.progress {
                firmware::Progress::Settled(Outcome::Confirmed) if state.digest == image.header.digest => {
                    return Ok(Installed::Confirmed(state));
                }
                firmware::Progress::Settled(outcome) => return Ok(Installed::Not(outcome, state)),
                firmware::Progress::OnTrial => progress(waiting(Stage::OnTrial, begun)),
                // Until it has really gone down it tells that it wants to.
                _ => progress(waiting(Stage::Installing, begun)),
            },
            Err(error) if is_away(&error) => progress(waiting(Stage::Installing, begun)),
            Err(error) => return Err(error),
        }
        if begun.elapsed() > LONGEST_UPDATE {
            return Err(LinkError::Silent { address, seconds: LONGEST_UPDATE.as_secs_f64() });
        }
    }
}

fn look(find: &dyn Fn() -> Result<Address, LinkError>) -> Result<FirmwareState, LinkError> {
    Client::open_for_update(&find()?)?.firmware()
}

/// So many seconds of the longest time have gone.
fn waiting(stage: Stage, begun: Instant) -> Progress {
    let seconds = |time: Duration| usize::try_from(time.as_secs()).unwrap_or(usize::MAX);
    Progress { stage, done: seconds(begun.elapsed()), total: seconds(LONGEST_UPDATE) }
}

/// A boot loader does not answer, and its USB port is gone.
const fn is_away(error: &LinkError) -> bool {
    error.is_passing()
        || matches!(
            error,
            LinkError::NotOurs { .. }
                | LinkError::NoneFound
                | LinkError::WrongAnswer { .. }
                | LinkError::Refused { refusal: Refusal::TooManyRequests { .. }, .. }
        )
}
