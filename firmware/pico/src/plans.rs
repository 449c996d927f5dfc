//! The plan in flash, the one that is active, and the one that is being uploaded.

use defmt::{info, warn};
use heapless::{String, Vec};
use vitrine_exhibit::plan::{Bounds, MAX_VIEWS, ValidPlan};
use vitrine_protocol::Refusal;
use vitrine_protocol::plan_file::{self, MAX_PLAN_BYTES};
use vitrine_protocol::status::PlanState;
use vitrine_storage::map::PLAN;
use vitrine_storage::{Record, Writer};

use crate::controller::{NEW_PLAN, OLD_PLAN, PlanSlot};
use crate::steady_flash::{Chip, RETRY, refusal};

/// What the store remembers of the active plan, which itself is the controller's.
struct Active {
    record: Record,
    name: String<48>,
    views: Vec<String<24>, MAX_VIEWS>,
    bounds: Bounds,
}

/// Room for a plan as stored.
pub(crate) type Buffer = [u8; MAX_PLAN_BYTES];

/// All plans but the one in the controller's hands.
pub(crate) struct Plans {
    /// Where a plan's bytes are read to: too many for the stack.
    buffer: &'static mut Buffer,
    active: Option<Active>,
    upload: Option<Writer>,
    spare: Option<PlanSlot>,
}

impl Plans {
    /// Reads the newest plan into the controller's slot. A plan that cannot be read or is unfit is none.
    pub(crate) fn load(
        chip: &mut Chip,
        slot: &mut Option<ValidPlan>,
        spare: PlanSlot,
        buffer: &'static mut Buffer,
    ) -> Self {
        let mut plans = Self { buffer, active: None, upload: None, spare: Some(spare) };
        match PLAN.newest(chip) {
            Ok(Some(record)) => match read(chip, &record, plans.buffer, slot) {
                Ok(plan) => {
                    plans.active = Some(Active::new(record, plan));
                    info!("plan '{}' with {} views", plan.name.as_str(), plan.views.len());
                }
                Err(refusal) => warn!("the plan in flash is no use: {}", defmt::Debug2Format(&refusal)),
            },
            Ok(None) => info!("no plan in flash"),
            Err(_) => warn!("the plan cannot be read"),
        }
        plans
    }

    /// Takes back the slot of the plan before, when the controller has let it go.
    pub(crate) fn take_back(&mut self) {
        if let Ok(slot) = OLD_PLAN.try_receive() {
            *slot = None;
            self.spare = Some(slot);
        }
    }

    /// The active plan's name; empty without one.
    pub(crate) fn name(&self) -> String<48> {
        self.active.as_ref().map(|active| active.name.clone()).unwrap_or_default()
    }

    /// What is told of the active plan.
    pub(crate) fn state(&self, shown: Option<u8>) -> Option<PlanState> {
        let active = self.active.as_ref()?;
        let view_id = shown.and_then(|view| active.views.get(usize::from(view))).cloned().unwrap_or_default();
        Some(PlanState {
            crc: active.record.crc(),
            length: active.record.length(),
            name: active.name.clone(),
            views: u8::try_from(active.views.len()).unwrap_or(u8::MAX),
            view_id,
        })
    }

    /// How many views the active plan has.
    pub(crate) fn views(&self) -> u8 {
        self.active.as_ref().map_or(0, |active| u8::try_from(active.views.len()).unwrap_or(u8::MAX))
    }

    /// Prepares the inactive slot.
    pub(crate) fn begin(&mut self, chip: &mut Chip, length: u32) -> Result<(), Refusal> {
        let most = u32::try_from(MAX_PLAN_BYTES).unwrap_or(u32::MAX);
        if length == 0 || length > most {
            return Err(Refusal::PlanLength { most });
        }
        self.upload = Some(PLAN.begin(chip, length).map_err(refusal)?);
        Ok(())
    }

    /// Whether [`Plans::append`] of so many bytes will erase a sector.
    pub(crate) fn will_erase(&self, bytes: usize) -> bool {
        let bytes = u32::try_from(bytes).unwrap_or(u32::MAX);
        self.upload.as_ref().is_some_and(|writer| writer.will_erase(bytes))
    }

    /// Writes the next bytes.
    pub(crate) fn append(&mut self, chip: &mut Chip, bytes: &[u8]) -> Result<(), Refusal> {
        let writer = self.upload.as_mut().ok_or(Refusal::NoUpload)?;
        writer.append(chip, bytes).map_err(refusal)
    }

    /// Holds what was uploaded against its CRC, before it is valid.
    fn staged(&self, chip: &mut Chip, crc: u32) -> Result<Record, Refusal> {
        let writer = self.upload.as_ref().ok_or(Refusal::NoUpload)?;
        let staged = writer.staged(chip).map_err(|_| Refusal::StorageFailed)?;
        if staged.crc() != crc {
            return Err(Refusal::Checksum { expected: crc, found: staged.crc() });
        }
        Ok(staged)
    }

    /// Tells whether the upload asks for more than the active plan does.
    pub(crate) fn asks_for_more(&mut self, chip: &mut Chip, crc: u32) -> Result<bool, Refusal> {
        let staged = self.staged(chip, crc)?;
        self.take_back();
        let slot = self.spare.as_mut().ok_or(Refusal::LampsInMotion { retry: RETRY })?;
        let plan = read(chip, &staged, self.buffer, slot)?;
        Ok(match &self.active {
            Some(active) => active.bounds.are_exceeded_by(plan),
            None => Bounds::default().are_exceeded_by(plan),
        })
    }

    /// Verifies the upload, makes it the newest record and hands it to the controller.
    pub(crate) fn commit(&mut self, chip: &mut Chip, crc: u32) -> Result<(), Refusal> {
        let staged = self.staged(chip, crc)?;
        // The slot of the plan before comes back within one step.
        self.take_back();
        let Some(slot) = self.spare.take() else { return Err(Refusal::LampsInMotion { retry: RETRY }) };
        let made = self.make_active(chip, &staged, slot);
        match made {
            // There is one spare slot, so the channel of one is empty.
            Ok(()) => drop(NEW_PLAN.try_send(slot)),
            Err(_) => self.spare = Some(slot),
        }
        made?;
        info!("new plan, CRC {:08x}", crc);
        Ok(())
    }

    fn make_active(
        &mut self,
        chip: &mut Chip,
        staged: &Record,
        slot: &mut Option<ValidPlan>,
    ) -> Result<(), Refusal> {
        let plan = read(chip, staged, self.buffer, slot)?;
        let writer = self.upload.take().ok_or(Refusal::NoUpload)?;
        let record = writer.finish(chip).map_err(|_| Refusal::StorageFailed)?;
        self.active = Some(Active::new(record, plan));
        Ok(())
    }

    /// Reads the active plan back.
    pub(crate) fn read(
        &self,
        chip: &mut Chip,
        offset: u32,
        part: &mut [u8],
    ) -> Result<(u32, usize), Refusal> {
        let record = self.active.as_ref().ok_or(Refusal::NoPlan)?.record;
        let bytes = record.read(chip, offset, part).map_err(|_| Refusal::StorageFailed)?;
        Ok((record.length(), bytes))
    }
}

impl Active {
    fn new(record: Record, plan: &ValidPlan) -> Self {
        Self {
            record,
            name: plan.name.clone(),
            views: plan.views.iter().map(|view| view.id.clone()).collect(),
            bounds: Bounds::of(plan),
        }
    }
}

/// Reads a plan into a slot: a plan is too large to be handed about on the stack.
fn read<'a>(
    chip: &mut Chip,
    record: &Record,
    buffer: &mut Buffer,
    slot: &'a mut Option<ValidPlan>,
) -> Result<&'a ValidPlan, Refusal> {
    *slot = None;
    let used = record.read(chip, 0, buffer).map_err(|_| Refusal::StorageFailed)?;
    let bytes = buffer.get(..used).ok_or(Refusal::StorageFailed)?;
    let decoded = plan_file::decode(bytes);
    let plan = decoded.as_ref().map_err(|_| Refusal::UnreadablePlan)?;
    ValidPlan::put(plan, slot).map_err(Refusal::UnfitPlan)
}
