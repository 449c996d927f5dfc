//! The settings by which all owners go, as read from flash at the start or changed since.

use core::cell::RefCell;

use embassy_sync::blocking_mutex::CriticalSectionMutex;
use vitrine_exhibit::settings::Settings;

static NOW: CriticalSectionMutex<RefCell<Option<Settings>>> = CriticalSectionMutex::new(RefCell::new(None));

/// The settings now.
pub(crate) fn now() -> Settings {
    with(Settings::clone)
}

/// Looks at the settings without a copy.
pub(crate) fn with<R>(look: impl FnOnce(&Settings) -> R) -> R {
    NOW.lock(|now| look(now.borrow().as_ref().unwrap_or(&Settings::default())))
}

/// Goes by other settings from now on.
pub(crate) fn change(settings: &Settings) {
    NOW.lock(|now| *now.borrow_mut() = Some(settings.clone()));
}
