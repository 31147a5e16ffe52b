//! Facts about a heater that all laws share: a look at it, and the causes of faults.

use config::HeaterId;
use units::{Celsius, Micros};

use crate::sensor::SensorFault;

/// Period of the looks at every heater.
pub const LOOK_PERIOD: Micros = Micros::from_millis(50);
/// Targets up to this are "off": 1 and 2 are preset numbers in Smoothieware configurations.
pub const OFF_BELOW: Celsius = Celsius(2.0);

/// Reason why heating was stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeatCause {
    /// The sensor gives no usable reading: open, shorted or silent.
    NoReading(SensorFault),
    /// Reading below `min_temp` while heating.
    BelowMinimum(Celsius),
    /// Reading above `max_temp` while heating.
    AboveMaximum(Celsius),
    /// The reading rose by this much in a second, which no heater does.
    RisesTooFast(Celsius),
    /// The reading fell by this much in a second: no heater cools so fast, so the sensor has come off.
    FallsTooFast(Celsius),
    /// The reading fell by this much within three seconds although the heater was at full output: the heater
    /// has failed, or its sensor slides out.
    FallsWhileDriven(Celsius),
    /// The heater warmed at full output, and suddenly did not: its sensor slides out, or a part of it has
    /// failed.
    Stalls,
    /// The reading jumps up and down: a loose contact, or noise on its wire.
    Erratic,
    /// The heater did not warm by this much after an effort of this time at full output.
    NoResponse(Micros, Celsius),
    /// The heater was at its target, and has been too far below it for too long; the distance below.
    Sinking(Celsius),
    /// The reading was exactly the same for this long, although the heater's output changed.
    Frozen(Micros),
    /// The target was not reached within the heating timeout.
    HeatingTooSlow,
    /// Hot and above a lower target, the heater did not cool at all within the cooling timeout; the reading.
    DoesNotCool(Celsius),
    /// The temperature left the target by more than `runaway_range`; the difference.
    Runaway(Celsius),
    /// The heater warms although it is switched off: its MOSFET or relay conducts. The rise since switch-off.
    StuckOn(Celsius),
    /// The heater warms the sensor of this heater, and not its own.
    Swapped(HeaterId),
    /// Fully driven for this long without a pause.
    FullTooLong(Micros),
    /// On at a single target for this long.
    HeldTooLong(Micros),
    /// The pin was on although nothing asks for heat: a mistake of this firmware.
    DrivenWithoutTarget,
    /// The executor stopped reporting.
    ExecutorSilent,
}

/// A heating fault: the temperature control, and the cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatFault {
    /// The faulty temperature control.
    pub heater: HeaterId,
    /// Cause of the fault.
    pub cause: HeatCause,
}

/// Observations of a heater in a single look.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Look {
    pub(super) now: Micros,
    /// The temperature, when the sensor gives one.
    pub(super) reading: Option<Celsius>,
    /// Reason why the sensor gives no temperature.
    pub(super) fault: Option<SensorFault>,
    /// Target of the heater; 0 is off.
    pub(super) target: Celsius,
    /// Share of full output that the pin was given since the last look, 0 to 1.
    pub(super) driven: f32,
    /// Whether another heater of the machine is on.
    pub(super) another_on: bool,
    /// Whether another heater that is on is warmer than this, and may keep it warm.
    pub(super) beside_warmer: bool,
}

impl Look {
    pub(super) fn is_on(&self) -> bool {
        self.target > OFF_BELOW
    }
}
