//! What is seen of a heater, and what can be wrong with it: the words all laws speak.

use config::HeaterId;
use units::{Celsius, Micros};

use crate::heat::SensorFault;

/// How often every heater is looked at.
pub const LOOK_PERIOD: Micros = Micros::from_millis(50);
/// Targets up to this are "off": 1 and 2 are preset numbers in Smoothieware configurations.
pub const OFF_BELOW: Celsius = Celsius(2.0);

/// Why heating was stopped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HeatCause {
    /// The sensor gives no usable reading: open, shorted or silent.
    NoReading(SensorFault),
    /// Reading below `min_temp` while heating.
    BelowMinimum(Celsius),
    /// Reading above `max_temp` while heating.
    AboveMaximum(Celsius),
    /// The reading rose by this much in a second: no heater does that.
    RisesTooFast(Celsius),
    /// The reading fell by this much in a second: no heater cools so fast, so the sensor has come off.
    FallsTooFast(Celsius),
    /// The reading fell by this much within three seconds although the heater was at full output: it has
    /// failed, or its sensor slides out.
    FallsWhileDriven(Celsius),
    /// It warmed at full output, and from one moment to the next did not: its sensor slides out, or a part of
    /// it has failed.
    Stalls,
    /// The reading jumps up and down: a loose contact, or noise on its wire.
    Erratic,
    /// Driven as if for so many seconds at full output, it did not warm by this much.
    NoResponse(Micros, Celsius),
    /// It was at its target, and has sunk below it for too long; by how much it is below.
    Sinking(Celsius),
    /// The reading was exactly the same for so long, whatever the heater was given.
    Frozen(Micros),
    /// The target was not reached within the heating timeout.
    HeatingTooSlow,
    /// Hot and above a lower target, it did not cool at all within the cooling timeout; what it reads.
    DoesNotCool(Celsius),
    /// The temperature left the target by more than `runaway_range`; the difference.
    Runaway(Celsius),
    /// It warms although it is switched off: its MOSFET, or what stands for one, conducts. The rise since it
    /// was off.
    StuckOn(Celsius),
    /// It warms the sensor of this heater, and not its own.
    Swapped(HeaterId),
    /// Fully driven for so long without a pause.
    FullTooLong(Micros),
    /// On at one target for so long.
    HeldTooLong(Micros),
    /// Its pin was on although nothing asks for heat: a mistake of this firmware.
    DrivenWithoutTarget,
    /// The dispatcher stopped reporting.
    DispatcherSilent,
}

/// A heating fault: which controller, and why.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HeatFault {
    /// Which temperature control.
    pub heater: HeaterId,
    /// What happened.
    pub cause: HeatCause,
}

/// What is seen of one heater in one look.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Look {
    pub(super) now: Micros,
    /// The temperature, when the sensor gives one.
    pub(super) reading: Option<Celsius>,
    /// Why it gives none.
    pub(super) fault: Option<SensorFault>,
    /// What it is asked for; 0 is off.
    pub(super) target: Celsius,
    /// Share of full output its pin was given since the last look, 0 to 1.
    pub(super) driven: f32,
    /// Another heater of the machine is on.
    pub(super) another_on: bool,
    /// Another heater that is on is warmer than this one, and may keep it warm.
    pub(super) beside_warmer: bool,
}

impl Look {
    pub(super) fn is_on(&self) -> bool {
        self.target > OFF_BELOW
    }
}
