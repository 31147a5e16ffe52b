//! Reports of `switch` and `$S`.

use base::sessions::Reply;
use config::{InputBehaviour, MachineConfig, OutputKind, OutputPin, PinName, Pull, SwitchConfig};

use super::{Outputs, Status};

impl Outputs {
    /// `$S [name ...]`: reports `switch <name> is <0|1>` for the named switches, or for every switch.
    pub fn report(&self, config: &MachineConfig, names: &str, reply: &mut Reply<'_>) {
        for (switch, status) in config.switches.iter().zip(&self.status) {
            if names.is_empty() || names.split_ascii_whitespace().any(|name| switch.name == name) {
                reply.say(format_args!("switch {} is {}\n", switch.name, u8::from(status.on)));
            }
        }
    }

    /// `switch`: lists the connections and commands of each switch.
    pub(super) fn list(&self, config: &MachineConfig, reply: &mut Reply<'_>) {
        for (switch, status) in config.switches.iter().zip(&self.status) {
            reply.say(format_args!("{}:\n ", switch.name));
            if switch.is_input() {
                input(switch, status, reply);
            } else {
                output(switch, status, reply);
            }
            if switch.subcode != 0 {
                reply.say(format_args!("SUBCODE:{},", switch.subcode));
            }
            reply.say(format_args!("\n"));
        }
    }
}

/// Reports an input as `INPUT:PJ14^:0,momentary,OUTPUT_ON_COMMAND:M106,`.
fn input(switch: &SwitchConfig, status: &Status, reply: &mut Reply<'_>) {
    let Some(pin) = switch.input_pin else { return };
    let behaviour = if switch.input_behaviour == InputBehaviour::Toggle { "toggle" } else { "momentary" };
    // Without a pull in the configuration an input is pulled up.
    let pull = if pin.pull == Pull::Default { "^" } else { "" };
    reply.say(format_args!("INPUT:{pin}{pull}:{},{behaviour},", u8::from(status.level)));
    for (name, command) in [("ON", &switch.output_on_command), ("OFF", &switch.output_off_command)] {
        if !command.is_empty() {
            reply.say(format_args!("OUTPUT_{name}_COMMAND:{command},"));
        }
    }
}

/// Reports an output as `OUTPUT:PE1:0,sigmadeltapwm,INPUT_ON_COMMAND:M106,INPUT_OFF_COMMAND:M107,`: the level
/// is 1 if the output is fully on; an output on a timer shows its percent.
fn output(switch: &SwitchConfig, status: &Status, reply: &mut Reply<'_>) {
    let level = u8::from(status.on && status.value >= 255.0);
    match switch.output_pin {
        Some(OutputPin::Pwm(pin)) => reply.say(format_args!("OUTPUT:{}:{:.6},hwpwm,", PinName::Pwm(pin), status.value)),
        Some(OutputPin::Digital(pin)) => {
            let kind = if switch.output_kind == OutputKind::Digital { "digital" } else { "sigmadeltapwm" };
            reply.say(format_args!("OUTPUT:{pin}:{level},{kind},"));
        }
        None => reply.say(format_args!("OUTPUT:nc,")),
    }
    for (name, code) in [("ON", switch.input_on_command), ("OFF", switch.input_off_command)] {
        if let Some(code) = code {
            reply.say(format_args!("INPUT_{name}_COMMAND:{},", code.sub(0)));
        }
    }
}
