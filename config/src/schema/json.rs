//! A JSON Schema of the configuration (draft 2020-12), for editors that know such things: a section is an
//! object, an instance an object in it, a setting a number, a boolean or a text.

use super::{Fallback, Form, Instances, Kind, PinRole, SECTIONS, Section, Setting, Support, Unit};
use std::fmt::Write;
use std::format;
use std::string::{String, ToString};
use std::vec::Vec;

/// Pattern of a digital pin's name in the file.
const DIGITAL: &str = "[Pp][A-Ka-k][_.]?(1[0-5]|0?[0-9])[!o^v-]*";
const MOTORS: &str = "^(alpha|beta|gamma|delta|epsilon|zeta)$";
const NAMES: &str = "^(?!common$)[^.=#\\\\[\\\\]]{1,24}$";

/// The whole schema as pretty-printed JSON.
#[must_use]
pub fn json_schema() -> String {
    let mut out = String::from(
        "{\n  \"$schema\": \"https://json-schema.org/draft/2020-12/schema\",\n  \"title\": \"Velvet configuration\",\n  \"description\": \
         \"config.ini as JSON: an object for each [section], in sections with instances an object for each name\",\n  \
         \"type\": \"object\",\n  \"additionalProperties\": false,\n  \"properties\": {\n",
    );
    let sections: Vec<String> = SECTIONS.iter().map(section).collect();
    out += &sections.join(",\n");
    out + "\n  }\n}\n"
}

fn section(section: &Section) -> String {
    let head = format!(
        "    {}: {{\n      \"description\": {},\n      \"type\": \"object\",\n      \"additionalProperties\": false,\n",
        quoted(section.name),
        quoted(section.docs.summary)
    );
    let body = match section.form {
        Form::Plain => properties("      ", section.settings.iter()),
        Form::Keyed(_) => {
            let rows: Vec<String> = section.settings.iter().map(setting).collect();
            format!("      \"patternProperties\": {{\n        \"{NAMES}\": {}\n      }}", rows.concat())
        }
        Form::Named(instances) => named(section, &instances),
    };
    format!("{head}{body}\n    }}")
}

fn named(section: &Section, instances: &Instances) -> String {
    let pattern = if matches!(instances.noun, "motor" | "driver") { MOTORS } else { NAMES };
    let object = |common: bool| {
        let rows = section.settings.iter().filter(|row| row.is_common == common);
        format!(
            "{{\n          \"type\": \"object\",\n          \"additionalProperties\": false,\n{}\n        }}",
            properties("          ", rows)
        )
    };
    let mut out = String::new();
    if section.settings.iter().any(|row| row.is_common) {
        // Writing to a String cannot fail.
        let _ = write!(out, "      \"properties\": {{\n        \"common\": {}\n      }},\n", object(true));
    }
    let _ = write!(out, "      \"patternProperties\": {{\n        \"{pattern}\": {}\n      }}", object(false));
    out
}

fn properties<'a>(margin: &str, rows: impl Iterator<Item = &'a Setting>) -> String {
    let lines: Vec<String> = rows.map(|row| format!("{margin}  {}: {}", quoted(row.key), setting(row))).collect();
    format!("{margin}\"properties\": {{\n{}\n{margin}}}", lines.join(",\n"))
}

/// Returns the JSON of a setting, on a line of its own.
fn setting(row: &Setting) -> String {
    let mut parts = kind(row);
    parts.push(format!("\"description\": {}", quoted(row.docs.summary)));
    if let Fallback::Value(text) = row.fallback()
        && !text.is_empty()
    {
        let value = match row.kind {
            Kind::Bool | Kind::Integer(..) | Kind::Number(..) => text.to_string(),
            _ => quoted(text),
        };
        parts.push(format!("\"default\": {value}"));
    }
    if row.unit != Unit::NONE {
        parts.push(format!("\"x-unit\": {}", quoted(row.unit.text())));
    }
    if let Some((low, high)) = row.typical {
        let name = if row.is_limited { "x-limited-to" } else { "x-typical" };
        parts.push(format!("\"{name}\": [{low}, {high}]"));
    }
    for (name, text) in [("x-v1", row.v1), ("x-klipper", row.docs.klipper)] {
        if !text.is_empty() {
            parts.push(format!("\"{name}\": {}", quoted(text)));
        }
    }
    if *row.support != Support::Now {
        parts.push("\"x-supported\": false".to_string());
    }
    format!("{{ {} }}", parts.join(", "))
}

fn kind(row: &Setting) -> Vec<String> {
    let typed = |name: &str| format!("\"type\": \"{name}\"");
    let pattern = |text: &str| std::vec![typed("string"), format!("\"pattern\": {}", quoted(&format!("^({text})$")))];
    match row.kind {
        Kind::Bool => std::vec![typed("boolean")],
        Kind::Integer((low, high)) => {
            std::vec![typed("integer"), format!("\"minimum\": {low}"), format!("\"maximum\": {high}")]
        }
        Kind::Number((low, high)) => {
            std::vec![typed("number"), format!("\"minimum\": {low}"), format!("\"maximum\": {high}")]
        }
        Kind::Numbers(count) => {
            let number = "[-+]?[0-9.]+([eE][-+]?[0-9]+)?";
            pattern(&format!("|{number}( *, *{number}){{{}}}", count.saturating_sub(1)))
        }
        Kind::Places(most) => {
            let number = "[-+]?[0-9.]+([eE][-+]?[0-9]+)?";
            pattern(&format!("|{number}[, ]+{number}([, ]+{number}[, ]+{number}){{0,{}}}", most.saturating_sub(1)))
        }
        Kind::Word(words) => {
            let words: Vec<String> = words.0.iter().map(|word| quoted(word)).collect();
            std::vec![format!("\"enum\": [{}]", words.join(", "))]
        }
        Kind::Text(longest) => std::vec![typed("string"), format!("\"maxLength\": {longest}")],
        Kind::Command => pattern("|[GMgm][0-9]+(\\.[0-9]+)?"),
        Kind::Registers => pattern("|(0[xX])?[0-9A-Fa-f]{1,5}( *, *(0[xX])?[0-9A-Fa-f]{1,5}){4}"),
        Kind::Axes => pattern("[XYZABCxyzabc]{0,6}"),
        Kind::Voltage => pattern("[Aa][Dd][Cc]3_[0-5]( *, *[0-9.]+)?"),
        Kind::Pin(role) => pattern(&match role {
            PinRole::Output | PinRole::Input | PinRole::Interrupt => format!("|nc|{DIGITAL}"),
            PinRole::Button => format!("|nc|external|{DIGITAL}"),
            PinRole::OutputOrPwm => format!("|nc|{DIGITAL}|[Pp][Ww][Mm][12]_[1-4]"),
            PinRole::Pwm => "|nc|[Pp][Ww][Mm][12]_[1-4]".to_string(),
            PinRole::Thermistor => "|nc|[Aa][Dd][Cc]1_[0-6]".to_string(),
        }),
    }
}

/// A JSON string (RFC 8259, section 7).
pub(crate) fn quoted(text: &str) -> String {
    let mut out = String::from('"');
    for character in text.chars() {
        match character {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            c if (c as u32) < 0x20 => {
                let _ = write!(out, "\\u{:04x}", c as u32);
            }
            c => out.push(c),
        }
    }
    out.push('"');
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const PAGE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/config.schema.json");

    /// `VELVET_WRITE=1 cargo test -p config` writes the file anew.
    #[test]
    fn the_file_in_the_repository_is_this_schema() {
        if std::env::var_os("VELVET_WRITE").is_some() {
            std::fs::write(PAGE, json_schema()).unwrap();
        }
        assert!(
            std::fs::read_to_string(PAGE).unwrap() == json_schema(),
            "docs/config.schema.json is stale; see this test"
        );
    }
}
