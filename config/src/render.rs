//! Findings for people and for programs, on the host.

use crate::diagnostic::Diagnostic;
use crate::report::Summary;
use crate::schema::quoted;
use std::fmt::Write;
use std::string::{String, ToString};

/// Renders a finding as a compiler would: place, source line, underline, help.
///
/// ```text
/// fatal: [planner] junction_deviation: 'abc' is not a number
///   --> config.ini:3:22
///    |
///  3 | junction_deviation = abc
///    |                      ^^^
///    = help: write only the number, without unit
/// ```
#[must_use]
pub fn render(finding: &Diagnostic, file: &str, text: &str) -> String {
    let mut out = String::from(finding.severity.word());
    if finding.names_key() {
        out += ": ";
        out += &finding.key;
    }
    // Writing to a String cannot fail, here and below.
    let _ = writeln!(out, ": {}", finding.reason);
    let number = finding.line.to_string();
    let margin = " ".repeat(number.len());
    match (finding.line as usize).checked_sub(1).and_then(|index| text.lines().nth(index)) {
        None => {
            let _ = writeln!(out, " {margin}--> {file}");
        }
        Some(line) => {
            let (before, marked) = place(line, finding);
            let _ = writeln!(out, " {margin}--> {file}:{number}:{}", finding.column);
            let _ = writeln!(out, " {margin} |\n {number} | {}", line.replace('\t', " "));
            let _ = writeln!(out, " {margin} | {}{}", " ".repeat(before), "^".repeat(marked));
        }
    }
    if !finding.fix.is_empty() {
        let _ = writeln!(out, " {margin} = help: {}", finding.fix);
    }
    if !finding.off.is_empty() {
        let _ = writeln!(out, " {margin} = stays off: {}", finding.off);
    }
    out
}

/// Characters before the underline, and under it. The finding counts bytes.
fn place(line: &str, finding: &Diagnostic) -> (usize, usize) {
    let start = usize::from(finding.column).saturating_sub(1).min(line.len());
    let end = (start + usize::from(finding.length)).min(line.len());
    let characters = |range: std::ops::Range<usize>| String::from_utf8_lossy(&line.as_bytes()[range]).chars().count();
    (characters(0..start), characters(start..end).max(1))
}

/// All findings and a last line with their number.
#[must_use]
pub fn render_all(findings: &[Diagnostic], summary: Summary, file: &str, text: &str) -> String {
    let mut out: String = findings.iter().map(|finding| render(finding, file, text) + "\n").collect();
    let plural = |count: u32, word: &str| std::format!("{count} {word}{}", if count == 1 { "" } else { "s" });
    let mut counts: std::vec::Vec<String> = std::vec::Vec::new();
    for (count, word) in [(summary.fatals, "fatal error"), (summary.errors, "error"), (summary.warnings, "warning")] {
        if count > 0 {
            counts.push(plural(count, word));
        }
    }
    let mut off: std::vec::Vec<&str> = std::vec::Vec::new();
    for part in findings.iter().flat_map(|finding| finding.off.split(" and ")) {
        if !part.is_empty() && !off.contains(&part) {
            off.push(part);
        }
    }
    let outcome = match (summary.fatals, summary.errors) {
        (0, 0) => String::new(),
        (0, _) => std::format!("; the machine starts without {}", off.join(", ")),
        _ => "; the machine does not start".into(),
    };
    let _ = match summary.total() {
        0 => writeln!(out, "{file}: no findings"),
        _ => writeln!(out, "{file}: {}{outcome}", counts.join(", ")),
    };
    out
}

/// The findings as one JSON object: `file`, `usable` (it starts), `fatals`, `errors`, `warnings`, `findings`.
#[must_use]
pub fn to_json(findings: &[Diagnostic], summary: Summary, file: &str) -> String {
    let list: std::vec::Vec<String> = findings
        .iter()
        .map(|finding| {
            std::format!(
                "{{\"severity\":\"{}\",\"line\":{},\"column\":{},\"length\":{},\"key\":{},\"reason\":{},\"fix\":{},\"off\":{}}}",
                finding.severity.word(),
                finding.line,
                finding.column,
                finding.length,
                quoted(&finding.key),
                quoted(&finding.reason),
                quoted(&finding.fix),
                quoted(&finding.off)
            )
        })
        .collect();
    std::format!(
        "{{\"file\":{},\"usable\":{},\"fatals\":{},\"errors\":{},\"warnings\":{},\"findings\":[{}]}}",
        quoted(file),
        summary.is_usable(),
        summary.fatals,
        summary.errors,
        summary.warnings,
        list.join(",")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{BoardId, parse};
    use std::vec::Vec;

    fn findings(text: &str) -> (Vec<Diagnostic>, Summary) {
        let mut findings: Vec<Diagnostic> = Vec::new();
        let (_, summary) = parse(text.as_bytes(), BoardId::Prime2590, &mut findings);
        (findings, summary)
    }

    #[test]
    fn a_finding_points_at_its_value() {
        let text = "# printer\n[planner]\njunction_deviation = abc # mm\n";
        let (findings, _) = findings(text);
        let expected = "\
fatal: [planner] junction_deviation: 'abc' is not a number
  --> config.ini:3:22
   |
 3 | junction_deviation = abc # mm
   |                      ^^^
   = help: write only the number, without unit
";
        assert_eq!(render(&findings[0], "config.ini", text), expected);
    }

    #[test]
    fn a_finding_about_something_missing_names_the_file_only() {
        let (findings, summary) = findings("");
        let missing = findings.iter().find(|finding| finding.line == 0).unwrap();
        assert!(render(missing, "config.ini", "").contains("\n  --> config.ini\n"));
        assert!(
            render_all(&findings, summary, "config.ini", "")
                .ends_with("config.ini: 3 fatal errors; the machine does not start\n")
        );
    }

    #[test]
    fn json_escapes_what_the_file_may_hold() {
        let (findings, summary) = findings("[planner]\njunction_deviation = \"\\\t\u{1}ü\n");
        let json = to_json(&findings[..1], summary, "a\"b.ini");
        assert!(json.starts_with("{\"file\":\"a\\\"b.ini\",\"usable\":false,\"fatals\":"), "{json}");
        assert!(json.contains("\"reason\":\"'\\\"\\\\\\u0009\\u0001ü' is not a number\""), "{json}");
    }

    #[test]
    fn no_text_makes_rendering_fail() {
        for text in ["[a", "ü = 1\n[planner]\nü\tü = ü", "[planner]\r\nx\r\n", "=\n[]\n[planner]\n=5"] {
            let (findings, summary) = findings(text);
            assert!(!render_all(&findings, summary, "f", text).is_empty());
        }
    }
}
