//! `velvet macro render`: the lines that a macro makes of parameters and of the printer's state.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, bail};
use serde_json::Value;

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
    let mut machine = machine_of(&entries, entry, parameters, state)?;
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

/// Values that the macro sees: `printer`, `params`, `rawparams` and its own variables.
fn machine_of(entries: &[Entry], entry: &Entry, parameters: &[String], state: Option<&Path>) -> Result<State> {
    let mut machine = State::default();
    let mut own = Vec::new();
    let mut printer = Vec::new();
    for variable in entries.iter().filter(|entry| is_variable(entry)) {
        let id = machine.add(Node::Literal(variable.value()));
        let name = variable.name.trim_start_matches("variable_").to_owned();
        if variable.section == entry.section {
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
    if let Some(path) = state {
        let text = fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
        let value: Value = serde_json::from_str(&text).with_context(|| format!("{} is no JSON", path.display()))?;
        let Value::Object(members) = value else { bail!("{}: the state is an object of objects", path.display()) };
        for (name, value) in members {
            let id = machine.add_json(value);
            printer.retain(|(known, _)| *known != name);
            printer.push((name, id));
        }
    }
    let mut given = Vec::new();
    for parameter in parameters {
        let Some((name, value)) = parameter.split_once('=') else {
            bail!("{parameter}: a parameter is NAME=VALUE");
        };
        let id = machine.add(Node::Scalar(Value::String(value.to_owned())));
        given.push((name.to_uppercase(), id));
    }
    let printer = machine.add(Node::Lookup(printer));
    let given = machine.add(Node::Dict(given));
    let raw = machine.add(Node::Scalar(Value::String(parameters.join(" "))));
    let names = [("printer", printer), ("params", given), ("rawparams", raw)];
    own.extend(names.map(|(name, id)| (name.to_owned(), id)));
    machine.variables = own;
    Ok(machine)
}
