//! `[switch]`, `[pwm1]`, `[pwm2]`, `[voltage monitor]`.

use super::build::{bool, command, integer, new_name, number, pin, text, voltage, word};
use super::{ByName, CannotCreate, Docs, Form, Instances, PinRole, Section, Support, Words};
use crate::diagnostic::Severity;
use crate::machine::{Command, InputBehaviour, MAX_SWITCHES, MAX_VOLTAGES, OutputKind, SwitchConfig, VoltageMonitor};
use crate::pin::{PinName, VoltageInput};
use units::{Duty, Micros};

/// `|switch, value| ...` on the switch at the instance's place.
macro_rules! switch {
    (|$switch:ident, $value:ident| $body:expr) => {
        |c, i, $value| {
            if let Some($switch) = c.switches.get_mut(i) {
                $body;
            }
        }
    };
}

/// A command line in which underscores stand for blanks.
pub fn spaced(text: &str) -> Command {
    text.chars().map(|c| if c == '_' { ' ' } else { c }).fold(Command::new(), |mut line, c| {
        // The schema limits the text to the length of a Command.
        let _ = line.push(c);
        line
    })
}

const fn output_kind(word: usize) -> OutputKind {
    match word {
        1 => OutputKind::SigmaDelta,
        2 => OutputKind::HardwarePwm,
        _ => OutputKind::Digital,
    }
}

pub const SWITCH: Section = Section {
    name: "switch",
    store: None,
    docs: Docs::new("Outputs that codes switch (fans, lamps, power supplies, a spindle) and inputs that issue commands. A \
              switch named spindle is the one that $G reports."),
    form: Form::Named(Instances {
        noun: "switch",
        find: |c, name| c.switches.iter().position(|switch| switch.name == name),
        create: |c, name| {
            let switch = SwitchConfig { name: new_name(name)?, ..SwitchConfig::default() };
            c.switches.push(switch).map_err(|_| CannotCreate::Full(MAX_SWITCHES))?;
            Ok(c.switches.len() - 1)
        },
        name: |c, i| c.switches.get(i).map_or("", |switch| switch.name.as_str()),
        is_live: |c, i| c.switches.get(i).is_some_and(|switch| switch.enable),
    }),
    settings: &[
        bool("enable", "false", switch!(|s, v| s.enable = v), "There is such a switch.").v1("switch.<name>.enable"),
        pin(
            "input_pin",
            "nc",
            PinRole::Input,
            switch!(|s, v| s.input_pin = v.and_then(PinName::digital)),
            "Makes it an input that issues commands; the output settings then mean nothing.",
        )
        .v1("switch.<name>.input_pin"),
        word(
            "input_pin_behavior",
            "momentary",
            &Words(&["momentary", "toggle"]),
            switch!(|s, v| s.input_behaviour = if v == 1 { InputBehaviour::Toggle } else { InputBehaviour::Momentary }),
            "momentary follows the pin, toggle flips at each press.",
        )
        .v1("switch.<name>.input_pin_behavior"),
        text(
            "output_on_command",
            "",
            96,
            switch!(|s, v| s.output_on_command = spaced(v)),
            "Line an input executes when it turns on. Underscores stand for blanks.",
        )
        .v1("switch.<name>.output_on_command"),
        text(
            "output_off_command",
            "",
            96,
            switch!(|s, v| s.output_off_command = spaced(v)),
            "Line an input executes when it turns off. Underscores stand for blanks.",
        )
        .v1("switch.<name>.output_off_command"),
        command(
            "input_on_command",
            switch!(|s, v| s.input_on_command = v),
            "Code that turns the output on, as in M106 or M106.1. hwpwm also takes P, the width of pulses in us.",
        )
        .v1("switch.<name>.input_on_command"),
        command(
            "input_off_command",
            switch!(|s, v| s.input_off_command = v),
            "Code that turns the output off, as in M107.",
        )
        .v1("switch.<name>.input_off_command"),
        command(
            "input_reverse_command",
            switch!(|s, v| s.input_reverse_command = v),
            "A spindle that turns both ways: the code that turns the output on, too, M4 where M3 is input_on_command. A \
             switch of its own that is on by M4 and off by M3 is the direction.",
        )
        .velvet(),
        integer(
            "subcode",
            "0",
            &(0, 255),
            switch!(|s, v| s.subcode = v as u8),
            "Subcode of these codes, where they have none of their own.",
        )
        .v1("switch.<name>.subcode"),
        integer(
            "io_number",
            "-1",
            &(-1, 63),
            switch!(|s, v| s.io_number = u8::try_from(v).ok()),
            "The P or E by which M62 to M68 know it: outputs and inputs have numbers of their own. -1: none.",
        ),
        pin(
            "output_pin",
            "nc",
            PinRole::OutputOrPwm,
            switch!(|s, v| s.output_pin = v.and_then(PinName::output)),
            "The output: a pin for digital and sigmadeltapwm, PWM1_1 to PWM2_4 for hwpwm.",
        )
        .klipper("[fan_generic <name>] pin")
        .v1("switch.<name>.output_pin"),
        word(
            "output_type",
            "",
            &Words(&["digital", "sigmadeltapwm", "hwpwm"]),
            switch!(|s, v| s.output_kind = output_kind(v)),
            "digital is on or off; sigmadeltapwm takes S0 to S255; hwpwm takes percent on a timer channel.",
        )
        .required()
        .v1("switch.<name>.output_type"),
        integer(
            "max_pwm",
            "255",
            &(0, 255),
            switch!(|s, v| s.max_pwm = Duty(v as u8)),
            "What S255 means on a sigmadeltapwm output.",
        )
        .v1("switch.<name>.max_pwm"),
        number(
            "cycle_time",
            "0",
            &(0.0, 10.0),
            switch!(|s, v| s.cycle = Micros((v * 1e6) as u64)),
            "sigmadeltapwm: the output is on once in so long, for its share of it, as a relay needs. 0: as often as can be.",
        )
        .unit("s")
        .klipper("[output_pin <name>] cycle_time")
        .velvet(),
        bool("startup_state", "false", switch!(|s, v| s.startup_state = v), "On at boot.")
            .v1("switch.<name>.startup_state"),
        number(
            "startup_value",
            "0",
            &(0.0, 255.0),
            switch!(|s, v| s.startup_value = v as f32),
            "sigmadeltapwm: the value of on, 0 to 255. hwpwm: percent of off.",
        )
        .derived("max_pwm for sigmadeltapwm, else 0")
        .v1("switch.<name>.startup_value"),
        number(
            "default_on_value",
            "0",
            &(0.0, 100.0),
            switch!(|s, v| s.default_on_value = v as f32),
            "hwpwm: percent of an on code without words, and at boot with startup_state.",
        )
        .unit("%")
        .v1("switch.<name>.default_on_value"),
        number(
            "max_rpm",
            "0",
            &(0.0, 1_000_000.0),
            switch!(|s, v| s.max_rpm = v as f32),
            "A spindle: S is its speed, and this one is full power; more is told and limited. 0: S is percent, or 0 to 255.",
        )
        .unit("1/min")
        .velvet(),
        number(
            "min_rpm",
            "0",
            &(0.0, 1_000_000.0),
            switch!(|s, v| s.min_rpm = v as f32),
            "With max_rpm: an S above 0 and below this is told, and raised to it.",
        )
        .unit("1/min")
        .velvet(),
        number(
            "on_delay",
            "0",
            &(0.0, 60.0),
            switch!(|s, v| s.on_delay = Micros((v * 1e6) as u64)),
            "So long after an on code has turned it on, the next line follows: a power supply has come up by then.",
        )
        .unit("s")
        .velvet(),
        number(
            "off_delay",
            "0",
            &(0.0, 60.0),
            switch!(|s, v| s.off_delay = Micros((v * 1e6) as u64)),
            "So long after an off code has turned it off, the next line follows: a spindle stands by then, and may turn the \
             other way.",
        )
        .unit("s")
        .velvet(),
        number(
            "servo_max_angle",
            "0",
            &(0.0, 720.0),
            switch!(|s, v| s.servo.max_angle = v as f32),
            "hwpwm: it turns a servo, and S is an angle up to this, or the width of its pulses in us. 0: S is percent.",
        )
        .unit("degree")
        .klipper("[servo <name>] maximum_servo_angle")
        .velvet(),
        number(
            "servo_min_us",
            "1000",
            &(100.0, 10_000.0),
            switch!(|s, v| s.servo.pulse_us[0] = v as f32),
            "Width of the servo's pulses at angle 0; they are never less wide.",
        )
        .unit("us")
        .klipper("[servo <name>] minimum_pulse_width")
        .velvet(),
        number(
            "servo_max_us",
            "2000",
            &(100.0, 10_000.0),
            switch!(|s, v| s.servo.pulse_us[1] = v as f32),
            "The same at servo_max_angle; they are never wider.",
        )
        .unit("us")
        .klipper("[servo <name>] maximum_pulse_width")
        .velvet(),
        bool(
            "failsafe_set_to",
            "false",
            switch!(|s, v| s.failsafe_set_to = v),
            "State in a fault of the firmware itself.",
        )
        .klipper("[output_pin <name>] shutdown_value")
        .v1("switch.<name>.failsafe_set_to")
        .support(&Support::NotYet {
            severity: Severity::Warning,
            advice: "leave it out; a fault of the firmware resets the board, and outputs go off",
        }),
        bool("halt_set_to", "false", switch!(|s, v| s.halt_set_to = v), "State when the machine halts.")
            .v1("switch.<name>.halt_set_to"),
        bool(
            "ignore_on_halt",
            "false",
            switch!(|s, v| s.ignore_on_halt = v),
            "Leave the output alone in a halt. MOSFET outputs lose power all the same.",
        ),
    ],
};

pub const PWM1: Section = Section {
    name: "pwm1",
    store: None,
    docs: Docs::new("Timer of PWM1_1 to PWM1_4 (PE9, PE11, PE13, PE14). The section must be there to use them."),
    form: Form::Plain,
    settings: &[integer(
        "frequency",
        "10000",
        &(1, 100_000),
        |c, _, v| c.pwm_frequency_hz[0] = Some(v as u32),
        "Frequency; the duty has 1000 steps, below 200 Hz more.",
    )
    .derived("10000 when the section is there")
    .unit("Hz")
    .v1("laser_module_pwm_period")],
};

pub const PWM2: Section = Section {
    name: "pwm2",
    store: None,
    docs: Docs::new("Timer of PWM2_1 to PWM2_4 (PI5, PI6, PI7, PI2). The section must be there to use them."),
    form: Form::Plain,
    settings: &[integer(
        "frequency",
        "10000",
        &(1, 100_000),
        |c, _, v| c.pwm_frequency_hz[1] = Some(v as u32),
        "Frequency; the duty has 1000 steps, below 200 Hz more.",
    )
    .derived("10000 when the section is there")
    .unit("Hz")
    .v1("laser_module_pwm_period")],
};

pub const VOLTAGE_MONITOR: Section = Section {
    name: "voltage monitor",
    store: None,
    docs: Docs::new("Voltages to watch, by name. vmotor (ADC3_5) and vfet (ADC3_2) are built in."),
    form: Form::Keyed(Instances {
        noun: "voltage",
        find: |c, name| c.voltages.iter().position(|voltage| voltage.name == name),
        create: |c, name| {
            let voltage = VoltageMonitor { name: new_name(name)?, input: VoltageInput(0), scale: 11.0 };
            c.voltages.push(voltage).map_err(|_| CannotCreate::Full(MAX_VOLTAGES))?;
            Ok(c.voltages.len() - 1)
        },
        name: |c, i| c.voltages.get(i).map_or("", |voltage| voltage.name.as_str()),
        is_live: |c, i| c.voltages.get(i).is_some(),
    }),
    settings: &[voltage(
        "",
        |c, i, (input, scale)| {
            if let Some(voltage) = c.voltages.get_mut(i) {
                voltage.input = input;
                voltage.scale = scale as f32;
            }
        },
        "Input ADC3_0 to ADC3_5 and, after a comma, the divider's scale; 11 without one.",
    )
    .by_name(&ByName(&[("vmotor", "ADC3_5"), ("vfet", "ADC3_2")]))
    .unit("V")],
};
