//! The chopper in use, and the stall signal of a chip.

use super::{CHOPCONF, GCONF, StealthKind, TCOOLTHRS, TPWMTHRS, TmcStealth};

/// TSTEP of a motor that stands.
const STANDS: u32 = 0xF_FFFF;

impl TmcStealth {
    /// Returns "TSTEP": clocks between two steps of 1/256.
    pub(super) fn step_time(&self, now_ns: u64) -> u32 {
        let Some(step_ns) = self.step_ns.filter(|_| !self.stands(now_ns)) else { return STANDS };
        let clocks = step_ns * self.kind.clock_mhz() / 1_000 / u64::from(256 / self.microsteps());
        u32::try_from(clocks).unwrap_or(STANDS).min(STANDS)
    }

    /// Returns whether stealthChop is enabled ("en_pwm_mode"; "en_spreadCycle" 0), and the motor no faster
    /// than TPWMTHRS.
    pub(super) fn uses_stealth_chop(&self, now_ns: u64) -> bool {
        let bit = self.registers[GCONF] >> 2 & 1 == 1;
        let enabled = bit != self.kind.is_on_wire();
        enabled && self.step_time(now_ns) >= self.registers[TPWMTHRS]
    }

    /// Returns whether a DIAG pin signals a stall: the chopper drives whose load is measured, the motor is
    /// at least as fast as TCOOLTHRS says, and the reading is at its end. The pins of chips on SPI have to
    /// be enabled ("diag0_stall", "diag1_stall").
    #[must_use]
    pub fn stall_output(&self, now_ns: u64) -> bool {
        let is_fast = self.step_ns.is_some() && self.step_time(now_ns) <= self.registers[TCOOLTHRS];
        let is_stalled = match self.kind {
            StealthKind::Tmc2208 => false,
            StealthKind::Tmc2209 => {
                self.uses_stealth_chop(now_ns) && u32::from(self.load) <= 2 * (self.registers[0x40] & 0xFF)
            }
            _ => !self.uses_stealth_chop(now_ns) && self.load == 0 && self.registers[GCONF] >> 7 & 0b11 != 0,
        };
        self.drives() && is_fast && is_stalled
    }

    /// Returns the settings of the load measurement that the world needs: stallGuard2's threshold and filter,
    /// COOLCONF bits 22 to 16 and 24; none for stallGuard4, whose threshold shifts nothing.
    #[must_use]
    pub const fn stall_guard_2(&self) -> Option<(i32, bool)> {
        match self.kind {
            StealthKind::Tmc2208 | StealthKind::Tmc2209 => None,
            _ => {
                let bits = (self.registers[0x6D] >> 16 & 0x7F) as i32;
                Some((if bits < 64 { bits } else { bits - 128 }, self.registers[0x6D] >> 24 & 1 == 1))
            }
        }
    }

    /// Returns whether the bridges are told to be on.
    #[must_use]
    pub const fn is_on(&self) -> bool {
        self.registers[CHOPCONF] & 0xF != 0
    }
}
