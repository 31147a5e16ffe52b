//! The output that drives the spindle: speed (S) to output value, direction (M3, M4), and the operator's
//! override and stop, which act on it beside the program.

use core::fmt;

use config::{MachineConfig, OutputKind, SwitchConfig};
use program::Spindle;
use thermal::Output;
use units::SwitchId;

use super::{Outputs, listens, off_value, output};

/// Operator's changes of the spindle, beside the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Operator {
    /// Override of the program's value, percent.
    percent: f32,
    /// Whether the program has the override ignored.
    ignored: bool,
    /// Whether the operator has stopped the spindle, until its release.
    stopped: bool,
    /// Whether the output does not yet follow the latest change.
    unsaid: bool,
}

impl Default for Operator {
    fn default() -> Self {
        Self { percent: 100.0, ignored: false, stopped: false, unsaid: false }
    }
}

/// An S that the spindle cannot turn with, and the nearest possible S.
#[derive(Clone, Copy, Debug)]
pub struct Beyond<'c> {
    switch: &'c SwitchConfig,
    s: f32,
    nearest: f32,
}

impl fmt::Display for Beyond<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { switch, s, nearest } = *self;
        let name = &switch.name;
        match (s > nearest, switch.max_rpm > 0.0) {
            (true, true) => write!(f, "S{s} is above max_rpm = {nearest} of [switch] {name}")?,
            (true, false) => {
                write!(f, "S{s} is above {nearest}, which is full power: [switch] {name} has no max_rpm")?;
            }
            (false, _) => write!(f, "S{s} is below min_rpm = {nearest} of [switch] {name}")?,
        }
        write!(f, ": it turns with S{nearest}")
    }
}

/// Returns the S that an output turns with for an S of the program.
fn within(switch: &SwitchConfig, s: f32) -> f32 {
    let Some(most) = full_power(switch) else { return s };
    let least = if s > 0.0 { switch.min_rpm } else { 0.0 };
    s.max(least).min(most)
}

/// Returns the S of full power; `None` if S is an angle, or has no upper end.
fn full_power(switch: &SwitchConfig) -> Option<f32> {
    match switch.output_kind {
        _ if switch.max_rpm > 0.0 => Some(switch.max_rpm),
        OutputKind::HardwarePwm if switch.servo.max_angle <= 0.0 => Some(100.0),
        OutputKind::SigmaDelta => Some(255.0),
        _ => None,
    }
}

/// Converts S to the scale of an output, on which `full` is full power.
pub(super) fn on_scale(switch: &SwitchConfig, s: f32, full: f32) -> f32 {
    if switch.max_rpm > 0.0 { within(switch, s) * full / switch.max_rpm } else { s }
}

/// Returns whether an output turns the spindle, in either direction.
fn turns(switch: &SwitchConfig) -> bool {
    listens(switch, 3) || listens(switch, 4)
}

/// Returns an S of the program that an output cannot turn with. Only a spindle's is reported: fans have
/// always been limited silently.
pub fn beyond(config: &MachineConfig, switch: SwitchId, s: Option<f32>) -> Option<Beyond<'_>> {
    let (switch, s) = (output(config, switch)?, s?);
    let nearest = within(switch, s);
    (nearest != s && turns(switch)).then_some(Beyond { switch, s, nearest })
}

/// Returns the least and the greatest S of the first output that turns the spindle.
pub fn spindle_scale(config: &MachineConfig) -> Option<[f32; 2]> {
    let switch = config.switches.iter().find(|switch| turns(switch))?;
    Some([switch.min_rpm, full_power(switch)?])
}

impl Outputs {
    /// Returns the output that turns the spindle now.
    fn turning<'a>(&self, config: &'a MachineConfig) -> Option<(SwitchId, &'a SwitchConfig)> {
        let switches = (0..).map(SwitchId).zip(&config.switches);
        switches.into_iter().find(|(at, switch)| turns(switch) && self.is_on(*at))
    }

    /// Returns the spindle's direction; `told` is the program's, for an output that turns it both ways.
    #[must_use]
    pub fn spindle(&self, config: &MachineConfig, told: Spindle) -> Spindle {
        match self.turning(config) {
            None => Spindle::Stopped,
            Some((_, switch)) if listens(switch, 3) && listens(switch, 4) => match told {
                Spindle::CounterClockwise => told,
                _ => Spindle::Clockwise,
            },
            Some((_, switch)) if listens(switch, 3) => Spindle::Clockwise,
            Some(_) => Spindle::CounterClockwise,
        }
    }

    /// Returns the S that the spindle turns with for the S of the program; 0 while it stands.
    #[must_use]
    pub fn spindle_speed(&self, config: &MachineConfig, s: f32) -> f32 {
        self.turning(config).map_or(0.0, |(_, switch)| within(switch, s))
    }

    /// Returns whether this S differs from the last that was reported.
    pub const fn is_news(&mut self, beyond: &Beyond<'_>) -> bool {
        core::mem::replace(&mut self.told, beyond.s) != beyond.s
    }

    /// Applies the operator's override and stop to a value.
    pub(super) fn as_overridden(&self, config: &MachineConfig, switch: SwitchId, value: f32) -> f32 {
        let Operator { percent, ignored, stopped, .. } = self.operator;
        let percent = if ignored { 100.0 } else { percent };
        let Some(settings) = output(config, switch) else { return value };
        if percent == 100.0 && !stopped || !turns(settings) {
            return value;
        }
        let (off, most) = match settings.output_kind {
            OutputKind::HardwarePwm => (off_value(settings), 100.0),
            OutputKind::SigmaDelta => (0.0, f32::from(settings.max_pwm.0)),
            OutputKind::Digital => return if stopped { 0.0 } else { value },
        };
        if stopped { off } else { (off + (value - off) * percent / 100.0).min(most) }
    }

    /// Returns the operator's spindle override, percent.
    #[must_use]
    pub const fn spindle_percent(&self) -> f32 {
        self.operator.percent
    }

    /// Sets the operator's spindle override, percent.
    pub const fn override_spindle(&mut self, percent: f32) {
        self.operator.percent = percent;
        self.operator.unsaid = true;
    }

    /// Lets the override act or be ignored (M48, M49, M51).
    pub const fn let_override_count(&mut self, counts: bool) {
        self.operator.unsaid |= self.operator.ignored == counts;
        self.operator.ignored = !counts;
    }

    /// Stops the spindle, or lets it turn again.
    pub const fn stop_spindle(&mut self, stops: bool) {
        self.operator.unsaid |= self.operator.stopped != stops;
        self.operator.stopped = stops;
    }

    /// Returns whether the operator has stopped the spindle.
    #[must_use]
    pub const fn spindle_is_stopped(&self) -> bool {
        self.operator.stopped
    }

    /// Returns the output after a change by the operator that it does not follow yet.
    pub fn take_override(&mut self, config: &MachineConfig) -> Option<Output> {
        if !core::mem::take(&mut self.operator.unsaid) {
            return None;
        }
        let (switch, _) = self.turning(config)?;
        let status = *self.status.get(switch.index())?;
        self.set(config, switch, true, status.value)
    }
}
