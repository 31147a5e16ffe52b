//! `[switch]` (fans, power, lamps, buttons), `[pwm1]`, `[pwm2]` and `[voltage monitor]`.

use crate::diagnostic::Severity;
use crate::names::{Command, Name, spaced};
use crate::pin::{OutputPin, Pin, VoltageInput};
use crate::setting::build::{bool, command, integer, number, pin, text, voltage, word};
use crate::setting::declare::{settings, words};
use crate::setting::{ByName, PinRole, Support};
use gcode::Code;
use units::{Duty, Micros, ServoSetup};

/// Greatest number of switches.
pub const MAX_SWITCHES: usize = 16;
/// Greatest number of voltage monitors: the six inputs.
pub const MAX_VOLTAGES: usize = 6;

words! {
    /// Kind of signal at a switch's output.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum OutputKind {
        /// On or off, without modulation.
        #[default]
        Digital = "digital",
        /// Sigma-delta modulation in software, 0 to 255.
        SigmaDelta = "sigmadeltapwm",
        /// Hardware PWM by a timer, percent.
        HardwarePwm = "hwpwm",
    }
}

words! {
    /// Effect of a press on the state of an input switch.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub enum InputBehaviour {
        /// State follows the pin.
        #[default]
        Momentary = "momentary",
        /// Each press flips the state.
        Toggle = "toggle",
    }
}

settings! {
    /// A servo on a timer.
    rows Servo of ServoSetup {
        /// hwpwm: it turns a servo, and S is an angle up to this, or the width of its pulses in us. 0: S is
        /// percent.
        "servo_max_angle" max_angle = number("0", &(0.0, 720.0))
            .unit("degree").klipper("[servo <name>] maximum_servo_angle").velvet();
        /// Width of the servo's pulses at angle 0; they are never less wide.
        "servo_min_us" pulse_us[0] = number("1000", &(100.0, 10_000.0))
            .unit("us").klipper("[servo <name>] minimum_pulse_width").velvet();
        /// The same at servo_max_angle; they are never wider.
        "servo_max_us" pulse_us[1] = number("2000", &(100.0, 10_000.0))
            .unit("us").klipper("[servo <name>] maximum_pulse_width").velvet();
    }
}

settings! {
    /// Outputs that codes switch (fans, lamps, power supplies, a spindle) and inputs that issue commands. A
    /// switch named spindle is the one that $G reports.
    #[derive(Clone, Debug, Default)]
    pub struct SwitchConfig {
        /// Name of the switch in the file.
        name: Name;
        /// There is such a switch.
        enable: bool = bool("false").v1("switch.<name>.enable");
        /// Makes it an input that issues commands; the output settings then mean nothing.
        input_pin: Option<Pin> = pin("nc", PinRole::Input).v1("switch.<name>.input_pin");
        /// momentary follows the pin, toggle flips at each press.
        "input_pin_behavior" input_behaviour: InputBehaviour = word("momentary", InputBehaviour::WORDS)
            .v1("switch.<name>.input_pin_behavior");
        /// Line an input executes when it turns on. Underscores stand for blanks.
        output_on_command: Command = text("", 96).v1("switch.<name>.output_on_command") => spaced;
        /// Line an input executes when it turns off. Underscores stand for blanks.
        output_off_command: Command = text("", 96).v1("switch.<name>.output_off_command") => spaced;
        /// Code that turns the output on, as in M106 or M106.1. hwpwm also takes P, the width of pulses in
        /// us.
        input_on_command: Option<Code> = command().v1("switch.<name>.input_on_command");
        /// Code that turns the output off, as in M107.
        input_off_command: Option<Code> = command().v1("switch.<name>.input_off_command");
        /// A spindle that turns both ways: the code that turns the output on, too, M4 where M3 is
        /// input_on_command. A switch of its own that is on by M4 and off by M3 is the direction.
        input_reverse_command: Option<Code> = command().velvet();
        /// Subcode of these codes, where they have none of their own.
        subcode: u8 = integer("0", &(0, 255)).v1("switch.<name>.subcode");
        /// The P or E by which M62 to M68 know it: outputs and inputs have numbers of their own. -1: none.
        io_number: Option<u8> = integer("-1", &(-1, 63)) => |v: i64| u8::try_from(v).ok();
        /// The output: a pin for digital and sigmadeltapwm, PWM1_1 to PWM2_4 for hwpwm.
        output_pin: Option<OutputPin> = pin("nc", PinRole::OutputOrPwm)
            .klipper("[fan_generic <name>] pin").v1("switch.<name>.output_pin");
        /// digital is on or off; sigmadeltapwm takes S0 to S255; hwpwm takes percent on a timer channel.
        "output_type" output_kind: OutputKind = word("", OutputKind::WORDS).required().v1("switch.<name>.output_type");
        /// What S255 means on a sigmadeltapwm output.
        max_pwm: Duty = integer("255", &(0, 255)).v1("switch.<name>.max_pwm");
        /// sigmadeltapwm: the output is on once in so long, for its share of it, as a relay needs. 0: as
        /// often as can be.
        "cycle_time" cycle: Micros = number("0", &(0.0, 10.0))
            .unit("s").klipper("[output_pin <name>] cycle_time").velvet();
        /// On at boot.
        startup_state: bool = bool("false").v1("switch.<name>.startup_state");
        /// sigmadeltapwm: the value of on, 0 to 255. hwpwm: percent of off.
        startup_value: f32 = number("0", &(0.0, 255.0))
            .derived("max_pwm for sigmadeltapwm, else 0").v1("switch.<name>.startup_value");
        /// hwpwm: percent of an on code without words, and at boot with startup_state.
        default_on_value: f32 = number("0", &(0.0, 100.0)).unit("%").v1("switch.<name>.default_on_value");
        /// A spindle: S is its speed, and this one is full power; more is told and limited. 0: S is percent,
        /// or 0 to 255.
        max_rpm: f32 = number("0", &(0.0, 1_000_000.0)).unit("1/min").velvet();
        /// With max_rpm: an S above 0 and below this is told, and raised to it.
        min_rpm: f32 = number("0", &(0.0, 1_000_000.0)).unit("1/min").velvet();
        /// So long after an on code has turned it on, the next line follows: a power supply has come up by
        /// then.
        on_delay: Micros = number("0", &(0.0, 60.0)).unit("s").velvet();
        /// So long after an off code has turned it off, the next line follows: a spindle stands by then, and
        /// may turn the other way.
        off_delay: Micros = number("0", &(0.0, 60.0)).unit("s").velvet();
        /// Servo on the hardware PWM output, with S an angle.
        servo: ServoSetup;
        rows SwitchHalt:
        /// State in a fault of the firmware itself.
        failsafe_set_to: bool = bool("false")
            .klipper("[output_pin <name>] shutdown_value").v1("switch.<name>.failsafe_set_to")
            .support(&Support::NotYet {
                severity: Severity::Warning,
                advice: "leave it out; a fault of the firmware resets the board, and outputs go off",
            });
        /// State when the machine halts.
        halt_set_to: bool = bool("false").v1("switch.<name>.halt_set_to");
        /// Leave the output alone in a halt. MOSFET outputs lose power all the same.
        ignore_on_halt: bool = bool("false");
    }
}

impl SwitchConfig {
    /// Returns whether the switch reads a pin and issues commands, rather than obeying commands.
    #[must_use]
    pub const fn is_input(&self) -> bool {
        self.input_pin.is_some()
    }
}

/// Frequencies of the timers of `[pwm1]` and `[pwm2]`, Hz, where the section exists.
type TimerFrequencies = [Option<u32>; 2];

settings! {
    /// Timer of PWM1_1 to PWM1_4 (PE9, PE11, PE13, PE14). The section must be there to use them.
    rows Pwm1 of TimerFrequencies {
        /// Frequency; the duty has 1000 steps, below 200 Hz more.
        "frequency" [0] = integer("10000", &(1, 100_000))
            .derived("10000 when the section is there").unit("Hz").v1("laser_module_pwm_period");
    }
}

settings! {
    /// Timer of PWM2_1 to PWM2_4 (PI5, PI6, PI7, PI2). The section must be there to use them.
    rows Pwm2 of TimerFrequencies {
        /// Frequency; the duty has 1000 steps, below 200 Hz more.
        "frequency" [1] = integer("10000", &(1, 100_000))
            .derived("10000 when the section is there").unit("Hz").v1("laser_module_pwm_period");
    }
}

settings! {
    /// Voltages to watch, by name. vmotor (ADC3_5) and vfet (ADC3_2) are built in.
    #[derive(Clone, Debug)]
    pub struct VoltageMonitor {
        /// Name of the voltage: vmotor, vfet.
        name: Name;
        /// Input ADC3_0 to ADC3_5 and, after a comma, the divider's scale; 11 without one.
        "" = voltage().by_name(&ByName(&[("vmotor", "ADC3_5"), ("vfet", "ADC3_2")])).unit("V") => VoltageMonitor::set;
        /// Analogue input of the monitor.
        input: VoltageInput;
        /// Divider ratio: volts at the source per volt at the pin.
        scale: f32;
    }
}

impl VoltageMonitor {
    fn set(&mut self, (input, scale): (VoltageInput, f64)) {
        self.input = input;
        self.scale = scale as f32;
    }
}
