//! State and faults that a stealthChop chip reports.

use super::StealthChip;
use super::register::{drv_status, gstat, wire};
use crate::register::Field;

/// Contents of DRV_STATUS and of the relevant flags of GSTAT.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StealthStatus {
    /// The chip was reset since it was set up: it has lost its settings, and its bridges are off.
    pub reset: bool,
    /// Too little voltage at the charge pump; bridges are off meanwhile.
    pub charge_pump_low: bool,
    /// Too hot: bridges are shut.
    pub over_temperature: bool,
    /// Temperature warning, before a shutdown.
    pub over_temperature_warning: bool,
    /// Coil A, coil B shorted to ground; bridges are shut until disabled and enabled again.
    pub short: [bool; 2],
    /// Coil A, coil B shorted to the motor supply. A TMC2130 does not tell.
    pub supply_short: [bool; 2],
    /// Coil A, coil B seems not connected. True at slow motion only.
    pub open_load: [bool; 2],
    /// No step for 2^20 chip clocks.
    pub standstill: bool,
    /// stealthChop drives the motor now. A TMC2130 does not tell.
    pub stealth: bool,
    /// Load reading of stallGuard2: 0 (stalled) to 1023 (no load), for spreadCycle. Chips on a UART have it
    /// in another register.
    pub stall_guard: u16,
    /// Current scale in force, 0 to 31.
    pub current_scale: u8,
}

impl StealthStatus {
    /// Decodes the two registers.
    #[must_use]
    pub fn decode(chip: StealthChip, status: u32, global: u32) -> Self {
        if chip.is_on_wire() {
            return Self::of_wire(status, global);
        }
        let bit = |field: Field| field.get(status) == 1;
        // Bits 12 to 14 are reserved in a TMC2130.
        let new = |field: Field| chip != StealthChip::Tmc2130 && bit(field);
        Self {
            reset: gstat::RESET.get(global) == 1,
            charge_pump_low: gstat::UV_CP.get(global) == 1,
            over_temperature: bit(drv_status::OT),
            over_temperature_warning: bit(drv_status::OTPW),
            short: [bit(drv_status::S2GA), bit(drv_status::S2GB)],
            supply_short: [new(drv_status::S2VSA), new(drv_status::S2VSB)],
            open_load: [bit(drv_status::OLA), bit(drv_status::OLB)],
            standstill: bit(drv_status::STST),
            stealth: new(drv_status::STEALTH),
            stall_guard: drv_status::SG_RESULT.get(status) as u16,
            current_scale: drv_status::CS_ACTUAL.get(status) as u8,
        }
    }

    /// Decodes the registers of a chip on a UART, whose bits have other places.
    fn of_wire(status: u32, global: u32) -> Self {
        use wire::drv_status as field;
        let bit = |field: Field| field.get(status) == 1;
        Self {
            reset: gstat::RESET.get(global) == 1,
            charge_pump_low: gstat::UV_CP.get(global) == 1,
            over_temperature: bit(field::OT),
            over_temperature_warning: bit(field::OTPW),
            short: [bit(field::S2GA), bit(field::S2GB)],
            supply_short: [bit(field::S2VSA), bit(field::S2VSB)],
            open_load: [bit(field::OLA), bit(field::OLB)],
            standstill: bit(field::STST),
            stealth: bit(field::STEALTH),
            stall_guard: 0,
            current_scale: field::CS_ACTUAL.get(status) as u8,
        }
    }
}
