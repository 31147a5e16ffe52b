//! Sections `[switch]` (fans, power, lamps, buttons) and `[voltage monitor]`.

use super::{Command, Name};
use crate::pin::{OutputPin, Pin, VoltageInput};
use units::{Duty, Micros};

/// G or M code that a switch obeys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CommandCode {
    /// Letter, `G` or `M`.
    pub letter: char,
    /// Number of the code.
    pub number: u16,
    /// Subcode; 0 when none is written.
    pub subcode: u8,
}

/// Kind of signal at a switch's output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum OutputKind {
    /// On or off, without modulation.
    #[default]
    Digital,
    /// Sigma-delta modulation in software, 0 to 255.
    SigmaDelta,
    /// Hardware PWM by a timer, percent.
    HardwarePwm,
}

/// Effect of a press on the state of an input switch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum InputBehaviour {
    /// State follows the pin.
    #[default]
    Momentary,
    /// Each press flips the state.
    Toggle,
}

/// A servo on a timer.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ServoConfig {
    /// Greatest angle, degrees; 0: no servo.
    pub max_angle: f32,
    /// Pulse width at angle 0 and at the greatest angle, microseconds.
    pub pulse_us: [f32; 2],
}

/// A switch: an input when `input_pin` is set, else an output.
#[derive(Clone, Debug, Default)]
pub struct SwitchConfig {
    /// Name of the switch in the file.
    pub name: Name,
    /// Whether the switch is in use.
    pub enable: bool,
    /// Input pin; makes the switch an input.
    pub input_pin: Option<Pin>,
    /// Effect of a press on an input switch.
    pub input_behaviour: InputBehaviour,
    /// Line executed when an input turns on; empty for none.
    pub output_on_command: Command,
    /// Line executed when an input turns off; empty for none.
    pub output_off_command: Command,
    /// Code that turns an output on.
    pub input_on_command: Option<CommandCode>,
    /// Other code that turns an output on: for a spindle, in the reverse direction.
    pub input_reverse_command: Option<CommandCode>,
    /// Code that turns an output off.
    pub input_off_command: Option<CommandCode>,
    /// Subcode as written; the codes above already have it, where they had none of their own.
    pub subcode: u8,
    /// Number of the switch in M62 to M68.
    pub io_number: Option<u8>,
    /// Output that the switch drives.
    pub output_pin: Option<OutputPin>,
    /// Kind of signal at the output.
    pub output_kind: OutputKind,
    /// Ceiling of a sigma-delta output; S255 maps to it.
    pub max_pwm: Duty,
    /// Period of a sigma-delta output, with one pulse in each; 0: as fast as possible.
    pub cycle: Micros,
    /// Whether the switch is on at boot.
    pub startup_state: bool,
    /// Value when turned on, 0 to 255, for sigma-delta outputs; percent when off, for hardware PWM.
    pub startup_value: f32,
    /// Percent of an on command without words, for hardware PWM.
    pub default_on_value: f32,
    /// Speed (S word) at full power; 0: S is no speed.
    pub max_rpm: f32,
    /// Least speed of a running spindle.
    pub min_rpm: f32,
    /// Delay of the next line after an on code has turned the switch on.
    pub on_delay: Micros,
    /// Delay of the next line after an off code has turned the switch off.
    pub off_delay: Micros,
    /// Servo on the hardware PWM output, with S an angle.
    pub servo: ServoConfig,
    /// State of the output in a fault.
    pub failsafe_set_to: bool,
    /// State of the output when the machine halts.
    pub halt_set_to: bool,
    /// Whether a halt leaves the switch alone.
    pub ignore_on_halt: bool,
}

impl SwitchConfig {
    /// Returns whether the switch reads a pin and issues commands, rather than obeying commands.
    #[must_use]
    pub const fn is_input(&self) -> bool {
        self.input_pin.is_some()
    }
}

/// Settings of one monitored voltage.
#[derive(Clone, Debug)]
pub struct VoltageMonitor {
    /// Name of the voltage: vmotor, vfet.
    pub name: Name,
    /// Analogue input of the monitor.
    pub input: VoltageInput,
    /// Divider ratio: volts at the source per volt at the pin.
    pub scale: f32,
}
