//! State of a migration: the lines made so far, the account, the places given out; and what rules do with it.

use std::collections::{BTreeMap, BTreeSet};

use config::BoardId;

use super::super::ini;
use super::account::{Account, Class, Verdict};
use super::pins::{Aliases, Pin};
use super::source::{Entry, Section, Source, number};
use super::wiring::{Place, Role, Wiring};

/// Setting of the new file: section, instance, key.
pub type Target<'t> = (&'static str, &'t str, &'t str);

/// Drivers of the board that a file is migrated to.
#[derive(Clone, Copy, Debug)]
pub struct Board {
    /// Section of its drivers.
    pub section: &'static str,
    /// Sense resistors, mOhm.
    pub sense_resistor: &'static str,
    /// Greatest peak current with these, A.
    pub most_amps: f64,
}

impl Board {
    /// Returns the drivers of a board.
    pub const fn new(id: BoardId) -> Self {
        match id {
            BoardId::Prime2590 => Self { section: "tmc2590", sense_resistor: "50", most_amps: 5.5 },
            BoardId::Prime2660 => Self { section: "tmc2660", sense_resistor: "100", most_amps: 2.8 },
        }
    }
}

/// Migration under way.
pub struct Migration<'a> {
    pub board: Board,
    pub source: &'a Source,
    pub aliases: Aliases,
    /// Sections whose own comments have been written.
    noted: BTreeSet<usize>,
    pub account: Account,
    pub entries: Vec<ini::Entry>,
    pub to_do: Vec<String>,
    pub wiring: Wiring,
    /// Motors by the section of the old file: `stepper_x` is `alpha`.
    pub motors: BTreeMap<String, &'static str>,
    /// Motors that further ones copy, by the section of these, of generic kinematics.
    pub slaves: BTreeMap<String, &'static str>,
    /// Temperature controls by the section of the old file: `heater_bed` is `bed`.
    pub heaters: BTreeMap<String, String>,
}

impl<'a> Migration<'a> {
    /// Begins to migrate a file to a board.
    pub fn new(source: &'a Source, board: BoardId) -> Self {
        Self {
            board: Board::new(board),
            source,
            aliases: Aliases::of(source),
            noted: BTreeSet::new(),
            account: Account::new(source),
            entries: Vec::new(),
            to_do: Vec::new(),
            wiring: Wiring::default(),
            motors: BTreeMap::new(),
            slaves: BTreeMap::new(),
            heaters: BTreeMap::new(),
        }
    }

    /// Returns a section by its number.
    pub fn section(&self, number: usize) -> &'a Section {
        &self.source.sections[number]
    }

    /// Returns the number of a section by its whole name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.source.sections.iter().position(|section| section.name == name)
    }

    fn option(&self, section: usize, name: &str) -> Option<(usize, &'a Entry)> {
        self.section(section).options.iter().enumerate().find(|(_, entry)| entry.name == name)
    }

    /// Gives a verdict on an option, if it is there and has none yet.
    pub fn judge(&mut self, section: usize, option: &str, verdict: Verdict) {
        let Some((index, _)) = self.option(section, option) else { return };
        if let Some(place) = self.account.at(section, Some(index)) {
            place.get_or_insert(verdict);
        }
    }

    /// Gives a verdict on a section itself, if it has none yet.
    pub fn judge_section(&mut self, section: usize, verdict: Verdict) {
        if let Some(place) = self.account.at(section, None) {
            place.get_or_insert(verdict);
        }
    }

    /// Gives all options without a verdict this one, and the section too.
    pub fn judge_rest(&mut self, section: usize, verdict: &Verdict) {
        for option in 0..self.section(section).options.len() {
            if let Some(place) = self.account.at(section, Some(option)) {
                place.get_or_insert_with(|| verdict.clone());
            }
        }
        self.judge_section(section, verdict.clone());
    }

    /// Gives an option the verdict that nothing need become of it.
    pub fn needless(&mut self, section: usize, option: &str, why: &str) {
        self.judge(section, option, Verdict::needless(why));
    }

    /// Gives an option the verdict that Velvet cannot follow it.
    pub fn refuse(&mut self, section: usize, option: &str, why: &str, nearest: &str) {
        self.judge(section, option, Verdict::refused(why, nearest));
    }

    /// Returns whether an option has its verdict.
    pub fn is_judged(&mut self, section: usize, option: &str) -> bool {
        let Some((index, _)) = self.option(section, option) else { return false };
        self.account.at(section, Some(index)).is_some_and(|verdict| verdict.is_some())
    }

    /// Notes that an option went into a setting, which another option or [`Migration::put`] wrote.
    pub fn merged(&mut self, section: usize, option: &str, reason: &str, becomes: &str) {
        let Some((index, _)) = self.option(section, option) else { return };
        let Some(place) = self.account.at(section, Some(index)) else { return };
        let verdict = place.get_or_insert_with(|| Verdict::new(Class::Converted, reason));
        if verdict.class == Class::Converted && !becomes.is_empty() {
            verdict.becomes.push(becomes.to_owned());
        }
    }

    /// Writes a setting that comes from an option; where the option is missing, one that it stands for by
    /// Klipper's default.
    pub fn put(&mut self, section: usize, option: &str, target: Target<'_>, value: impl Into<String>) {
        self.put_for(section, option, target, value, "");
    }

    /// Writes a setting that comes from an option, with a reason for the report.
    pub fn put_for(
        &mut self,
        section: usize,
        option: &str,
        target: Target<'_>,
        value: impl Into<String>,
        reason: &str,
    ) {
        let value = value.into();
        let (of, found) = (self.section(section), self.option(section, option).map(|(_, entry)| entry));
        let mut entry = new_entry(target, value.clone());
        entry.comment = match found {
            Some(found) if !found.comment.is_empty() => found.comment.clone(),
            Some(_) => format!("was [{}] {option}", of.name),
            None => format!("as [{}] {option} is without a line", of.name),
        };
        let is_first = !self.entries.iter().any(|known| known.comment == entry.comment && !known.above.is_empty());
        entry.above = found.filter(|_| is_first).map(|found| notes(&found.above)).unwrap_or_default();
        if found.is_some() && self.noted.insert(section) {
            entry.above.splice(..0, notes(&of.above));
        }
        let becomes = format!("[{}] {} = {}", entry.section, entry.name(), value);
        self.add(entry);
        self.merged(section, option, reason, &becomes);
    }

    /// Writes a setting that no single option stands for.
    pub fn write(&mut self, target: Target<'_>, value: impl Into<String>, comment: impl Into<String>) {
        let mut entry = new_entry(target, value.into());
        entry.comment = comment.into();
        self.add(entry);
    }

    fn add(&mut self, entry: ini::Entry) {
        let same = |known: &ini::Entry| {
            (known.section, &known.instance, &known.key) == (entry.section, &entry.instance, &entry.key)
        };
        self.entries.retain(|known| !same(known));
        self.entries.push(entry);
    }

    /// Returns the value of a setting written so far.
    pub fn written(&self, target: Target<'_>) -> Option<&str> {
        let same = |known: &&ini::Entry| (known.section, &*known.instance, &*known.key) == target;
        self.entries.iter().find(same).map(|entry| entry.value.as_str())
    }

    /// Returns the name for an instance of a section's label that nothing in these sections has yet.
    pub fn fresh(&self, within: &[&str], label: &str) -> String {
        let plain = instance(label);
        let is_taken = |name: &str| self.entries.iter().any(|e| within.contains(&e.section) && e.instance == name);
        let numbered = |number: usize| format!("{}_{number}", plain.chars().take(21).collect::<String>());
        let mut names = std::iter::once(plain.clone()).chain((2..100).map(numbered));
        let is_heat = within.contains(&"temperature control");
        let is_reserved = |name: &str| name == "common" || is_heat && BUILT_IN.contains(&name);
        names.find(|name| !is_taken(name) && !is_reserved(name)).unwrap_or(plain)
    }

    /// Puts an item on the list of work, once.
    pub fn ask(&mut self, text: impl Into<String>) {
        let text = text.into();
        if !self.to_do.contains(&text) {
            self.to_do.push(text);
        }
    }

    /// Returns an option's number; one that is no number is refused.
    pub fn number(&mut self, section: usize, option: &str) -> Option<f64> {
        let (_, entry) = self.option(section, option)?;
        let value = number(&entry.value);
        if value.is_none() {
            self.refuse(section, option, "this is no number", "correct it");
        }
        value
    }

    /// Writes a number times a factor.
    pub fn scaled(&mut self, section: usize, option: &str, target: Target<'_>, factor: f64) {
        if let Some(value) = self.number(section, option) {
            self.put(section, option, target, text(value * factor));
        }
    }

    /// Returns the pin of an option.
    pub fn pin(&self, section: usize, option: &str) -> Option<Pin> {
        self.aliases.pin(&self.option(section, option)?.1.value)
    }

    /// Finds a place for what hangs on an option's pin; without one the option is refused.
    pub fn place(&mut self, section: usize, option: &str, role: Role, what: &str) -> Option<(Place, Pin)> {
        let (_, entry) = self.option(section, option)?;
        let Some(pin) = self.aliases.pin(&entry.value) else {
            self.refuse(section, option, "this is no pin", "correct it");
            return None;
        };
        let who = &self.section(section).name;
        if let Some(other) = self.wiring.own(&pin.id(), who) {
            let why = format!("[{other}] has this pin too");
            self.refuse(section, option, &why, "give one of them a pin of the Prime in config.ini");
            return None;
        }
        let Some(place) = self.wiring.take(role) else {
            let why = format!("the Prime has no place left for the {what}");
            self.refuse(section, option, &why, "docs/hardware.md lists its pins");
            return None;
        };
        let was_low = pin.is_inverted && matches!(role, Role::Load | Role::Hotend | Role::Bed);
        let low = if was_low { "was active low on the old board" } else { "" };
        let remarks: Vec<&str> = [place.remark, low].into_iter().filter(|remark| !remark.is_empty()).collect();
        self.wiring.note(format!("{what} of [{who}]"), &entry.value, place.pin, place.label, &remarks.join("; "));
        Some((place, pin))
    }
}

/// Temperature controls that rules name themselves.
const BUILT_IN: [&str; 5] = ["hotend", "hotend2", "hotend3", "bed", "board"];

/// Reason of what the board reads from printer.cfg itself.
pub const KEPT: &str = "kept: read on the board from printer.cfg";

fn new_entry((section, instance, key): Target<'_>, value: String) -> ini::Entry {
    let (instance, key) = (instance.to_owned(), key.to_owned());
    ini::Entry { section, instance, key, value, ..ini::Entry::default() }
}

/// Returns a number as the new file writes it: all digits that it has.
pub fn text(value: f64) -> String {
    // An integer after a division by a binary fraction may come out as -0.
    if value == 0.0 { "0".to_owned() } else { value.to_string() }
}

/// Returns the comment lines that say something: not rulers, nor settings switched off.
fn notes(lines: &[String]) -> Vec<String> {
    let is_setting = |line: &&String| {
        let name = line.split([':', '=']).next().unwrap_or("");
        name.len() < line.len() && !name.trim().contains(' ')
    };
    let is_ruler = |line: &&String| !line.contains(char::is_alphanumeric);
    lines.iter().filter(|line| !is_setting(line) && !is_ruler(line)).cloned().collect()
}

/// Returns a name that the new file takes for an instance: letters, digits, underscores; short.
pub fn instance(name: &str) -> String {
    let plain = name.chars().map(|c| if c.is_ascii_alphanumeric() { c.to_ascii_lowercase() } else { '_' });
    plain.take(24).collect()
}
