//! Macros of a machine's printer.cfg, looked into for its jobs as the board does: rendered for the machine as
//! it is when it has just been switched on.

use std::path::Path;

use ::macros::Action;
use anyhow::Result;
use base::failure::{Failure, Texts};
use base::motion_config::motion_config;
use base::safety::travel::Travel;
use base::sessions::LineBytes;
use base::taken_codes::{TakenCodes, is_move};
use base::tuning::Tuning;
use config::MachineConfig;
use gcode::{Block, Blocks, Extended};
use preflight::{Called, MacroCall, MacroName, MacroPlace};
use serde_json::{Map, Value, json};
use units::{Axis, PerAxis};

use crate::macros::check::told;
use crate::macros::files::{self, Entry};
use crate::macros::render::machine_of;
use crate::macros::{MEMORY, OUTPUT};

/// Most macros that are called from each other on the board.
const DEEPEST: usize = 12;

/// A macro whose lines come next.
struct Entered {
    section: String,
    name: String,
    lines: String,
    /// Number of lines that have been taken.
    taken: usize,
    /// Names in the lines mean what they mean without macros.
    is_plain: bool,
    is_sure: bool,
}

/// All macros, and those entered, the innermost last.
pub struct Macros<'t> {
    texts: &'t Texts,
    /// Folder of the printer.cfg, with a slash behind it.
    folder: String,
    entries: Vec<Entry>,
    status: Map<String, Value>,
    entered: Vec<Entered>,
    variables_change: bool,
}

impl<'t> Macros<'t> {
    /// Reads the macros of a machine whose configuration lies there as on its card.
    pub fn read(texts: &'t Texts, config: &MachineConfig, folder: &Path) -> Result<Self> {
        let name = config.macros.file.as_str();
        let name = name.strip_prefix("/sd/").unwrap_or(name).trim_start_matches('/');
        let path = folder.join(name);
        let entries = files::read(&path)?;
        let folder = path.parent().map_or_else(String::new, |folder| format!("{}/", folder.display()));
        Ok(Self { texts, folder, entries, status: status(config), entered: Vec::new(), variables_change: false })
    }

    /// Codes that macros have taken, or under which goes what they have replaced.
    pub fn taken(&self) -> TakenCodes {
        let renamed = self.entries.iter().filter(|entry| entry.name == "rename_existing").map(Entry::value);
        let own = self.entries.iter().filter_map(|entry| Some(name_of(&entry.section)?.to_owned()));
        renamed.chain(own).fold(TakenCodes::None, |taken, name| {
            let mut block = Block::new(None, 0);
            let is_read = Blocks::new(name.as_bytes()).read(&mut block, &mut gcode::NoParameters);
            match block.code.filter(|_| is_read == Ok(true)) {
                Some(code) if is_move(code) => TakenCodes::Any,
                Some(_) if taken == TakenCodes::None => TakenCodes::ButMoves,
                _ => taken,
            }
        })
    }

    /// Looks for the macro of a call, and renders it.
    pub fn called(&mut self, call: MacroCall<'_>) -> Called {
        if self.entered.last().is_some_and(|innermost| innermost.is_plain) {
            return Called::Nothing;
        }
        let line = call.to_string();
        let command = Extended::new(&line);
        let name = if call.is_code() { line.split(' ').next().unwrap_or_default() } else { command.name() };
        let words = if call.is_code() { line[name.len()..].trim_start() } else { command.rest() };
        self.variables_change |= command.is("SET_GCODE_VARIABLE") || command.is("SAVE_VARIABLE");
        let is_own = |entry: &&Entry| name_of(&entry.section).is_some_and(|known| known.eq_ignore_ascii_case(name));
        let is_renamed = |entry: &&Entry| entry.name == "rename_existing" && entry.value().eq_ignore_ascii_case(name);
        let named = self.entries.iter().find(is_own).map(|entry| entry.section.clone());
        let renamed = self.entries.iter().find(is_renamed).map(|entry| entry.section.clone());
        let Some(section) = named.clone().or(renamed) else { return Called::Nothing };
        let is_under_way = |entered: &Entered| entered.section == section && !entered.is_plain;
        if named.is_some() && self.entered.iter().any(is_under_way) {
            return self.refused(format_args!("{name}: a macro that is under way is called recursively"));
        }
        if self.entered.len() >= DEEPEST {
            return self.refused(format_args!("{name}: macros call each other more than {DEEPEST} deep"));
        }
        if named.is_none() {
            let existing = name_of(&section).unwrap_or_default().to_owned();
            let lines = format!("{existing} {words}");
            return self.enter(Entered { section, name: existing, lines, taken: 0, is_plain: true, is_sure: true });
        }
        let given = if call.is_code() {
            let words = words.split_ascii_whitespace().filter_map(|word| word.split_at_checked(1));
            words.map(|(letter, value)| (letter.to_uppercase(), value.to_owned())).collect()
        } else {
            command.parameters().map(|(key, value)| (key.to_uppercase(), value.to_owned())).collect::<Vec<_>>()
        };
        match self.render(&section, &given, words) {
            Ok((lines, is_sure)) => {
                self.enter(Entered { section, name: name.to_owned(), lines, taken: 0, is_plain: false, is_sure })
            }
            Err(called) => called,
        }
    }

    fn refused(&self, why: std::fmt::Arguments<'_>) -> Called {
        Called::Refused(self.texts.refused(why))
    }

    /// An error in a template, with its place in the file.
    fn wrong(&self, template: &Entry, error: &::macros::Error) -> Failure {
        let text = told(template, error);
        self.texts.refused(format_args!("{}", text.strip_prefix(&self.folder).unwrap_or(&text)))
    }

    fn enter(&mut self, mut entered: Entered) -> Called {
        entered.is_sure &= self.entered.last().is_none_or(|caller| caller.is_sure);
        let is_sure = entered.is_sure;
        self.entered.push(entered);
        Called::Macro { is_sure }
    }

    /// The lines of a macro, and whether they depend on no state of the machine.
    fn render(&self, section: &str, given: &[(String, String)], raw: &str) -> Result<(String, bool), Called> {
        let template = self.entries.iter().find(|entry| entry.section == section && entry.name == "gcode");
        let Some(template) = template else {
            return Err(self.refused(format_args!("[{section}] has no option gcode")));
        };
        let used: usize = self.entered.iter().map(|entered| entered.lines.len()).sum();
        let (mut memory, mut output) = (vec![0; MEMORY], vec![0; OUTPUT.saturating_sub(used)]);
        let mut machine = machine_of(&self.entries, section, (given, raw), self.status.clone());
        machine.variables_change = self.variables_change;
        let program = ::macros::compile(&mut template.value().bytes(), &mut memory)
            .map_err(|error| Called::Refused(self.wrong(template, &error)))?;
        let rendered = program.render(&mut memory, &mut output, &mut machine);
        let stops =
            machine.said.iter().find(|(action, _)| matches!(action, Action::RaiseError | Action::EmergencyStop));
        if let Some((_, text)) = stops {
            return Err(Called::Unknown(self.texts.refused(format_args!("{text}"))));
        }
        match rendered {
            Ok(length) => Ok((String::from_utf8_lossy(&output[..length]).into_owned(), !machine.depends_on_state)),
            Err(error) => Err(Called::Unknown(self.wrong(template, &error))),
        }
    }

    /// Writes the next line of the macros entered, and its place.
    pub fn line(&mut self, line: &mut LineBytes, place: &mut MacroPlace) -> Called {
        while let Some(innermost) = self.entered.last_mut() {
            let next =
                innermost.lines.lines().enumerate().skip(innermost.taken).find(|(_, text)| !text.trim().is_empty());
            let Some((row, text)) = next else {
                self.entered.pop();
                continue;
            };
            innermost.taken = row + 1;
            let Ok(bytes) = LineBytes::from_slice(text.trim().as_bytes()) else {
                let name = innermost.name.clone();
                self.entered.clear();
                return self.refused(format_args!("{name}: a line has more than {} bytes", line.capacity()));
            };
            *line = bytes;
            place.row = u16::try_from(row + 1).unwrap_or(u16::MAX);
            let fits = innermost.name.floor_char_boundary(place.name.capacity());
            place.name = MacroName::try_from(&innermost.name[..fits]).unwrap_or_default();
            return Called::Macro { is_sure: innermost.is_sure };
        }
        Called::Nothing
    }
}

/// The name of a section's macro.
fn name_of(section: &str) -> Option<&str> {
    let (kind, name) = section.split_once(' ')?;
    (kind == "gcode_macro").then(|| name.trim())
}

/// What `printer` has of a machine that was just switched on.
fn status(config: &MachineConfig) -> Map<String, Value> {
    let mut travel = Travel::default();
    let [least, most] = travel.up_to_date(config, &Tuning::new(config)).ends();
    let bound = |place: f64| if place.is_finite() { place } else { 0.0 };
    let of =
        |places: &PerAxis<f64>| json!([bound(places[Axis::X]), bound(places[Axis::Y]), bound(places[Axis::Z]), 0.0]);
    let zero = json!([0.0, 0.0, 0.0, 0.0]);
    let limits = motion_config(config).map(|motion| motion.limits).ok();
    let acceleration = limits.map_or(0.0, |limits| limits.acceleration.get());
    let speed = limits.and_then(|limits| limits.max_speed).map_or(f64::from(u16::MAX), |speed| speed.get());
    let mut all = json!({
        "toolhead": {
            "homed_axes": "", "axis_minimum": of(&least), "axis_maximum": of(&most), "position": zero,
            "extruder": "extruder", "max_accel": acceleration, "max_velocity": speed,
            "print_time": 0.0, "estimated_print_time": 0.0,
        },
        "gcode_move": {
            "gcode_position": zero, "position": zero, "homing_origin": zero, "absolute_coordinates": true,
            "absolute_extrude": true, "speed_factor": 1.0, "extrude_factor": 1.0,
        },
        "motion_report": { "live_position": zero, "live_velocity": 0.0 },
        "pause_resume": { "is_paused": false },
        "idle_timeout": { "state": "Ready" },
        "print_stats": {
            "state": "standby", "filename": "", "message": "", "total_duration": 0.0, "print_duration": 0.0,
            "filament_used": 0.0, "info": { "current_layer": null, "total_layer": null },
        },
        "virtual_sdcard": { "is_active": false, "progress": 0.0, "file_position": 0, "file_size": 0, "file_path": null },
        "display_status": { "progress": 0.0 },
        "exclude_object": { "objects": [], "current_object": null, "excluded_objects": [] },
        "bed_mesh": { "profile_name": "", "mesh_min": [0.0, 0.0], "mesh_max": [0.0, 0.0] },
        "save_variables": { "variables": {} },
        "webhooks": { "state": "ready" },
    });
    for (_, heater) in config.heaters() {
        let shown = json!({ "temperature": ROOM, "target": 0.0, "power": 0.0, "can_extrude": false });
        let name = match heater.tool_id.0 {
            _ if heater.set_m_code == 140 => "heater_bed".to_owned(),
            0 if heater.set_m_code == 104 => "extruder".to_owned(),
            tool if heater.set_m_code == 104 => format!("extruder{tool}"),
            _ => format!("heater_generic {}", heater.name),
        };
        all[name] = shown;
    }
    for switch in config.switches.iter().filter(|switch| !switch.is_input()) {
        let shown = json!({ "speed": 0.0, "value": 0.0, "rpm": null });
        if switch.input_on_command == Some(gcode::Code::m(106)) {
            all["fan"] = shown.clone();
        }
        for kind in ["fan_generic", "output_pin"] {
            all[format!("{kind} {}", switch.name)] = shown.clone();
        }
    }
    match all {
        Value::Object(members) => members,
        _ => Map::new(),
    }
}

/// Temperature of everything in a machine that was just switched on, degrees Celsius.
const ROOM: f64 = 22.0;
