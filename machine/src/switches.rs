//! Switches: outputs that G and M codes turn on and off, inputs that issue commands.

use config::{Command, CommandCode, InputBehaviour, MAX_SWITCHES, OutputKind, SwitchConfig};
use gcode::{Block, Letter};
use heapless::Vec;
use units::{Duty, Micros};

use crate::boot::full_or_off;
use crate::console::Target;
use crate::controller::Controller;
use crate::failure::Failure;
use crate::ports::{Input, Ports};
use crate::state::State;

/// Input switches are looked at this often; shorter presses may be missed.
const INPUT_PERIOD: Micros = Micros::from_millis(20);

/// What one switch is doing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Status {
    /// An output that is on, or an input that is.
    on: bool,
    /// Value of an output: 0 to 255, or percent for hardware PWM.
    value: f32,
    /// Last level of an input.
    level: bool,
    /// An input changed and its command has not run yet.
    pending: bool,
}

/// What all switches are doing.
#[derive(Clone, Debug, Default)]
pub struct SwitchBank {
    status: Vec<Status, MAX_SWITCHES>,
    due: Micros,
}

impl SwitchBank {
    /// All off.
    #[must_use]
    pub fn new(switches: &[SwitchConfig]) -> Self {
        Self { status: switches.iter().map(|_| Status::default()).collect(), due: Micros(0) }
    }

    /// Whether a switch is on.
    #[must_use]
    pub fn is_on(&self, index: usize) -> bool {
        self.status.get(index).is_some_and(|status| status.on)
    }

    fn value(&self, index: usize) -> f32 {
        self.status.get(index).map_or(0.0, |status| status.value)
    }

    fn set(&mut self, index: usize, on: bool, value: f32) {
        if let Some(status) = self.status.get_mut(index) {
            (status.on, status.value) = (on, value);
        }
    }
}

fn matches(command: Option<CommandCode>, block: &Block<'_>) -> bool {
    let (Some(command), Some(code)) = (command, block.code) else { return false };
    let letter = if code.letter == Letter::G { 'G' } else { 'M' };
    code.letter != Letter::T
        && command.letter == letter
        && command.number == code.number
        && command.subcode == code.subcode
}

/// What a code asks of an output: on with a value, or off with one.
fn asked(config: &SwitchConfig, block: &Block<'_>) -> Option<(bool, f32)> {
    if matches(config.input_on_command, block) {
        Some(on_value(config, block))
    } else if matches(config.input_off_command, block) {
        Some((false, off_value(config)))
    } else {
        None
    }
}

fn on_value(config: &SwitchConfig, block: &Block<'_>) -> (bool, f32) {
    let s = block.get('S').map(|s| s as f32);
    match config.output_kind {
        OutputKind::Digital => (true, 255.0),
        OutputKind::SigmaDelta => {
            let max = f32::from(config.max_pwm.0);
            let value = s.map_or(config.startup_value, |s| libm::roundf(s * max / 255.0)).clamp(0.0, max);
            (value > 0.0, value)
        }
        OutputKind::HardwarePwm => {
            let percent = s.unwrap_or(config.default_on_value).clamp(0.0, 100.0);
            (percent > config.startup_value, percent)
        }
    }
}

const fn off_value(config: &SwitchConfig) -> f32 {
    match config.output_kind {
        OutputKind::HardwarePwm => config.startup_value,
        _ => 0.0,
    }
}

impl<P: Ports> Controller<P> {
    /// Runs a code on every output that listens to it. True when one did. Moves queued before it end first, so that a fan
    /// changes where the program says.
    pub(crate) async fn switch_code(&mut self, block: &Block<'_>) -> Result<bool, Failure> {
        let mut handled = false;
        for index in 0..self.config.switches.len() {
            let Some(config) = self.config.switches.get(index).filter(|config| !config.is_input()) else { continue };
            let Some((on, value)) = asked(config, block) else { continue };
            handled = true;
            if on {
                self.needs("switch", &config.name)?;
            }
            if self.switches.is_on(index) == on && self.switches.value(index) == value {
                continue;
            }
            if self.state != State::Halt {
                self.wait_idle().await?;
            }
            self.drive_switch(index, on, value);
        }
        Ok(handled)
    }

    /// Sets an output.
    pub(crate) fn drive_switch(&mut self, index: usize, on: bool, value: f32) {
        let Some(config) = self.config.switches.get(index) else { return };
        let kind = config.output_kind;
        self.switches.set(index, on, value);
        match kind {
            OutputKind::HardwarePwm => self.ports.set_hardware_pwm(index as u8, value / 100.0),
            OutputKind::Digital => self.ports.heat(|heat| heat.set_switch(index, full_or_off(on))),
            OutputKind::SigmaDelta => {
                self.ports.heat(|heat| heat.set_switch(index, Duty(value.clamp(0.0, 255.0) as u8)))
            }
        }
    }

    /// On or off with the values the configuration gives to these.
    pub(crate) fn drive_switch_plainly(&mut self, index: usize, on: bool) {
        let Some(config) = self.config.switches.get(index).filter(|config| !config.is_input()) else { return };
        let value = match (on, config.output_kind) {
            (false, _) => off_value(config),
            (true, OutputKind::Digital) => 255.0,
            (true, OutputKind::SigmaDelta) => config.startup_value.clamp(0.0, f32::from(config.max_pwm.0)),
            (true, OutputKind::HardwarePwm) => config.default_on_value,
        };
        self.drive_switch(index, on, value);
    }

    /// The state an output has at boot; an input takes the level it finds.
    pub(crate) fn drive_switch_at_startup(&mut self, index: usize) {
        let Some(config) = self.config.switches.get(index) else { return };
        let (is_input, on) = (config.is_input(), config.startup_state);
        if self.config.off("switch", &config.name).is_some() {
            return;
        }
        if is_input {
            let level = self.ports.inputs().is_active(Input::Switch(index as u8));
            if let Some(status) = self.switches.status.get_mut(index) {
                status.level = level;
                status.on = level;
            }
        } else {
            self.drive_switch_plainly(index, on);
        }
    }

    /// A halt: every output to its halt state, but those that ignore halts.
    pub(crate) fn switches_to_halt_state(&mut self) {
        for index in 0..self.config.switches.len() {
            let Some(config) = self.config.switches.get(index) else { return };
            if config.ignore_on_halt || config.is_input() || self.config.off("switch", &config.name).is_some() {
                continue;
            }
            let on = config.halt_set_to;
            match config.output_kind {
                // A spindle or laser on a timer is never left running by a halt.
                OutputKind::HardwarePwm => self.drive_switch_plainly(index, false),
                OutputKind::Digital | OutputKind::SigmaDelta => {
                    self.drive_switch(index, on, if on { 255.0 } else { 0.0 })
                }
            }
        }
    }

    /// Looks at input switches; a change is executed by the dispatcher between lines.
    pub(crate) fn watch_input_switches(&mut self, now: Micros) {
        if now < self.switches.due || self.crippled {
            return;
        }
        self.switches.due = now.plus(INPUT_PERIOD);
        let levels = self.ports.inputs();
        for (index, (config, status)) in self.config.switches.iter().zip(&mut self.switches.status).enumerate() {
            if !config.is_input() {
                continue;
            }
            let level = levels.is_active(Input::Switch(index as u8));
            let pressed = level && !status.level;
            let changed = level != status.level;
            status.level = level;
            match config.input_behaviour {
                InputBehaviour::Momentary if changed => (status.on, status.pending) = (level, true),
                InputBehaviour::Toggle if pressed => (status.on, status.pending) = (!status.on, true),
                _ => {}
            }
        }
    }

    /// The command of an input switch that changed.
    pub(crate) fn take_switch_command(&mut self) -> Option<Command> {
        for (config, status) in self.config.switches.iter().zip(&mut self.switches.status) {
            if core::mem::take(&mut status.pending) {
                let command = if status.on { &config.output_on_command } else { &config.output_off_command };
                if !command.is_empty() {
                    return Some(command.clone());
                }
            }
        }
        None
    }

    /// `switch <name> is <0|1>` for every switch.
    pub(crate) fn report_switches(&mut self, target: Target) {
        let Self { config, switches, consoles, .. } = self;
        for (index, switch) in config.switches.iter().enumerate() {
            consoles.write(target, format_args!("switch {} is {}\n", switch.name, u8::from(switches.is_on(index))));
        }
    }

    /// `switch`, `switch n`, `switch n on|off|value`
    pub(crate) fn switch_command(&mut self, mut words: core::str::SplitAsciiWhitespace<'_>) {
        let target = self.target;
        let Some(name) = words.next() else { return self.report_switches(target) };
        let Some(index) = self.config.switches.iter().position(|switch| switch.name == name) else {
            return self.say(format_args!("no such switch: {name}\n"));
        };
        let Some(value) = words.next() else {
            let on = u8::from(self.switches.is_on(index));
            return self.say(format_args!("switch {name} is {on}\n"));
        };
        let is_input = self.config.switches.get(index).is_some_and(SwitchConfig::is_input);
        if is_input {
            return self.say(format_args!("unknown command set-state.\n"));
        }
        if let Err(Failure::Refused(text) | Failure::Alarm(text)) = self.needs("switch", name) {
            return self.say(format_args!("error:{text}\n"));
        }
        match (value, value.parse::<f32>()) {
            ("on" | "off", _) => self.drive_switch_plainly(index, value == "on"),
            (_, Ok(number)) if number.is_finite() => self.drive_switch(index, number > 0.0, number.clamp(0.0, 255.0)),
            _ => return self.say(format_args!("error:{value} is not on, off or a number\n")),
        }
        self.say(format_args!("switch {name} set to: {value}\n"));
    }
}
