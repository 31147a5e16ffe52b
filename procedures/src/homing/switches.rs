//! Switches that axes home on, and their levels.

use base::ports::{Input, InputLevels};
use config::{EndstopConfig, HomingDirection, MachineConfig};
use units::{Axis, AxisSet, MmPerSecond};

/// Returns the switch that an axis homes on, and its input. `None` for an axis that cannot be homed: no such
/// switch, no pin, no motor.
pub(super) fn switch_of(config: &MachineConfig, axis: Axis) -> Option<(Input, &EndstopConfig)> {
    let stop = config.homing_endstop(axis)?;
    let index = config.endstops.iter().position(|other| other.name == stop.name)?;
    let turns = config.actuators.0.get(axis as usize)?.present;
    (stop.pin.is_some() && turns).then_some((Input::Endstop(index as u8), stop))
}

/// Returns the axes that can be homed.
pub(super) fn homeable(config: &MachineConfig) -> AxisSet {
    AxisSet::collect(Axis::ALL.into_iter().filter(|axis| switch_of(config, *axis).is_some()))
}

/// Returns the inputs of these axes' switches, a bit each.
pub(super) fn inputs_of(config: &MachineConfig, set: AxisSet) -> u32 {
    set.axes().filter_map(|axis| switch_of(config, axis)).fold(0, |mask, (input, _)| mask | input.bit())
}

/// Returns the inputs of the switches of motors slaved to these axes, a bit each.
pub(super) fn slave_inputs_of(config: &MachineConfig, set: AxisSet) -> u32 {
    let stops = |axis: Axis| config.slave_endstops(axis).filter(|(_, stop)| stop.pin.is_some());
    set.axes().flat_map(stops).fold(0, |mask, (index, _)| mask | Input::Endstop(index as u8).bit())
}

/// Returns those of these axes whose switch is operated.
pub(super) fn operated(config: &MachineConfig, levels: InputLevels, set: AxisSet) -> AxisSet {
    let is_operated = |axis: &Axis| switch_of(config, *axis).is_some_and(|(input, _)| levels.is_active(input));
    AxisSet::collect(set.axes().filter(is_operated))
}

/// Returns the direction to a switch: 1 or -1.
pub(super) fn towards(stop: &EndstopConfig) -> f64 {
    match stop.homing_direction {
        HomingDirection::ToMax => 1.0,
        _ => -1.0,
    }
}

/// Returns the slowest of these axes' rates.
pub(super) fn slowest(
    config: &MachineConfig,
    set: AxisSet,
    rate: impl Fn(&EndstopConfig) -> MmPerSecond,
) -> MmPerSecond {
    let rates = set.axes().filter_map(|axis| switch_of(config, axis)).map(|(_, stop)| rate(stop).0);
    MmPerSecond(rates.fold(f64::INFINITY, |slowest, rate| if rate < slowest { rate } else { slowest }))
}
