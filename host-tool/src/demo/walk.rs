//! A viewer walks past a simulated controller that was given its plan over the real link.

use miette::Diagnostic;
use serde::{Deserialize, Serialize};
use thiserror::Error;
use vitrine_exhibit::units::Level;
use vitrine_exhibit::viewer::Bearing;
use vitrine_protocol::{Refusal, Status};

use crate::controller::{Clock, FlashFile, Pace, ServeError, Viewer, VirtualController, serve};
use crate::link::{Address, Client, LinkError};

/// How long the controller sees the empty room: its sensors learn their background in that time.
const EMPTY_ROOM_MS: u32 = 8_000;
/// How long the viewer stands still before the walk, so that the first view is up.
const FIRST_STAND_MS: u32 = 3_000;
const FIRST_DEG: i16 = -45;
const LAST_DEG: i16 = 45;
const STEP_DEG: i16 = 3;
/// The time in which the viewer walks `STEP_DEG`: at 1.2 m, 4 cm/s.
const STEP_MS: u32 = 1_500;

/// One moment of the walk, as the controller tells it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Moment {
    /// Simulated time since the controller's start.
    pub time_s: f64,
    /// Where the viewer is.
    pub viewer_deg: f64,
    /// Where the controller's sensors see the viewer.
    pub seen_deg: Option<f64>,
    /// The view that is emphasised.
    pub view: Option<String>,
    /// Level of the lamp on the viewer's side, 0..=1.
    pub top: f64,
    /// Level of the lamp behind the stack, 0..=1.
    pub bottom: f64,
    /// Why the lamps are dark, if they are.
    pub dark: Option<String>,
}

/// Why the walk did not come about.
#[derive(Debug, Error, Diagnostic)]
pub enum WalkError {
    /// The simulated controller does not start.
    #[error("the simulated controller does not start: {0}")]
    #[diagnostic(code(vitrine::demo::controller), help("this is a fault of vitrine: please report it"))]
    Controller(Refusal),
    /// It cannot be reached.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Serve(#[from] ServeError),
    /// The link fails.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Link(#[from] LinkError),
}

/// Starts a simulated controller, uploads `plan` over the link, and lets a viewer walk from -45 to +45 degrees in
/// simulated time; `tell` hears of every moment as it happens.
///
/// # Errors
/// Fails when the controller cannot be started or reached, and when it refuses the plan.
pub fn walk(plan: &[u8], tell: &mut dyn FnMut(&Moment)) -> Result<Vec<Moment>, WalkError> {
    let controller =
        VirtualController::new(FlashFile::in_memory(), Clock::Computer).map_err(WalkError::Controller)?;
    let served = serve(controller, "127.0.0.1:0", Pace::Manual)?;
    let mut client = Client::open(&Address::Tcp(served.address().to_string()))?;
    client.upload(plan, &mut |_| {})?;
    let stand = |degrees: i16, ms: u32| {
        let mut controller = served.controller();
        controller.set_viewer(Some(Viewer::at(Bearing::new(degrees * 100, 0))));
        controller.advance(ms);
    };
    {
        let mut controller = served.controller();
        controller.set_viewer(None);
        controller.advance(EMPTY_ROOM_MS);
    }
    stand(FIRST_DEG, FIRST_STAND_MS);
    let mut moments = Vec::new();
    for degrees in (FIRST_DEG..=LAST_DEG).step_by(STEP_DEG as usize) {
        stand(degrees, STEP_MS);
        let moment = Moment::new(degrees, &client.status()?);
        tell(&moment);
        moments.push(moment);
    }
    Ok(moments)
}

impl Moment {
    fn new(viewer_deg: i16, status: &Status) -> Self {
        let snapshot = &status.snapshot;
        let part = |level: Level| f64::from(level.0) / f64::from(Level::FULL.0);
        let shown = status.plan.as_ref().map(|plan| plan.view_id.as_str()).filter(|id| !id.is_empty());
        Self {
            time_s: snapshot.uptime_ms as f64 / 1000.0,
            viewer_deg: f64::from(viewer_deg),
            seen_deg: snapshot.bearing.map(|bearing| f64::from(bearing.horizontal.0) / 100.0),
            view: shown.map(str::to_owned),
            top: part(snapshot.levels.top),
            bottom: part(snapshot.levels.bottom),
            dark: snapshot.dark.map(|reason| reason.to_string()),
        }
    }
}
