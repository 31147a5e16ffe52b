//! `velvet macro render`: the lines that a macro makes of parameters and of the printer's state.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use printer_cfg::Setting;
use serde_json::{Map, Value};

use super::check::{is_variable, told};
use super::files::{self, Entry};
use super::state::{Node, State};
use super::{MEMORY, OUTPUT};

/// Prints the lines of a macro; returns whether there was no error.
pub fn render(file: &Path, name: &str, parameters: &[String], state: Option<&Path>) -> Result<bool> {
    let entries = files::read(file)?;
    let entry = find(&entries, name)?;
    let mut memory = vec![0; MEMORY];
    let mut output = vec![0; OUTPUT];
    let mut given = Vec::new();
    for parameter in parameters {
        let Some((name, value)) = parameter.split_once('=') else {
            bail!("{parameter}: a parameter is NAME=VALUE");
        };
        given.push((name.to_uppercase(), value.to_owned()));
    }
    let printer = match state {
        Some(path) => {
            let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
            let value: Value = serde_json::from_str(&text).with_context(|| format!("{} is no JSON", path.display()))?;
            let Value::Object(members) = value else { bail!("{}: the state is an object of objects", path.display()) };
            members
        }
        None => Map::new(),
    };
    let mut machine = machine_of(&entries, &entry.section, (&given, &parameters.join(" ")), printer);
    let program = ::macros::compile(&mut entry.value().bytes(), &mut memory);
    let rendered = program.and_then(|program| program.render(&mut memory, &mut output, &mut machine));
    for (action, text) in &machine.said {
        eprintln!("{action:?}: {text}");
    }
    match rendered {
        Ok(length) => {
            println!("{}", String::from_utf8_lossy(&output[..length]));
            Ok(true)
        }
        Err(error) => {
            eprintln!("{}", told(entry, &error));
            Ok(false)
        }
    }
}

/// The template of a macro. Its name has no case.
fn find<'e>(entries: &'e [Entry], name: &str) -> Result<&'e Entry> {
    let named = |entry: &'e Entry| {
        let (kind, name) = entry.section.split_once(' ')?;
        (matches!(kind, "gcode_macro" | "delayed_gcode") && entry.name == "gcode").then(|| name.trim())
    };
    let found = entries.iter().find(|entry| named(entry).is_some_and(|known| known.eq_ignore_ascii_case(name)));
    let Some(entry) = found else {
        let known: Vec<&str> = entries.iter().filter_map(named).collect();
        bail!("there is no macro {name} with gcode; there are: {}", known.join(", "));
    };
    Ok(entry)
}

/// Values that the macro of a section sees: `printer`, `params`, `rawparams` and its own variables.
pub fn machine_of(
    entries: &[Entry],
    section: &str,
    (given, raw): (&[(String, String)], &str),
    status: Map<String, Value>,
) -> State {
    let mut machine = State::default();
    let mut own = Vec::new();
    let mut printer = Vec::new();
    for variable in entries.iter().filter(|entry| is_variable(entry)) {
        let id = machine.add(Node::Literal(variable.value()));
        let name = variable.name.trim_start_matches("variable_").to_owned();
        if variable.section == section {
            own.push((name.clone(), id));
        }
        match printer.iter_mut().find(|(section, _)| *section == variable.section) {
            Some((_, members)) => members,
            None => {
                printer.push((variable.section.clone(), Vec::new()));
                let last = printer.len() - 1;
                &mut printer[last].1
            }
        }
        .push((name, id));
    }
    let mut printer: Vec<(String, u32)> =
        printer.into_iter().map(|(section, members)| (section, machine.add(Node::Dict(members)))).collect();
    let begin = machine.add(Node::Scalar(Value::Null));
    for (name, value) in status {
        let id = machine.add_json(value);
        printer.retain(|(known, _)| *known != name);
        printer.push((name, id));
    }
    machine.changing = begin..machine.add(Node::Scalar(Value::Null));
    let configfile = configfile(&mut machine, entries);
    if !printer.iter().any(|(name, _)| name == "configfile") {
        printer.push(("configfile".to_owned(), configfile));
    }
    let text = |machine: &mut State, text: &str| machine.add(Node::Scalar(Value::String(text.to_owned())));
    let given = given.iter().map(|(name, value)| (name.clone(), text(&mut machine, value))).collect();
    let (printer, given, raw) =
        (machine.add(Node::Lookup(printer)), machine.add(Node::Dict(given)), text(&mut machine, raw));
    let names = [("printer", printer), ("params", given), ("rawparams", raw)];
    own.extend(names.map(|(name, id)| (name.to_owned(), id)));
    machine.variables = own;
    machine
}

/// Options of a section, and their values' numbers.
type Options = Vec<(String, u32)>;

/// Klipper's own configuration: as it has read it, and as it is written.
fn configfile(machine: &mut State, entries: &[Entry]) -> u32 {
    let mut sections: Vec<(&str, [Options; 2])> = Vec::new();
    for entry in entries {
        let place = sections.iter().position(|(name, _)| *name == entry.section).unwrap_or_else(|| {
            sections.push((&entry.section, Default::default()));
            sections.len() - 1
        });
        let (written, text) = (entry.value(), Node::Scalar(Value::String(entry.value())));
        let ids = [read(&entry.name, &written), text].map(|node| machine.add(node));
        sections[place].1.iter_mut().zip(ids).for_each(|(options, id)| options.push((entry.name.clone(), id)));
    }
    for (name, [settings, _]) in &mut sections {
        for (key, value) in printer_cfg::defaults_of(name) {
            if !settings.iter().any(|(known, _)| known == key) {
                settings.push((key.to_owned(), machine.add(read(key, value))));
            }
        }
    }
    let mut both = [Vec::new(), Vec::new()];
    for (name, kinds) in sections {
        for (all, options) in both.iter_mut().zip(kinds) {
            all.push((name.to_owned(), machine.add(Node::Dict(options))));
        }
    }
    let [settings, config] = both.map(|sections| machine.add(Node::Dict(sections)));
    machine.add(Node::Lookup(vec![("settings".to_owned(), settings), ("config".to_owned(), config)]))
}

/// The value of an option as Klipper reads it.
fn read(key: &str, written: &str) -> Node {
    let mut text = printer_cfg::Scratch::new();
    text.fill(written.bytes());
    match printer_cfg::read_setting(key, &mut text) {
        Setting::Bool(is) => Node::Scalar(Value::Bool(is)),
        Setting::Int(number) => Node::Scalar(number.into()),
        Setting::Float(number) => Node::Scalar(number.into()),
        Setting::List => Node::Literal(text.text().unwrap_or_default().to_owned()),
        Setting::Text => Node::Scalar(Value::String(written.to_owned())),
    }
}
