//! Reads a line `key = value`: the setting it names, the instance it belongs to, the value it gives.

use super::{Current, Reader};
use crate::diagnostic::Severity;
use crate::ledger::{MAX_WRITTEN, Path, Span};
use crate::machine::{BoardId, DriverKind};
use crate::module::Module;
use crate::report::At;
use crate::schema::{
    CannotCreate, Fallback, Form, Instances, Kind, SECTIONS, Section, Setting, Support, UNREAD, section,
};
use crate::setting::flaw::{Flaw, List};
use crate::setting::value::{self, Value};
use crate::suggest;
use crate::text::{cut, nearest};
use units::Actuator;

/// The key of an instance's own switch.
const ENABLE: &str = "enable";

/// The name under which the schema keeps defaults of that board.
const TMC2660_BOARD: &str = "tmc2660 board";

impl Reader<'_> {
    pub(super) fn read_setting(&mut self, line: &str, key: &str, value: &str) {
        let at = self.span(line, key);
        match self.current {
            Current::Unknown => {}
            Current::Nothing => {
                let reason = format_args!("'{key}' stands before any [section]");
                let fix = format_args!("{}", suggest::Home(key));
                self.reporter.report(Severity::Error, At::new(at, key, Module::MACHINE), reason, fix);
            }
            Current::Known(index, section) => {
                let Some((setting, place)) = self.resolve(index, section, line, key) else { return };
                let Some(row) = section.settings.get(setting) else { return };
                let path = Path::new(index, setting, place);
                let value_span = if value.is_empty() { at } else { self.span(line, value) };
                let key = match section.form {
                    // Nothing keeps the names of instances to come.
                    Form::Named(instances) if instances.noun == UNREAD => cut(format_args!("[{}] {key}", section.name)),
                    _ => path.text(self.config),
                };
                self.take_value(path, row, value, (at, value_span), &key);
            }
        }
    }

    /// The setting a key names, and the place of its instance, which is made when it is new.
    fn resolve(&mut self, index: usize, section: &'static Section, line: &str, key: &str) -> Option<(usize, usize)> {
        let at = self.span(line, key);
        match section.form {
            Form::Plain => Some((self.find_key(section, at, key, key, false)?, 0)),
            Form::Keyed(instances) => Some((0, self.find_instance(index, section, &instances, at, key)?)),
            Form::Named(instances) => {
                let Some((name, rest)) = key.split_once('.') else {
                    let reason = format_args!("'{key}' does not say which {} it is for", instances.noun);
                    let owner = if section.position(key, true).is_some() { "common" } else { "name" };
                    let fix = match owner {
                        "common" => format_args!("write common.{key} = ..."),
                        _ => format_args!("write name.{key} = ..., with the name of the {}", instances.noun),
                    };
                    self.reporter.report(Severity::Error, At::new(at, key, Module::whole(section)), reason, fix);
                    return None;
                };
                let is_common = name == "common";
                let Some(setting) = self.find_key(section, at, key, rest, is_common) else {
                    if !is_common && nearest(rest, [ENABLE].into_iter()).is_some() {
                        self.mark_misspelt_enable(index, section, &instances, at, name);
                    }
                    return None;
                };
                if is_common {
                    return Some((setting, 0));
                }
                Some((setting, self.find_instance(index, section, &instances, at, name)?))
            }
        }
    }

    /// Handles a misspelt `enable` key: nobody knows whether the instance is enabled, so it stays off and is
    /// listed as off.
    fn mark_misspelt_enable(
        &mut self,
        index: usize,
        section: &'static Section,
        instances: &Instances,
        at: Span,
        name: &str,
    ) {
        if let Some(setting) = section.position(ENABLE, false)
            && let Some(place) = self.find_instance(index, section, instances, at, name)
        {
            self.ledger.mark_unreadable(Path::new(index, setting, place));
        }
    }

    fn find_key(
        &mut self,
        section: &'static Section,
        at: Span,
        whole: &str,
        key: &str,
        is_common: bool,
    ) -> Option<usize> {
        let found = section.position(key, is_common);
        if found.is_none() && (suggest::is_supported(section) || self.ledger.tell_once(section.name)) {
            let reason = format_args!("[{}] has no setting '{key}'", section.name);
            let (severity, fix) = suggest::key(section, key, is_common);
            let name = whole.split_once('.').map_or("", |(name, _)| name);
            let at = At::new(at, whole, Module::new(section, name));
            self.reporter.report(severity, at, reason, format_args!("{fix}"));
        }
        found
    }

    fn find_instance(
        &mut self,
        index: usize,
        section: &'static Section,
        instances: &Instances,
        at: Span,
        name: &str,
    ) -> Option<usize> {
        if let Some(place) = (instances.find)(self.config, name) {
            return Some(place);
        }
        let noun = instances.noun;
        let found_at = At::new(at, name, Module::new(section, name));
        match (instances.create)(self.config, name) {
            Ok(place) => {
                self.default_instance(index, section, place, name);
                return Some(place);
            }
            Err(CannotCreate::Full(most)) => {
                let reason = format_args!("there is no room for {noun} '{name}': Velvet takes {most}");
                let fix = format_args!("delete those that are not enabled");
                self.reporter.report(Severity::Error, found_at, reason, fix);
            }
            Err(CannotCreate::UnknownName(names)) => {
                let reason = format_args!("there is no {noun} '{name}'");
                match nearest(name, names.iter().copied()) {
                    Some(meant) => {
                        self.reporter.report(Severity::Error, found_at, reason, format_args!("did you mean {meant}?"));
                    }
                    None => {
                        self.reporter.report(Severity::Error, found_at, reason, format_args!("write {}", List(names)));
                    }
                }
            }
            Err(CannotCreate::NameTooLong) => {
                let reason = format_args!("the name '{name}' is longer than 24 characters");
                self.reporter.report(Severity::Error, found_at, reason, format_args!("shorten it"));
            }
        }
        None
    }

    fn take_value(&mut self, path: Path, row: &'static Setting, text: &str, (at, value_span): (Span, Span), key: &str) {
        match value::parse(&row.kind, text) {
            Err(flaw) => {
                self.ledger.mark_unreadable(path);
                let reason = format_args!("{}", flaw.reason());
                let at = At::new(value_span, key, path.module(self.config));
                match (flaw, row.typical) {
                    (Flaw::OutOfRange(value, (_, high)), Some(_)) if value > high && !row.is_limited => {
                        let fix = suggest::OtherUnit { unit: row.unit.text(), value, is_low: false };
                        self.reporter.report(Severity::Error, at, reason, format_args!("{fix}"));
                    }
                    _ => {
                        let fix = format_args!("{}", flaw.fix());
                        self.reporter.report(Severity::Error, at, reason, fix);
                    }
                }
            }
            Ok(value) => {
                let value = self.take_as(path, row, (key, text), value, value_span);
                self.object_to(path, row, key, &value, value_span);
                self.doubt(path, row, key, &value, value_span);
                self.keep(path, row, &value);
                // Instances of a section that is still to come are not told apart.
                let has_place = *row.support == Support::Now
                    || row.is_common
                    || path.section().is_some_and(|section| section.instances().is_none());
                if !has_place {
                    return;
                }
                match self.ledger.write(path, value_span) {
                    Ok(Some(before)) => {
                        let reason = format_args!("is set before, in line {}; this one counts", before.line);
                        let at = At::new(at, key, Module::MACHINE);
                        self.reporter.report(Severity::Warning, at, reason, format_args!("delete one of them"));
                    }
                    Err(_) => {
                        let reason = format_args!("the file sets more than {MAX_WRITTEN} settings");
                        let at = At::new(at, key, Module::MACHINE);
                        self.reporter.report(Severity::Error, at, reason, format_args!("delete what is not enabled"));
                    }
                    Ok(None) => {}
                }
            }
        }
    }

    /// Notes a value that asks for a missing function, and reports a setting that no longer has a meaning.
    fn object_to(&mut self, path: Path, row: &Setting, key: &str, value: &Value<'_>, span: Span) {
        let is_default = match row.fallback() {
            Fallback::Value(text) => value::parse(&row.kind, text).is_ok_and(|default| default == *value),
            // A value derived from other settings is never an enabled extra.
            Fallback::Derived => *value == Value::Bool(false),
            Fallback::Required => false,
        };
        match *row.support {
            _ if is_default => {}
            Support::Needless { why } => {
                let at = At::new(span, key, path.module(self.config));
                let fix = format_args!("delete the line: {why}");
                self.reporter.report(Severity::Warning, at, format_args!("has no effect"), fix);
            }
            Support::Now | Support::Dormant => {}
            Support::NotYet { severity, advice } => {
                // Whether it is asked for in earnest, the whole file shows: its function may be disabled.
                let is_nameless = path.section().and_then(Section::instances).is_some_and(|i| i.noun == UNREAD);
                if is_nameless || !self.ledger.wish(path, span) {
                    let at = At::new(span, key, path.module(self.config));
                    self.reporter.not_supported(severity, at, advice);
                }
            }
        }
    }

    /// The value that a number is taken as, and a warning when that is another one: Smoothieware cuts
    /// fractions of whole numbers, and takes some values that are beyond what Velvet can do.
    fn take_as<'t>(
        &mut self,
        path: Path,
        row: &Setting,
        (key, text): (&str, &str),
        value: Value<'t>,
        span: Span,
    ) -> Value<'t> {
        let Value::Integer(read) = value else { return value };
        let within = row.typical.filter(|_| row.is_limited).map(|&(low, high)| (low as i64, high as i64));
        let taken = within.map_or(read, |(low, high)| units::within(read, low, high));
        let why = match within.filter(|_| taken != read) {
            Some((low, high)) => cut(format_args!("Velvet can do {low} to {high}")),
            None if value::has_fraction(text) => cut::<48>(format_args!("it is a whole number")),
            None => return value,
        };
        self.ledger.doubt(path);
        let at = At::new(span, key, path.module(self.config));
        let reason = format_args!("{text} is taken as {taken}: {why}");
        self.reporter.report(Severity::Warning, at, reason, format_args!("write {taken}"));
        Value::Integer(taken)
    }

    /// Points out a value that is probably meant in another unit.
    fn doubt(&mut self, path: Path, row: &Setting, key: &str, value: &Value<'_>, span: Span) {
        let value = match *value {
            Value::Number(value) => value,
            Value::Integer(value) => value as f64,
            _ => return,
        };
        // Zero and less mean "none" wherever they are allowed.
        let Some((low, high)) = row
            .typical
            .copied()
            .filter(|&(low, high)| value > 0.0 && !(low..=high).contains(&value) && !row.is_limited)
        else {
            return;
        };
        let unit = row.unit.text();
        let (much, bound) = if value < low { ("less", low) } else { ("more", high) };
        let fix = suggest::OtherUnit { unit, value, is_low: value < low };
        let extreme = if value < low { "at least" } else { "at most" };
        let reason = format_args!("{value} {unit} is much {much} than usual, which is {extreme} {bound} {unit}");
        self.ledger.doubt(path);
        self.reporter.report(Severity::Warning, At::new(span, key, Module::MACHINE), reason, format_args!("{fix}"));
    }

    fn keep(&mut self, path: Path, row: &Setting, value: &Value<'_>) {
        if let Some(section) = path.section() {
            (section.store)(self.config, usize::from(path.place), usize::from(path.setting), value);
        }
        if let (Kind::Pin(..), Value::Pin(pin)) = (&row.kind, value)
            && *row.support == Support::Now
        {
            self.ledger.ask(path, *pin);
        }
    }

    pub(super) fn fill_in_defaults(&mut self) {
        for (index, section) in SECTIONS.iter().enumerate() {
            match section.form {
                Form::Plain | Form::Named(_) => {
                    let is_plain = section.instances().is_none();
                    for (setting, row) in
                        section.settings.iter().enumerate().filter(|(_, row)| is_plain || row.is_common)
                    {
                        self.default_setting(Path::new(index, setting, 0), row, "");
                    }
                }
                Form::Keyed(instances) => {
                    for (name, _) in section.settings.iter().flat_map(|row| row.by_name.0) {
                        if let Ok(place) = (instances.create)(self.config, name) {
                            self.default_instance(index, section, place, name);
                        }
                    }
                }
            }
        }
    }

    /// On-board drivers that the file does not describe are those that the board has, with its sense
    /// resistors. A motor whose driver is described in the section of the other kind has the wrong kind,
    /// which is an error.
    pub(super) fn assume_drivers(&mut self) {
        for motor in Actuator::ALL.into_iter().filter(|motor| crate::board::stall_pin(*motor).is_some()) {
            let config = &self.config;
            let kind = config.actuators[motor].driver;
            let is_described = [&config.tmc2590, &config.tmc2660].iter().any(|family| family.axes[motor].present);
            if !config.actuators[motor].present || !kind.is_on_board() || is_described {
                continue;
            }
            let name = if kind == DriverKind::Tmc2590 { "tmc2590" } else { "tmc2660" };
            let Some((index, section)) = section(name) else { continue };
            let Some(Ok(place)) = section.instances().map(|instances| (instances.create)(self.config, motor.name()))
            else {
                continue;
            };
            self.default_instance(index, section, place, motor.name());
            let config = &mut self.config;
            let family = if kind == DriverKind::Tmc2590 { &mut config.tmc2590 } else { &mut config.tmc2660 };
            family.axes[motor].is_assumed = true;
        }
    }

    fn default_instance(&mut self, index: usize, section: &Section, place: usize, name: &str) {
        for (setting, row) in section.settings.iter().enumerate().filter(|(_, row)| !row.is_common) {
            self.default_setting(Path::new(index, setting, place), row, name);
        }
    }

    fn default_setting(&mut self, path: Path, row: &'static Setting, instance: &str) {
        let of_the_board = self.board == BoardId::Prime2660 && !row.by_name.0.iter().any(|(name, _)| *name == instance);
        let by_board =
            row.by_name.0.iter().find(|(name, _)| of_the_board && *name == TMC2660_BOARD).map(|&(_, text)| text);
        let Some(text) = by_board.or_else(|| row.default_for(instance)) else { return };
        // An empty default of a word or a number stands for "not set".
        if let Ok(value) = value::parse(&row.kind, text) {
            self.keep(path, row, &value);
        }
    }
}
