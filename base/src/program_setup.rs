//! Translates the configuration of the program to `program`'s own types.

use config::{MachineConfig, OutputKind, OutputPin, SwitchConfig};
use gcode::Code;
use program::extended::NamedSwitch;
use program::{
    Claim, Claims, Dialect, HeaterSetup, IoKind, IoSetup, LaserSetup, PulseSetup, Setup, SpindleSetup, StripSetup,
    ToolSettings,
};
use units::SwitchId;

/// Names of the machine's parts in commands by name: as in the configuration, and as Klipper's for parts that
/// every printer has.
pub struct PartNames<'c> {
    /// Configuration with the parts.
    pub config: &'c MachineConfig,
    /// Dialect in which the parts' codes are read.
    pub dialect: Dialect,
}

impl program::extended::Names for PartNames<'_> {
    fn switch(&self, name: &str) -> Option<NamedSwitch> {
        let outputs = || self.config.switches.iter().filter(|switch| !switch.is_input());
        let named = outputs().find(|switch| switch.name.eq_ignore_ascii_case(name));
        let is_fan = |switch: &SwitchConfig| switch.input_on_command.is_some_and(|on| on.sub(0) == Code::m(106));
        let fan = || outputs().find(|switch| switch.input_on_command.is_some_and(|on| on == Code::m(106)));
        let switch = if name.eq_ignore_ascii_case("fan") { named.or_else(fan) } else { named };
        let switch = switch?;
        let full = match switch.output_kind {
            _ if switch.max_rpm > 0.0 => f64::from(switch.max_rpm),
            OutputKind::HardwarePwm if !is_fan(switch) || !self.dialect.numbers_fans() => 100.0,
            _ => 255.0,
        };
        let off = switch.input_off_command;
        if let Some(on) = switch.input_on_command {
            return Some(NamedSwitch { on, number: None, off, full });
        }
        // A switch that only has a number is set by M42.
        Some(NamedSwitch { on: Code::m(42), number: Some(switch.io_number?), off, full })
    }

    fn heater(&self, name: &str) -> Option<(Code, u8)> {
        let heaters = || self.config.temperatures.iter();
        let named = heaters().find(|heater| heater.name.eq_ignore_ascii_case(name));
        let bed = || heaters().find(|heater| heater.set_m_code == 140);
        let tool = |id: u8| heaters().find(|heater| heater.tool_id.0 == id);
        let heater = match (named, name.strip_prefix("extruder")) {
            (Some(heater), _) => Some(heater),
            (None, Some("")) => tool(0),
            (None, Some(number)) => number.parse().ok().and_then(tool),
            (None, None) if name.eq_ignore_ascii_case("heater_bed") => bed(),
            (None, None) => None,
        };
        heater.map(|heater| (Code::m(heater.set_m_code), heater.tool_id.0))
    }

    fn strip(&self, name: &str) -> Option<u8> {
        let strip = self.config.led_strips.iter().find(|strip| strip.name.eq_ignore_ascii_case(name));
        strip.map(|strip| strip.number)
    }

    fn has_strips(&self) -> bool {
        !self.config.led_strips.is_empty()
    }

    fn heater_at(&self, place: usize) -> Option<(Code, u8)> {
        self.config.temperatures.get(place).map(|heater| (Code::m(heater.set_m_code), heater.tool_id.0))
    }

    fn motor(&self, name: &str) -> Option<char> {
        const LETTERS: [char; 6] = ['X', 'Y', 'Z', 'A', 'B', 'C'];
        let (section, number) = name.split_at(name.len().min("extruder".len()));
        if section.eq_ignore_ascii_case("extruder") {
            let id: u8 = if number.is_empty() { 0 } else { number.parse().ok()? };
            let extruder = self.config.extruders.iter().find(|extruder| extruder.tool.id.0 == id)?;
            return LETTERS.get(extruder.actuator()? as usize).copied();
        }
        // The towers of a delta are a, b and c, and its first three motors.
        let (_, axis) = name.split_at_checked("stepper_".len()).filter(|(section, _)| *section == "stepper_")?;
        let place = ["x", "y", "z", "a", "b", "c"].into_iter().position(|known| axis.eq_ignore_ascii_case(known))?;
        LETTERS.get(place % 3).copied()
    }
}

/// Returns the settings of the machine that the program needs.
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
        keeps_offsets: config.general.grbl_mode,
        pulses: config
            .switches
            .iter()
            .enumerate()
            .filter_map(|(place, switch)| pulses(config, place, switch))
            .collect(),
        io: config.switches.iter().enumerate().filter_map(io).collect(),
        strips: config.led_strips.iter().map(strip).collect(),
        is_preview: false,
        // No machine here has a spindle that says where it is, or whose speed follows the radius.
        spindle: SpindleSetup::default(),
        laser: laser(config),
        g30_parks: config.motion.nist_g30,
        cycles: config.cycles,
    }
}

/// Returns the laser; moves have power from the start.
fn laser(config: &MachineConfig) -> Option<LaserSetup> {
    let laser = &config.laser;
    (laser.enable && laser.pwm_pin.is_some()).then_some(LaserSetup {
        is_laser_mode: true,
        always_by_speed: laser.proportional_power,
        default_s: laser.default_power,
    })
}

/// Returns the pulses of a switch on a hardware timer.
fn pulses(config: &MachineConfig, place: usize, switch: &SwitchConfig) -> Option<PulseSetup> {
    let Some(OutputPin::Pwm(pwm)) = switch.output_pin.filter(|_| switch.max_rpm == 0.0) else { return None };
    let hertz = (*config.pwm_frequency_hz.get(usize::from(pwm.timer).checked_sub(1)?)?)?;
    let servo = (switch.servo.max_angle > 0.0).then_some(switch.servo);
    Some(PulseSetup { switch: SwitchId(place as u8), percent_per_us: hertz as f32 / 1e4, servo })
}

/// Returns the number by which M62 to M68 know a switch.
fn io((place, switch): (usize, &SwitchConfig)) -> Option<IoSetup> {
    let kind = match switch.output_kind {
        _ if switch.is_input() => IoKind::Input,
        OutputKind::Digital => IoKind::Digital,
        OutputKind::SigmaDelta | OutputKind::HardwarePwm => IoKind::Analog,
    };
    Some(IoSetup { number: switch.io_number?, switch: SwitchId(place as u8), kind })
}

fn strip(strip: &config::LedStripConfig) -> StripSetup {
    StripSetup { number: strip.number, lights: strip.lights() }
}

fn tool(config: &MachineConfig, extruder: &config::ExtruderConfig) -> ToolSettings {
    ToolSettings { is_off: config.off("extruder", &extruder.name).is_some(), ..extruder.tool.clone() }
}

/// Returns the codes that heaters and output switches listen to. The configuration has checked that they can
/// be claimed.
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
    // A switch that turns the spindle both ways comes last: its direction is set by then.
    for both_ways in [false, true] {
        let outputs = config.switches.iter().enumerate().filter(|(_, switch)| !switch.is_input());
        for (index, switch) in outputs.filter(|(_, switch)| switch.input_reverse_command.is_some() == both_ways) {
            let id = SwitchId(index as u8);
            for (command, claim) in [
                (switch.input_on_command, Claim::SwitchOn(id)),
                (switch.input_reverse_command, Claim::SwitchOn(id)),
                (switch.input_off_command, Claim::SwitchOff(id)),
            ] {
                if let Some(command) = command {
                    let _fits = claims.add(command, claim);
                }
            }
        }
    }
    let air = config.switches.iter().position(|switch| !switch.is_input() && config.laser.air_switch == switch.name);
    if let Some(air) = air.filter(|_| laser(config).is_some()) {
        let id = SwitchId(air as u8);
        for (number, claim) in [(3, Claim::SwitchOn(id)), (4, Claim::SwitchOn(id)), (5, Claim::SwitchOff(id))] {
            let _fits = claims.add(Code::m(number), claim);
        }
    }
    for (place, rule) in (0..).zip(&config.temperature_switches) {
        if let Some(number) = rule.arm_mcode {
            let _fits = claims.add(Code::m(number), Claim::Arm(place));
        }
    }
    claims
}

#[cfg(test)]
mod tests {
    use super::*;
    use program::extended::Names;
    use units::ToolId;

    #[test]
    fn heaters_are_found_by_their_place() {
        let mut config = MachineConfig::default();
        for (set_m_code, tool) in [(104, 2), (140, 0)] {
            let heater = config::TemperatureConfig { set_m_code, tool_id: ToolId(tool), ..Default::default() };
            config.temperatures.push(heater).unwrap_or_else(|_| panic!("room"));
        }
        let names = PartNames { config: &config, dialect: Dialect::Smoothie };
        assert_eq!(names.heater_at(0), Some((Code::m(104), 2)));
        assert_eq!((names.heater_at(1), names.heater_at(2)), (Some((Code::m(140), 0)), None));
    }
}
