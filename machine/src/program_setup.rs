//! The configuration's words for the program, in `program`'s own types.

use config::{CommandCode, MachineConfig};
use gcode::Code;
use program::{Claim, Claims, CycleSetup, Dialect, HeaterSetup, Setup, ToolSettings};
use units::{Axis, SwitchId};

/// The dialect of sessions that have none of their own, and of files.
#[must_use]
pub const fn dialect(config: &MachineConfig) -> Dialect {
    if config.general.grbl_mode { Dialect::Grbl } else { Dialect::Smoothie }
}

/// What the program is told of the machine.
#[must_use]
pub fn setup(config: &MachineConfig) -> Setup {
    let heater = |heater: &config::TemperatureConfig| HeaterSetup { id: heater.tool_id, presets: heater.presets };
    Setup {
        feed_rate: config.motion.default_feed_rate,
        seek_rate: config.motion.default_seek_rate,
        compliant_seek_rate: config.motion.compliant_seek_rate,
        g92: config.motion.set_g92.unwrap_or_default(),
        tools: config.extruders.iter().map(|extruder| tool(config, extruder)).take(program::MAX_TOOLS).collect(),
        heaters: config.temperatures.iter().map(heater).take(units::MAX_HEATERS).collect(),
        claims: claims(config),
        cycles: CycleSetup { is_off: !config.cycles.enable, dwell_in_ms: config.cycles.dwell_in_ms },
    }
}

fn tool(config: &MachineConfig, extruder: &config::ExtruderConfig) -> ToolSettings {
    let axis = match extruder.tool_id.0 {
        0 => Axis::A,
        1 => Axis::B,
        _ => Axis::C,
    };
    ToolSettings {
        id: extruder.tool_id,
        axis,
        offset: extruder.offset.map(|mm| mm.0),
        filament_diameter: extruder.filament_diameter.map(|mm| mm.0).filter(|mm| *mm > 0.01),
        retract_length: extruder.retract_length.0,
        retract_rate: extruder.retract_rate,
        recover_length: extruder.recover_length.0,
        recover_rate: extruder.recover_rate,
        z_lift: extruder.z_lift.0,
        z_lift_rate: extruder.z_lift_rate,
        is_off: config.off("extruder", &extruder.name).is_some(),
    }
}

/// The codes that heaters and output switches listen to. Which can be claimed, the configuration has checked.
fn claims(config: &MachineConfig) -> Claims {
    let mut claims = Claims::default();
    for (id, heater) in config.heaters() {
        for (number, claim) in [
            (heater.set_m_code, Claim::Target(id)),
            (heater.set_and_wait_m_code, Claim::TargetAndWait(id)),
            (heater.get_m_code, Claim::Temperature(id)),
        ] {
            let _fits = claims.add(Code::m(number), claim);
        }
    }
    let outputs = config.switches.iter().enumerate().filter(|(_, switch)| !switch.is_input());
    for (index, switch) in outputs {
        let id = SwitchId(index as u8);
        for (command, claim) in
            [(switch.input_on_command, Claim::SwitchOn(id)), (switch.input_off_command, Claim::SwitchOff(id))]
        {
            if let Some(command) = command {
                let _fits = claims.add(code(command), claim);
            }
        }
    }
    claims
}

const fn code(command: CommandCode) -> Code {
    let code = if command.letter == 'G' { Code::g(command.number) } else { Code::m(command.number) };
    code.sub(command.subcode)
}
