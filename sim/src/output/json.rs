//! JSON text for the few shapes a summary has.

use std::fmt::Write;

/// Returns a text as a JSON string.
pub fn string(text: &str) -> String {
    let mut out = String::from("\"");
    for letter in text.chars() {
        match letter {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            letter if u32::from(letter) < 0x20 => {
                // Writing to a string cannot fail.
                let _ = write!(out, "\\u{:04x}", u32::from(letter));
            }
            letter => out.push(letter),
        }
    }
    out.push('"');
    out
}

/// Returns a number with so many decimals; null if it is not finite.
pub fn number(value: f64, decimals: usize) -> String {
    if value.is_finite() { format!("{value:.decimals$}") } else { "null".into() }
}

/// Returns a list of JSON strings.
pub fn strings(list: &[String]) -> String {
    let items: Vec<String> = list.iter().map(|text| string(text)).collect();
    format!("[{}]", items.join(", "))
}

/// Returns an object on a single line, its values JSON already.
pub fn object(members: &[(&str, String)]) -> String {
    let members: Vec<String> = members.iter().map(|(name, value)| format!("{}: {value}", string(name))).collect();
    format!("{{{}}}", members.join(", "))
}

/// Returns an object with a member on each line, its values JSON already.
pub fn lines(members: &[(String, String)], indent: &str) -> String {
    if members.is_empty() {
        return "{}".into();
    }
    let members: Vec<String> =
        members.iter().map(|(name, value)| format!("{indent}  {}: {value}", string(name))).collect();
    format!("{{\n{}\n{indent}}}", members.join(",\n"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_escaped_and_what_is_no_number_is_null() {
        assert_eq!(string("a\"b\\c\nd\u{1}"), "\"a\\\"b\\\\c\\nd\\u0001\"");
        assert_eq!(number(f64::NAN, 2), "null");
        assert_eq!(number(1.0, 2), "1.00");
    }
}
