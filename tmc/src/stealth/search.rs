//! Current and load measurement during a search for a motor stall, and their restoration.

use super::bus::RegisterBus;
use super::current::StealthCurrent;
use super::driver::StealthDriver;
use super::settings::StealthSettings;
use super::{LONGEST_STEP_TIME, LoadMeasurement};
use crate::Error;
use units::Amps;

/// Search for a stall in progress.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    threshold: i16,
    /// Current to restore at the end of the search.
    before: StealthCurrent,
}

impl<BUS: RegisterBus> StealthDriver<BUS> {
    /// Returns the settings that the chip should have now.
    ///
    /// During a search, load is measured at any speed, as the machine decides when to look; without a filter,
    /// with which the rotor would fall out of step before the four full steps of an average; without
    /// coolStep, which would change the current that the measurement depends on; and with the chopper that
    /// the measurement needs.
    pub(super) fn in_force(&self) -> StealthSettings {
        let Some(search) = self.search else { return self.settings };
        StealthSettings {
            stall_threshold: search.threshold,
            stall_filter: false,
            stall_output: true,
            load_from: Some(LONGEST_STEP_TIME),
            cool_step: None,
            stealth_threshold: (self.chip.load() == LoadMeasurement::StallGuard4).then_some(0),
            ..self.settings
        }
    }

    /// Sets the load measurement and, if given, the peak current. The motor must stand still. The earlier
    /// settings are kept for [`Self::end_search`].
    ///
    /// # Errors
    /// [`Error::Setting`] for a threshold that the chip does not have, else as [`Self::status`].
    pub fn begin_search(&mut self, threshold: i16, peak: Option<Amps>) -> Result<(), Error<BUS::Error>> {
        StealthSettings { stall_threshold: threshold, stall_output: true, ..self.settings }.check(self.chip)?;
        let before = self.search.map_or(self.current, |search| search.before);
        self.search = Some(Search { threshold, before });
        self.write_mode_and_load()?;
        peak.map_or(Ok(()), |peak| self.set_current(peak).map(drop))
    }

    /// Restores the settings from before [`Self::begin_search`]; does nothing without a search. A silent chip
    /// gets them with the next [`Self::enable`].
    ///
    /// # Errors
    /// As [`Self::status`].
    pub fn end_search(&mut self) -> Result<(), Error<BUS::Error>> {
        let Some(search) = self.search.take() else { return Ok(()) };
        let now = core::mem::replace(&mut self.current, search.before);
        let done = self.write_current(now).and_then(|()| self.write_mode_and_load());
        self.is_stale = done.is_err();
        done
    }

    pub(super) fn write_mode_and_load(&mut self) -> Result<(), Error<BUS::Error>> {
        let settings = self.in_force();
        let mode = settings.mode_words(self.chip).map(Some);
        for (register, word) in mode.into_iter().chain(settings.load_words(self.chip)).flatten() {
            self.bus.write(register.address, word)?;
        }
        Ok(())
    }
}
