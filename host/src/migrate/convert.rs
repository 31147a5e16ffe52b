//! Old settings into new ones: by the schema's table of old names, and by hand if the structure changed.

use config::schema::{self, Kind, Section, Setting, Support};

use super::board::{Board, Mapped};
use super::ini::Entry;
use super::old::Line;

/// Task for a person, and the line of the old file that causes it.
#[derive(Debug)]
pub struct ToDo {
    pub line: Option<usize>,
    pub text: String,
}

/// State of a conversion: the lines and tasks made so far.
pub struct Conversion<'a> {
    board: &'a Board,
    lines: &'a [Line],
    /// Names of the enabled extruders, in order: their motors are delta, epsilon, zeta.
    extruders: Vec<String>,
    pub entries: Vec<Entry>,
    pub to_do: Vec<ToDo>,
}

/// Settings with nothing left to set on the new board.
const NEEDLESS: &[&str] = &[
    "currentcontrol_module_enable",
    "digipotchip",
    "digipot_max_current",
    "digipot_factor",
    "endstops_enable",
    "leds_disable",
    "play_led_disable",
    "msd_disable",
    "dfu_enable",
    "uart0.baud_rate",
    "watchdog_timeout",
    "sd_ok",
    "base_stepping_frequency",
    "extruder_module_enable",
];
const EXTRUDER_MOTORS: [&str; 3] = ["delta", "epsilon", "zeta"];
/// Old motor names and their axes, in order.
const ENDSTOP_AXES: [(&str, &str); 3] = [("alpha", "X"), ("beta", "Y"), ("gamma", "Z")];

impl<'a> Conversion<'a> {
    /// Creates a conversion of these lines for a board, with nothing converted yet.
    pub fn new(lines: &'a [Line], board: &'a Board) -> Self {
        let extruders = lines
            .iter()
            .filter(|line| is_true(&line.value))
            .filter_map(|line| Some(line.key.strip_prefix("extruder.")?.strip_suffix(".enable")?.to_owned()))
            .collect();
        Self { board, lines, extruders, entries: Vec::new(), to_do: Vec::new() }
    }

    /// Converts every line, and notes what a person has to do.
    pub fn run(&mut self) {
        for line in self.lines {
            if !self.is_switched_off(&line.key) {
                self.convert(line);
            }
        }
        for (motor, axis) in ENDSTOP_AXES {
            self.endstops(motor, axis);
        }
        self.tools();
        self.switches();
        self.drivers();
    }

    fn old(&self, key: &str) -> Option<&'a Line> {
        self.lines.iter().find(|line| line.key == key)
    }

    /// Returns whether the setting's module exists but is not enabled.
    fn is_switched_off(&self, key: &str) -> bool {
        let off = |enable: &str| self.old(enable).is_some_and(|line| !is_true(&line.value));
        let module = key.rsplit_once('.').map(|(module, _)| module);
        module.is_some_and(|module| off(&format!("{module}.enable")))
            || (key.starts_with("laser_module") && self.old("laser_module_enable").is_none_or(|l| !is_true(&l.value)))
            || key.split('.').next().is_some_and(|first| first != key && off(&format!("{first}.enable")))
    }

    fn ask(&mut self, line: &Line, text: String) {
        if !self.to_do.iter().any(|known| known.text == text) {
            self.to_do.push(ToDo { line: Some(line.number), text });
        }
    }

    fn add(&mut self, section: &'static str, instance: &str, key: &str, value: &str, comment: String) {
        let (instance, key, value) = (instance.to_owned(), key.to_owned(), value.to_owned());
        self.entries.retain(|e| (e.section, &e.instance, &e.key) != (section, &instance, &key));
        self.entries.push(Entry { section, instance, key, value, comment, above: Vec::new() });
    }

    fn convert(&mut self, line: &Line) {
        let key = line.key.as_str();
        if NEEDLESS.contains(&key) || is_of_an_axis_switch(key) {
            return;
        }
        if key == "include" {
            return self.ask(line, format!("the file includes {}: migrate it too and join the two", line.value));
        }
        if let Some((name, rest)) = key.strip_prefix("extruder.").and_then(|rest| rest.split_once('.'))
            && self.extruder_motor(line, name, rest)
        {
            return;
        }
        if let Some((name, rest)) = key.strip_prefix("endstop.").and_then(|rest| rest.split_once('.')) {
            return self.by_row(line, "endstops", name, rest);
        }
        match key {
            "z_acceleration" => return self.add("actuator", "gamma", "acceleration", &line.value, comment_of(line)),
            "grbl_mode" => return self.by_row(line, "general", "", "grbl_mode"),
            _ => {}
        }
        if let Some((name, "sensor")) = key.strip_prefix("temperature_control.").and_then(|rest| rest.split_once('.')) {
            return self.by_row(line, "temperature control", name, "sensor");
        }
        match schema::by_v1_name(key) {
            Some((section, row, instance)) => self.setting(line, section, row, instance.unwrap_or("")),
            None => {
                // A whole module gets a single item.
                let text = match key.split_once('.') {
                    Some((module, _)) => format!("{module}: Velvet has nothing of the kind; its lines are left out"),
                    None => format!("{key} = {}: Velvet has no such setting; it is left out", line.value),
                };
                self.ask(line, text);
            }
        }
    }

    /// Converts a setting whose place in the new file is known by name.
    fn by_row(&mut self, line: &Line, section: &str, instance: &str, key: &str) {
        let found = schema::section(section)
            .and_then(|(_, section)| Some((section, section.settings.iter().find(|row| row.key == key)?)));
        match found {
            Some((section, row)) => self.setting(line, section, row, instance),
            None => self.ask(line, format!("{}: Velvet has no such setting; it is left out", line.key)),
        }
    }

    fn setting(&mut self, line: &Line, section: &'static Section, row: &'static Setting, instance: &str) {
        match row.support {
            Support::Now => {}
            Support::NotYet { .. } if !is_true(&line.value) && matches!(row.kind, Kind::Bool) => {
                return;
            }
            Support::NotYet { advice, .. } => {
                return self.ask(line, format!("{}: not supported yet ({advice}); it is left out", line.key));
            }
            // The setting's module is off, or an item asks about it already.
            Support::Dormant => return,
            // A needless setting loses nothing by being left out.
            Support::Needless { .. } => return,
        }
        let Some(value) = self.value(line, row, instance) else { return };
        let instance = if row.is_common { "common" } else { instance };
        let comment = if line.comment.is_empty() && line.key == row.key { String::new() } else { comment_of(line) };
        self.add(section.name, instance, row.key, &value, comment);
    }

    /// Returns the value in the new file's words; none when the line is not needed.
    fn value(&mut self, line: &Line, row: &Setting, instance: &str) -> Option<String> {
        Some(match row.kind {
            Kind::Pin(..) => match self.board.map(&line.value) {
                Mapped::Pin(pin, to_do) => {
                    if let Some(text) = to_do {
                        self.ask(line, text);
                    }
                    pin
                }
                Mapped::Dropped => return None,
                Mapped::Unknown => {
                    let name = if instance.is_empty() { row.key.to_owned() } else { format!("{instance}.{}", row.key) };
                    self.ask(line, format!("{name}: choose a pin; v1's {} has no counterpart", line.value));
                    "nc".into()
                }
            },
            Kind::Bool => is_true(&line.value).to_string(),
            Kind::Word(..) if row.key == "output_type" && line.value == "pwm" => "sigmadeltapwm".into(),
            // The old file wrote blanks as underscores.
            Kind::Text(..) if row.key.contains("gcode") || row.key.ends_with("_command") => {
                line.value.replace('_', " ")
            }
            _ => line.value.clone(),
        })
    }

    /// Converts an extruder's motor settings, which stand in the motor's section now.
    fn extruder_motor(&mut self, line: &Line, name: &str, rest: &str) -> bool {
        let Some(motor) = self.extruders.iter().position(|known| known == name).and_then(|i| EXTRUDER_MOTORS.get(i))
        else {
            self.ask(line, format!("extruder {name}: Velvet has motors for three extruders; it is left out"));
            return true;
        };
        match rest {
            "steps_per_mm" | "acceleration" | "step_pin" | "dir_pin" | "en_pin" => {
                self.by_row(line, "actuator", motor, rest);
            }
            "max_speed" => {
                // From mm/s to mm/min.
                let rate = line.value.parse::<f64>().map_or_else(|_| line.value.clone(), |v| (v * 60.0).to_string());
                let comment = format!("mm/min; was {} = {} mm/s", line.key, line.value);
                self.add("actuator", motor, "max_rate", &rate, comment);
            }
            "default_feed_rate" => {}
            _ => return false,
        }
        true
    }

    /// Writes tool numbers, which follow the order of the extruders as before.
    fn tools(&mut self) {
        for (tool, name) in self.extruders.clone().into_iter().enumerate().take(EXTRUDER_MOTORS.len()) {
            let motor = EXTRUDER_MOTORS.get(tool).unwrap_or(&"");
            self.add("extruder", &name, "tool_id", &tool.to_string(), format!("T{tool}, turned by motor {motor}"));
        }
    }

    /// Sets outputs to modulated unless the old file says otherwise.
    fn switches(&mut self) {
        let of_switch = |key: &str| {
            let found = self.entries.iter().filter(move |e| e.section == "switch" && e.key == key);
            found.map(|e| e.instance.clone()).collect::<Vec<_>>()
        };
        let typed = of_switch("output_type");
        for name in of_switch("output_pin").into_iter().filter(|name| !typed.contains(name)) {
            self.add("switch", &name, "output_type", "sigmadeltapwm", "as v1 assumed".into());
        }
    }

    /// Converts `alpha_min_endstop` and its kin: an endstop of its own for each end.
    fn endstops(&mut self, motor: &str, axis: &'static str) {
        let direction = self.old(&format!("{motor}_homing_direction")).map(|line| line.value.clone());
        for (end, towards) in [("min", "home_to_min"), ("max", "home_to_max")] {
            let Some(pin) = self.old(&format!("{motor}_{end}_endstop")) else { continue };
            if pin.value.eq_ignore_ascii_case("nc") {
                continue;
            }
            let name = format!("{end}{}", axis.to_ascii_lowercase());
            self.add("endstops", &name, "enable", "true", String::new());
            self.by_row(pin, "endstops", &name, "pin");
            self.add("endstops", &name, "axis", axis, String::new());
            let homes = direction.as_deref().unwrap_or("home_to_min") == towards;
            self.add("endstops", &name, "homing_direction", if homes { towards } else { "none" }, String::new());
            let limit = self.old(&format!("{motor}_limit_enable"));
            if let Some(limit) = limit {
                self.by_row(limit, "endstops", &name, "limit_enable");
            }
            if homes {
                self.homing(motor, end, &name);
            }
        }
    }

    fn homing(&mut self, motor: &str, end: &str, name: &str) {
        for (old, key) in [
            (format!("{motor}_{end}"), "homing_position"),
            (format!("{motor}_max_travel"), "max_travel"),
            (format!("{motor}_fast_homing_rate_mm_s"), "fast_rate"),
            (format!("{motor}_slow_homing_rate_mm_s"), "slow_rate"),
            (format!("{motor}_homing_retract_mm"), "retract"),
        ] {
            if let Some(line) = self.old(&old) {
                self.by_row(line, "endstops", name, key);
            }
        }
    }

    /// Describes the new board's drivers; the old board's could only be guessed.
    fn drivers(&mut self) {
        let motors: Vec<String> = units::Actuator::ALL
            .into_iter()
            .map(|motor| motor.name().to_owned())
            .filter(|motor| self.entries.iter().any(|e| e.section == "actuator" && e.instance == *motor))
            .collect();
        for motor in motors.iter().filter(|motor| !matches!(motor.as_str(), "epsilon" | "zeta")) {
            let comment = "as the v1 board's drivers were set".to_owned();
            self.add("actuator", motor, "microsteps", "32", comment);
            self.add("actuator", motor, "driver", "tmc2590", String::new());
            self.add("tmc2590", motor, "sense_resistor", "50", "mOhm, as on the board".into());
        }
        if !motors.is_empty() {
            self.to_do.push(ToDo {
                line: None,
                text:
                    "steps_per_mm: a v1 board makes 32 microsteps (16 before revision 1.1); 32 are set here, so double \
                       steps_per_mm when yours made 16"
                        .into(),
            });
        }
    }
}

/// Returns whether a key belongs to the endstops that [`Conversion::endstops`] makes.
fn is_of_an_axis_switch(key: &str) -> bool {
    ENDSTOP_AXES.iter().any(|(motor, _)| {
        key.strip_prefix(motor).is_some_and(|rest| {
            [
                "_min_endstop",
                "_max_endstop",
                "_homing_direction",
                "_min",
                "_max",
                "_max_travel",
                "_fast_homing_rate_mm_s",
                "_slow_homing_rate_mm_s",
                "_homing_retract_mm",
                "_limit_enable",
            ]
            .contains(&rest)
        })
    })
}

fn is_true(value: &str) -> bool {
    matches!(value, "true" | "1")
}

fn comment_of(line: &Line) -> String {
    if line.comment.is_empty() { format!("was {}", line.key) } else { line.comment.clone() }
}
