//! Switches: outputs that codes turn on and off, and inputs that issue commands.

use base::failure::{Failure, Texts};
use base::needs::needs;
use base::ports::{Input, InputLevels};
use base::sessions::Reply;
use config::{Command, InputBehaviour, MAX_SWITCHES, MachineConfig, OutputKind, SwitchConfig};
use gcode::Code;
use heapless::Vec;
use program::Part;
use thermal::Output;
use units::{Duty, Micros, SwitchId};

mod listing;
mod spindle;
mod temperature_switches;

use spindle::Operator;
pub use spindle::{beyond, spindle_scale};
pub use temperature_switches::TemperatureSwitches;

/// Time between two looks at input switches; shorter presses may be missed.
const INPUT_PERIOD: Micros = Micros::from_millis(20);

/// Changes of outputs, to be applied in this order.
pub type Changes = Vec<Output, MAX_SWITCHES>;

/// State of one switch.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Status {
    /// Whether an output or an input is on.
    on: bool,
    /// Value of an output: 0 to 255, or percent for hardware PWM.
    value: f32,
    /// Whether the last change may never have happened: the next one counts, also when it is the same.
    unsure: bool,
    /// Last level of an input.
    level: bool,
    /// Whether an input changed and its command has not run yet.
    pending: bool,
}

/// Commanded states of all switches. An output that changes on the way of a move counts as changed from its
/// command on.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    status: Vec<Status, MAX_SWITCHES>,
    /// Whether any command may be pending: asked before each line.
    has_pending: bool,
    due: Micros,
    operator: Operator,
    /// Last S beyond the spindle's scale that was reported.
    told: f32,
}

/// M-codes that turn spindle, laser and coolant on.
const SPINDLE_AND_COOLANT: [u16; 4] = [3, 4, 7, 8];

/// Returns whether an output is on after a command with S word `s`, and its value.
fn asked(config: &SwitchConfig, on: bool, s: Option<f32>) -> (bool, f32) {
    if on { on_value(config, s) } else { (false, off_value(config)) }
}

fn on_value(config: &SwitchConfig, s: Option<f32>) -> (bool, f32) {
    match config.output_kind {
        // A digital output has no speeds, but S0 turns it off all the same: M3 S0, M106 S0.
        OutputKind::Digital if s.is_some_and(|s| s <= 0.0) => (false, 0.0),
        OutputKind::Digital => (true, 255.0),
        OutputKind::SigmaDelta => {
            let max = f32::from(config.max_pwm.0);
            let value = |s| libm::roundf(spindle::on_scale(config, s, 255.0) * max / 255.0);
            let value = units::within(s.map_or(config.startup_value, value), 0.0, max);
            (value > 0.0, value)
        }
        OutputKind::HardwarePwm => {
            let percent = |s| spindle::on_scale(config, s, 100.0);
            let percent = units::within(s.map_or(config.default_on_value, percent), 0.0, 100.0);
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

/// Returns the value that plain on or off stands for.
fn plain_value(config: &SwitchConfig, on: bool) -> f32 {
    match (on, config.output_kind) {
        (false, _) => off_value(config),
        (true, OutputKind::Digital) => 255.0,
        (true, OutputKind::SigmaDelta) => units::within(config.startup_value, 0.0, f32::from(config.max_pwm.0)),
        (true, OutputKind::HardwarePwm) => config.default_on_value,
    }
}

fn is_off(config: &MachineConfig, switch: &SwitchConfig) -> bool {
    config.off("switch", &switch.name).is_some()
}

/// Returns the line that an input switch sends.
fn command_of(switch: &SwitchConfig, on: bool) -> &Command {
    if on { &switch.output_on_command } else { &switch.output_off_command }
}

/// Returns whether an output is turned on by this M-code. An output that M3 turns on and M4 off, or the
/// reverse, is the spindle's direction, and stays so when the spindle stands.
fn listens(switch: &SwitchConfig, number: u16) -> bool {
    let is = |code: Option<Code>, number| code == Some(Code::m(number));
    let is_direction = is(switch.input_off_command, 3) || is(switch.input_off_command, 4);
    let turns_on = is(switch.input_on_command, number) || is(switch.input_reverse_command, number);
    turns_on && !switch.is_input() && !is_direction
}

/// Returns the change that gives an output this value.
fn given(config: &MachineConfig, switch: SwitchId, on: bool, value: f32) -> Option<Output> {
    Some(match config.switches.get(switch.index())?.output_kind {
        OutputKind::HardwarePwm => Output::Pwm(switch.0, value / 100.0),
        OutputKind::Digital => Output::Switch(switch.0, if value > 0.0 && on { Duty::FULL } else { Duty::OFF }),
        OutputKind::SigmaDelta => Output::Switch(switch.0, Duty(units::within(value, 0.0, 255.0) as u8)),
    })
}

fn output(config: &MachineConfig, switch: SwitchId) -> Option<&SwitchConfig> {
    config.switches.get(switch.index()).filter(|config| !config.is_input())
}

impl Outputs {
    /// Starts with all switches off.
    #[must_use]
    pub fn new(switches: &[SwitchConfig]) -> Self {
        Self {
            status: switches.iter().map(|_| Status::default()).collect(),
            has_pending: false,
            due: Micros(0),
            operator: Operator::default(),
            told: 0.0,
        }
    }

    /// Returns whether a switch is on.
    #[must_use]
    pub fn is_on(&self, switch: SwitchId) -> bool {
        self.status.get(switch.index()).is_some_and(|status| status.on)
    }

    /// Returns whether the switch of this name is on; false when there is none.
    #[must_use]
    pub fn is_on_by_name(&self, config: &MachineConfig, name: &str) -> bool {
        let place = config.switches.iter().position(|switch| switch.name == name);
        place.and_then(|place| self.status.get(place)).is_some_and(|status| status.on)
    }

    /// Returns the output that this M-code turns on.
    fn by_code(config: &MachineConfig, number: u16) -> Option<SwitchId> {
        config.switches.iter().position(|switch| listens(switch, number)).map(|place| SwitchId(place as u8))
    }

    /// Returns whether there is an output that this M-code turns on.
    #[must_use]
    pub fn has_code(config: &MachineConfig, number: u16) -> bool {
        Self::by_code(config, number).is_some()
    }

    /// Returns whether the output that this M-code turns on is on; false when there is none.
    #[must_use]
    pub fn is_on_by_code(&self, config: &MachineConfig, number: u16) -> bool {
        Self::by_code(config, number).is_some_and(|switch| self.is_on(switch))
    }

    /// Refuses to turn on an output that an error in the configuration keeps off. `s` is the S word.
    ///
    /// # Errors
    /// As of [`needs`].
    pub fn check(
        texts: &Texts,
        config: &MachineConfig,
        switch: SwitchId,
        on: bool,
        s: Option<f32>,
        is_playing: bool,
    ) -> Result<(), Failure> {
        let turns_on = output(config, switch).is_some_and(|output| asked(output, on, s).0);
        if turns_on { needs(texts, config, Part::Switch(switch), is_playing) } else { Ok(()) }
    }

    /// Turns an output on or off, `s` being its S word. Returns the change for the caller to apply, at once
    /// or on the way of a move; `None` when nothing changes.
    pub fn turn(&mut self, config: &MachineConfig, switch: SwitchId, on: bool, s: Option<f32>) -> Option<Output> {
        let (on, value) = asked(output(config, switch)?, on, s);
        let status = self.status.get(switch.index())?;
        if status.on == on && status.value == value && !status.unsure {
            return None;
        }
        self.set(config, switch, on, value)
    }

    /// Notes that changes on the path were dropped: the outputs may not have their commanded states.
    pub fn changes_were_dropped(&mut self) {
        self.status.iter_mut().for_each(|status| status.unsure = true);
    }

    /// Turns an output on or off with the values that the configuration gives to these.
    pub fn turn_plainly(&mut self, config: &MachineConfig, switch: SwitchId, on: bool) -> Option<Output> {
        let value = plain_value(output(config, switch)?, on);
        self.set(config, switch, on, value)
    }

    /// Gives an automatic output a share of full power, 0 to 1. `None` when nothing changes.
    pub fn drive(&mut self, config: &MachineConfig, switch: SwitchId, share: f32) -> Option<Output> {
        let settings = output(config, switch)?;
        let most = match settings.output_kind {
            OutputKind::HardwarePwm => 100.0,
            OutputKind::SigmaDelta => f32::from(settings.max_pwm.0),
            OutputKind::Digital => return self.turn(config, switch, share > 0.0, None),
        };
        let status = self.status.get(switch.index())?;
        if status.value == share * most && !status.unsure {
            return None;
        }
        self.set(config, switch, share > 0.0, share * most)
    }

    fn set(&mut self, config: &MachineConfig, switch: SwitchId, on: bool, value: f32) -> Option<Output> {
        let status = self.status.get_mut(switch.index())?;
        (status.on, status.value, status.unsure) = (on, value, false);
        given(config, switch, on, self.as_overridden(config, switch, value))
    }

    /// Toggles the output that this M-code turns on.
    pub fn turn_over(&mut self, config: &MachineConfig, number: u16) -> Option<Output> {
        let switch = Self::by_code(config, number)?;
        let on = !self.is_on(switch);
        self.turn_plainly(config, switch, on)
    }

    /// Gives outputs their states at boot, and takes the present levels of inputs.
    pub fn start(&mut self, config: &MachineConfig, levels: InputLevels) -> Changes {
        let mut changes = Changes::new();
        for (index, switch) in (0..).zip(&config.switches).filter(|(_, switch)| !is_off(config, switch)) {
            if switch.is_input() {
                let level = levels.is_active(Input::Switch(index));
                if let Some(status) = self.status.get_mut(usize::from(index)) {
                    (status.level, status.on) = (level, level);
                }
            } else {
                changes.extend(self.turn_plainly(config, SwitchId(index), switch.startup_state));
            }
        }
        changes
    }

    /// Gives every output its halt state, except outputs that ignore halts and automatic fans: hot parts go
    /// on being cooled.
    pub fn halt(&mut self, config: &MachineConfig) -> Changes {
        self.changes_were_dropped();
        self.stop_spindle(false);
        let mut changes = Changes::new();
        for (index, switch) in (0..).zip(&config.switches) {
            let stays = switch.ignore_on_halt || config.automatic_fan(&switch.name).is_some();
            if stays || switch.is_input() || is_off(config, switch) {
                continue;
            }
            let on = switch.halt_set_to;
            changes.extend(match switch.output_kind {
                // A halt never leaves a spindle or laser on a timer running.
                OutputKind::HardwarePwm => self.turn_plainly(config, SwitchId(index), false),
                OutputKind::Digital | OutputKind::SigmaDelta => {
                    self.set(config, SwitchId(index), on, if on { 255.0 } else { 0.0 })
                }
            });
        }
        changes
    }

    /// Turns off everything that turns, burns or sprays, as the safety door is open. The commanded states
    /// stay.
    pub fn door_opens(&self, config: &MachineConfig) -> Changes {
        self.behind_the_door(config).filter_map(|(at, switch)| given(config, at, false, off_value(switch))).collect()
    }

    /// Gives the outputs that the open door had turned off their commanded states, as the door is closed.
    pub fn door_closes(&self, config: &MachineConfig) -> Changes {
        let told = |(at, _): (SwitchId, &SwitchConfig)| {
            let status = self.status.get(at.index())?;
            given(config, at, status.on, self.as_overridden(config, at, status.value))
        };
        self.behind_the_door(config).filter_map(told).collect()
    }

    /// Returns the outputs that the door guards: those on timers, as spindles, lasers and servos are, and all
    /// that the codes of spindle and coolant turn on.
    fn behind_the_door<'a>(&self, config: &'a MachineConfig) -> impl Iterator<Item = (SwitchId, &'a SwitchConfig)> {
        let switches = (0..self.status.len() as u8).map(SwitchId).zip(&config.switches);
        switches.filter(|(_, switch)| {
            let hurts = switch.output_kind == OutputKind::HardwarePwm
                || SPINDLE_AND_COOLANT.iter().any(|&code| listens(switch, code));
            hurts && !switch.is_input() && !is_off(config, switch) && config.automatic_fan(&switch.name).is_none()
        })
    }

    /// Looks at input switches; the command of a changed one waits for [`Self::take_command`]. Returns
    /// whether any has changed.
    pub fn look(&mut self, levels: InputLevels, config: &MachineConfig, now: Micros) -> bool {
        if now < self.due {
            return false;
        }
        self.due = now.plus(INPUT_PERIOD);
        let mut has_changed = false;
        for (index, (switch, status)) in (0..).zip(config.switches.iter().zip(&mut self.status)) {
            if !switch.is_input() {
                continue;
            }
            let level = levels.is_active(Input::Switch(index));
            let pressed = level && !status.level;
            let changed = level != status.level;
            status.level = level;
            match switch.input_behaviour {
                InputBehaviour::Momentary if changed => (status.on, status.pending) = (level, true),
                InputBehaviour::Toggle if pressed => (status.on, status.pending) = (!status.on, true),
                _ => continue,
            }
            has_changed = true;
        }
        self.has_pending |= has_changed;
        has_changed
    }

    /// Returns the commands of input switches that changed, in the order in which they are taken.
    pub fn commands<'c>(&self, config: &'c MachineConfig) -> impl Iterator<Item = &'c Command> {
        let pending = config.switches.iter().zip(&self.status).filter(|(_, status)| status.pending);
        pending.map(|(switch, status)| command_of(switch, status.on)).filter(|command| !command.is_empty())
    }

    /// Takes the next command of an input switch that changed.
    #[inline]
    pub fn take_command(&mut self, config: &MachineConfig) -> Option<Command> {
        if self.has_pending { self.take_pending(config) } else { None }
    }

    #[cold]
    fn take_pending(&mut self, config: &MachineConfig) -> Option<Command> {
        for (switch, status) in config.switches.iter().zip(&mut self.status) {
            if core::mem::take(&mut status.pending) {
                let command = command_of(switch, status.on);
                if !command.is_empty() {
                    return Some(command.clone());
                }
            }
        }
        self.has_pending = false;
        None
    }

    /// `switch`, `switch n`, `switch n on|off|value`: prints or sets the state of a switch. Returns the
    /// change, to be applied at once.
    ///
    /// # Errors
    /// When the switch stays off, or the value is not valid.
    pub fn switch_command(
        &mut self,
        texts: &Texts,
        config: &MachineConfig,
        arguments: &str,
        reply: &mut Reply<'_>,
    ) -> Result<Option<Output>, Failure> {
        let mut words = arguments.split_ascii_whitespace();
        let Some(name) = words.next() else {
            self.list(config, reply);
            return Ok(None);
        };
        let named = (0..).zip(&config.switches).find(|(_, switch)| switch.name == name);
        let Some((switch, settings)) = named.map(|(index, settings)| (SwitchId(index), settings)) else {
            reply.say(format_args!("no such switch: {name}\n"));
            return Ok(None);
        };
        let Some(value) = words.next() else {
            reply.say(format_args!("switch {name} is {}\n", u8::from(self.is_on(switch))));
            return Ok(None);
        };
        if settings.is_input() {
            let what = if gcode::read_f32(value).is_some() { "value" } else { "state" };
            reply.say(format_args!("unknown command set-{what}.\n"));
            return Ok(None);
        }
        if config.automatic_fan(name).is_some() {
            return Err(texts.refused(format_args!("{name} runs by itself: see [fan] in config.ini")));
        }
        // A file that is being played goes on, for the command is not the file's.
        needs(texts, config, Part::Switch(switch), false)?;
        let change = match (value, gcode::read_f32(value)) {
            ("on" | "off", _) => self.turn_plainly(config, switch, value == "on"),
            (_, Some(number)) if number.is_finite() => {
                self.set(config, switch, number > 0.0, units::within(number, 0.0, 255.0))
            }
            _ => return Err(texts.refused(format_args!("{value} is not on, off or a number"))),
        };
        reply.say(format_args!("switch {name} set to: {value}\n"));
        Ok(change)
    }
}

#[cfg(test)]
mod tests;
