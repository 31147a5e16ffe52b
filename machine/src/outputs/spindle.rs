//! The output that drives the spindle: speed (S) to output value, direction (M3, M4), and the operator's
//! override and stop, which act on it beside the program.

use core::fmt;

use config::{MachineConfig, OutputKind, SwitchConfig};
use program::Spindle;
use units::SwitchId;

use super::{Outputs, listens, off_value, output};
use crate::heat::Output;

/// What the operator has done to the spindle, beside the program.
#[derive(Clone, Copy, Debug)]
pub(super) struct Operator {
    /// Percent of the value that it is told.
    percent: f32,
    /// The program does not let that count.
    ignored: bool,
    /// It stands, until the operator has it turn again.
    stopped: bool,
    /// The output does not say so yet.
    unsaid: bool,
}

impl Default for Operator {
    fn default() -> Self {
        Self { percent: 100.0, ignored: false, stopped: false, unsaid: false }
    }
}

/// An S that the spindle cannot turn with, and the nearest one that it can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beyond<'c> {
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

/// The S that an output turns with when it is told this one.
fn within(switch: &SwitchConfig, s: f32) -> f32 {
    let Some(most) = full_power(switch) else { return s };
    let least = if s > 0.0 { switch.min_rpm } else { 0.0 };
    s.max(least).min(most)
}

/// The S of full power; none where S is an angle, or has no upper end.
fn full_power(switch: &SwitchConfig) -> Option<f32> {
    match switch.output_kind {
        _ if switch.max_rpm > 0.0 => Some(switch.max_rpm),
        OutputKind::HardwarePwm if switch.servo.max_angle <= 0.0 => Some(100.0),
        OutputKind::SigmaDelta => Some(255.0),
        _ => None,
    }
}

/// What S is on the scale of an output, where `full` is full power.
pub(super) fn on_scale(switch: &SwitchConfig, s: f32, full: f32) -> f32 {
    if switch.max_rpm > 0.0 { within(switch, s) * full / switch.max_rpm } else { s }
}

/// Whether an output turns the spindle, one way or the other.
fn turns(switch: &SwitchConfig) -> bool {
    listens(switch, 3) || listens(switch, 4)
}

/// An S that an output is told and cannot turn with. Only of a spindle it is told: fans have always been
/// limited so.
pub(crate) fn beyond(config: &MachineConfig, switch: SwitchId, s: Option<f32>) -> Option<Beyond<'_>> {
    let (switch, s) = (output(config, switch)?, s?);
    let nearest = within(switch, s);
    (nearest != s && turns(switch)).then_some(Beyond { switch, s, nearest })
}

/// The least and the greatest S of the first output that turns the spindle.
pub(crate) fn spindle_scale(config: &MachineConfig) -> Option<[f32; 2]> {
    let switch = config.switches.iter().find(|switch| turns(switch))?;
    Some([switch.min_rpm, full_power(switch)?])
}

impl Outputs {
    /// The output that turns the spindle now.
    fn turning<'a>(&self, config: &'a MachineConfig) -> Option<(SwitchId, &'a SwitchConfig)> {
        let switches = (0..).map(SwitchId).zip(&config.switches);
        switches.into_iter().find(|(at, switch)| turns(switch) && self.is_on(*at))
    }

    /// How the spindle turns; `told` is what the program has said, where one output turns it both ways.
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

    /// The S that the spindle turns with when it is told this one; 0 while it stands.
    #[must_use]
    pub fn spindle_speed(&self, config: &MachineConfig, s: f32) -> f32 {
        self.turning(config).map_or(0.0, |(_, switch)| within(switch, s))
    }

    /// Whether this was not the last one that was told.
    pub const fn is_news(&mut self, beyond: &Beyond<'_>) -> bool {
        core::mem::replace(&mut self.told, beyond.s) != beyond.s
    }

    /// What of a value remains after what the operator has done to the spindle.
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

    /// Percent of the spindle's value that the operator wants.
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

    /// Stops the spindle, or has it turn again.
    pub const fn stop_spindle(&mut self, stops: bool) {
        self.operator.unsaid |= self.operator.stopped != stops;
        self.operator.stopped = stops;
    }

    /// The operator has stopped the spindle.
    #[must_use]
    pub const fn spindle_is_stopped(&self) -> bool {
        self.operator.stopped
    }

    /// What the operator has done to the spindle and its output does not say yet.
    pub fn take_override(&mut self, config: &MachineConfig) -> Option<Output> {
        if !core::mem::take(&mut self.operator.unsaid) {
            return None;
        }
        let (switch, _) = self.turning(config)?;
        let status = *self.status.get(switch.index())?;
        self.set(config, switch, true, status.value)
    }
}
