//! The settings reference, generated from the schema.

use super::{Fallback, Form, Kind, PinRole, SECTIONS, Section, Setting, Since, Support};
use std::fmt::Write;
use std::string::{String, ToString};

/// The whole reference as Markdown: a chapter per section, a table row per setting.
#[must_use]
pub fn markdown() -> String {
    let mut page = String::from(
        "# Settings\n\nGenerated from the schema; do not edit. A line is `key = value`, in sections with instances \
         `name.key = value`. `#` starts a comment. A missing line means the default. Look for a setting by its key, by \
         its name in Smoothieware v1 (`alpha_max_rate` is under `<axis>_max_rate`), by the nearest setting of Klipper (units may \
         differ: speeds are mm/s there, and steps_per_mm is worked out from rotation_distance), or by what it is for:\n\n",
    );
    contents(&mut page);
    page +=
        "\n`velvet check FILE` finds what is wrong with a file; `velvet schema` prints this table as a JSON Schema.\n";
    for section in SECTIONS {
        chapter(&mut page, section);
    }
    page
}

/// Sections by what they are for.
#[rustfmt::skip]
const GROUPS: &[(&str, &[&str])] = &[
    ("The board and its consoles", &[
        "general", "system", "update", "consoles", "uart console", "kill button", "safety door", "player",
        "macros", "tool change", "network",
    ]),
    ("Motion", &["motion control", "planner", "conveyor", "input shaper"]),
    ("Kinematics", &[
        "linear delta", "rotary delta", "morgan scara", "corexz", "deltesian", "generic cartesian", "winch",
    ]),
    ("Motors", &[
        "actuator", "tmc2590", "tmc2660", "tmc2130", "tmc5160", "tmc2240", "tmc2208", "tmc2209", "tmc2226",
        "current control",
    ]),
    ("Extruders and heat", &[
        "extruder", "temperature control", "temperature switch", "filament detector", "filament width sensor",
        "filament change",
    ]),
    ("Switches, fans, lights, voltages", &[
        "switch", "fan", "led strip", "pwm1", "pwm2", "voltage monitor", "button box",
    ]),
    ("Homing and probing", &[
        "endstops", "soft endstop", "zprobe", "three point leveling strategy",
        "cartesian grid leveling strategy", "delta grid leveling strategy", "bed mesh",
        "delta calibration strategy", "skew correction", "z alignment", "bed screws",
        "axis twist compensation", "z thermal adjust",
    ]),
    ("Tools", &["laser", "drillingcycles", "lathe", "els"]),
    ("Displays and wheels", &["st7920", "tm1638", "mpg"]),
];

fn contents(page: &mut String) {
    for (group, sections) in GROUPS {
        let links: std::vec::Vec<String> =
            sections.iter().map(|name| std::format!("[{name}](#{})", name.replace(' ', "-"))).collect();
        // Writing to a String cannot fail.
        let _ = writeln!(page, "- {group}: {}", links.join(", "));
    }
}

fn chapter(page: &mut String, section: &Section) {
    // Writing to a String cannot fail.
    let _ = write!(
        page,
        "\n## [{}]\n\n{}\n\n| Key | Type | Default | Unit | Meaning | v1 name | Klipper |\n|---|---|---|---|---|---|---|\n",
        section.name, section.docs.summary
    );
    for setting in section.settings {
        let _ = writeln!(
            page,
            "| `{}` | {} | {} | {} | {} | {} | {} |",
            key(section, setting),
            kind(setting),
            default(setting),
            setting.unit.text(),
            meaning(setting),
            code(setting.v1),
            code(setting.docs.klipper)
        );
    }
    if let Some(example) = super::examples::of(section.name) {
        let _ = write!(page, "\n```ini\n[{}]\n{example}```\n", section.name);
    }
}

fn key(section: &Section, setting: &Setting) -> String {
    match section.form {
        Form::Plain => setting.key.to_string(),
        Form::Keyed(_) => "<name>".to_string(),
        Form::Named(_) if setting.is_common => std::format!("common.{}", setting.key),
        Form::Named(instances) if matches!(instances.noun, "motor" | "driver") => {
            std::format!("<axis>.{}", setting.key)
        }
        Form::Named(_) => std::format!("<name>.{}", setting.key),
    }
}

fn code(text: &str) -> String {
    if text.is_empty() { String::new() } else { std::format!("`{text}`") }
}

/// A bound that only keeps nonsense out is not worth printing.
fn range(low: f64, high: f64) -> String {
    match (low, high) {
        (l, h) if l <= -1e9 && h >= 1e9 => String::new(),
        (0.0, h) if h >= 1e9 => " >= 0".to_string(),
        (l, h) if l > 0.0 && l <= 1e-6 && h >= 1e6 => " > 0".to_string(),
        (l, h) => std::format!(" {l} to {h}"),
    }
}

/// Beyond this the reader asks whether the unit is right.
fn usually(setting: &Setting) -> String {
    let word = if setting.is_limited { "taken as" } else { "usually" };
    setting.typical.map_or_else(String::new, |(low, high)| std::format!(", {word} {low} to {high}"))
}

fn kind(setting: &Setting) -> String {
    match setting.kind {
        Kind::Bool => "true, false".to_string(),
        Kind::Integer((low, high)) => std::format!("whole number {low} to {high}{}", usually(setting)),
        Kind::Number((low, high)) => std::format!("number{}{}", range(*low, *high), usually(setting)),
        Kind::Numbers(count) => std::format!("{count} numbers, commas between"),
        Kind::Places(most) if setting.unit.text().contains(',') => {
            std::format!("up to {most} pairs {}", setting.unit.text())
        }
        Kind::Places(most) => std::format!("up to {most} places X,Y"),
        Kind::Word(words) => words.0.join(", "),
        Kind::Text(longest) => std::format!("text, {longest} characters"),
        Kind::Command => "G or M code".to_string(),
        Kind::Registers => "5 hexadecimal numbers".to_string(),
        Kind::Axes => "axis letters".to_string(),
        Kind::Voltage => "ADC3_0 to ADC3_5, scale".to_string(),
        Kind::Pin(role) => match role {
            PinRole::Output => "output pin",
            PinRole::Input => "input pin",
            PinRole::Button => "input pin or external",
            PinRole::Interrupt => "interrupt input pin",
            PinRole::OutputOrPwm => "output pin or PWM channel",
            PinRole::Pwm => "PWM channel",
            PinRole::Thermistor => "thermistor input",
        }
        .to_string(),
    }
}

fn default(setting: &Setting) -> String {
    let own = match setting.fallback() {
        Fallback::Value(value) => code(value),
        Fallback::Derived => return setting.docs.derived.to_string(),
        Fallback::Required => "must be written".to_string(),
    };
    setting
        .by_name
        .0
        .iter()
        .fold(own, |text, (name, value)| std::format!("{text} {name}: `{value}`"))
        .trim()
        .to_string()
}

fn meaning(setting: &Setting) -> String {
    let mut text = setting.docs.summary.replace('|', "\\|");
    let _ = match setting.support {
        Support::Now => Ok(()),
        Support::NotYet { advice, .. } => write!(text, " **Not supported yet:** {advice}."),
        Support::Needless { why } => write!(text, " **Without effect:** {why}."),
        Support::Dormant => write!(text, " (Not supported yet.)"),
    };
    if setting.docs.since == Since::Velvet {
        text.push_str(" (Velvet only.)");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/settings.md");

    /// `VELVET_WRITE=1 cargo test -p config` writes the page anew.
    #[test]
    fn the_page_in_the_repository_is_this_reference() {
        if std::env::var_os("VELVET_WRITE").is_some() {
            std::fs::write(PAGE, markdown()).unwrap();
        }
        let page = std::fs::read_to_string(PAGE).unwrap();
        let differing = page.lines().zip(markdown().lines()).position(|(page, fresh)| page != fresh);
        assert!(
            page == markdown(),
            "docs/settings.md is stale from line {:?} on; see this test",
            differing.map(|n| n + 1)
        );
    }

    #[test]
    fn every_section_is_in_one_group() {
        let mut grouped: std::vec::Vec<_> = GROUPS.iter().flat_map(|(_, sections)| sections.iter().copied()).collect();
        let mut all: std::vec::Vec<_> = SECTIONS.iter().map(|section| section.name).collect();
        grouped.sort_unstable();
        all.sort_unstable();
        assert_eq!(grouped, all);
    }

    #[test]
    fn every_setting_is_in_the_reference_with_its_meaning() {
        let page = markdown();
        for section in SECTIONS {
            for setting in section.settings {
                let row = page.lines().find(|line| {
                    line.starts_with(&std::format!("| `{}` |", key(section, setting)))
                        && line.contains(&meaning(setting))
                });
                assert!(row.is_some(), "[{}] {}", section.name, setting.key);
            }
        }
    }
}
