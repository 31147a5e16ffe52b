//! `[switch]` (fans, power, lamps, buttons) and `[voltage monitor]`.

use super::{Command, Name};
use crate::pin::{OutputPin, Pin, VoltageInput};
use units::{Duty, Micros};

/// A G or M code a switch listens to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandCode {
    /// `G` or `M`.
    pub letter: char,
    /// The number.
    pub number: u16,
    /// The subcode; 0 when none is written.
    pub subcode: u8,
}

/// How a switch drives its output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputKind {
    /// On or off.
    #[default]
    Digital,
    /// 0 to 255, modulated in software.
    SigmaDelta,
    /// Percent, by a timer.
    HardwarePwm,
}

/// How presses of an input switch change its state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InputBehaviour {
    /// Follows the pin.
    #[default]
    Momentary,
    /// Each press flips it.
    Toggle,
}

/// A servo on a timer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ServoConfig {
    /// The greatest angle, degrees; 0: there is none.
    pub max_angle: f32,
    /// Width of its pulses at angle 0 and at the greatest, microseconds.
    pub pulse_us: [f32; 2],
}

/// One switch: an input when `input_pin` is set, else an output.
#[derive(Clone, Debug, Default)]
pub struct SwitchConfig {
    /// Its name.
    pub name: Name,
    /// Whether it exists.
    pub enable: bool,
    /// Makes it an input.
    pub input_pin: Option<Pin>,
    /// For an input.
    pub input_behaviour: InputBehaviour,
    /// Line executed when an input turns on; empty for none.
    pub output_on_command: Command,
    /// Line executed when an input turns off; empty for none.
    pub output_off_command: Command,
    /// Code that turns an output on.
    pub input_on_command: Option<CommandCode>,
    /// Another code that turns it on: for a spindle, to turn the other way.
    pub input_reverse_command: Option<CommandCode>,
    /// Code that turns an output off.
    pub input_off_command: Option<CommandCode>,
    /// Subcode as written; the codes above have it already, where they had none of their own.
    pub subcode: u8,
    /// The number by which M62 to M68 know it.
    pub io_number: Option<u8>,
    /// The output.
    pub output_pin: Option<OutputPin>,
    /// How the output is driven.
    pub output_kind: OutputKind,
    /// Ceiling of a sigma-delta output; S255 maps to it.
    pub max_pwm: Duty,
    /// A sigma-delta output is on once in so long; 0: as often as can be.
    pub cycle: Micros,
    /// On at boot.
    pub startup_state: bool,
    /// Sigma-delta: the on value, 0 to 255. Hardware PWM: percent when off.
    pub startup_value: f32,
    /// Hardware PWM: percent of an on command without words.
    pub default_on_value: f32,
    /// S of full power, where S is a speed; 0: it is none.
    pub max_rpm: f32,
    /// It never turns more slowly.
    pub min_rpm: f32,
    /// So long after an on code has turned it on, the next line follows.
    pub on_delay: Micros,
    /// The same of an off code that has turned it off.
    pub off_delay: Micros,
    /// Hardware PWM: it turns a servo, and S is an angle.
    pub servo: ServoConfig,
    /// State in a fault.
    pub failsafe_set_to: bool,
    /// State when the machine halts.
    pub halt_set_to: bool,
    /// Leave it alone on a halt.
    pub ignore_on_halt: bool,
}

impl SwitchConfig {
    /// Whether it reads a pin and issues commands, rather than obeying them.
    #[must_use]
    pub const fn is_input(&self) -> bool {
        self.input_pin.is_some()
    }
}

/// One monitored voltage.
#[derive(Clone, Debug)]
pub struct VoltageMonitor {
    /// Its name: vmotor, vfet.
    pub name: Name,
    /// Input.
    pub input: VoltageInput,
    /// Divider ratio: volts at the source per volt at the pin.
    pub scale: f32,
}
