//! A record played to our machine.

use super::record::{Exchange, Record, Step};

const PRINTER: &str = include_str!("../data/v2/printer.ini");
const DELTA: &str = include_str!("../data/v2/delta.ini");

/// Silence after which an answer counts as complete, seconds.
const QUIET_S: f64 = 0.1;
/// Longest time for the first byte where v2 was quick, seconds.
const PATIENCE_S: f64 = 1.0;

/// A machine that a record is played to.
pub trait Desk {
    /// Sends bytes to the debug console.
    fn send(&mut self, bytes: &[u8]);
    /// Lets so many seconds pass; what was said in them.
    fn hear(&mut self, seconds: f64) -> String;
    /// Something breaks, or is repaired.
    fn inject(&mut self, fault: &str);
}

/// The files on the card of the recordings; beside them an empty folder `sub`.
pub fn card() -> Vec<(&'static str, String)> {
    let long = |length| format!("G1 X0 ;{}\n", "x".repeat(length));
    vec![
        ("test.g", "G91\nG1 X1 F600\nG1 X-1\nG90\nM114\nM117 hello\nG999\n".into()),
        ("with space.g", "G4 P100\nM117 x\n".into()),
        ("long.g", format!("{}{}G1 X0\n", long(160), long(165))),
        ("one.txt", "single\n".into()),
        ("lines.txt", "line1\nline2\nline3\nline4\n".into()),
        ("job.g", "G1 X20 F2400\nG1 X0 ;   \n".repeat(32)),
        ("bad.g", "G1 X5 F1200\nG1 XY\nBLAH\nG1 X6\nM999\nG33.7\n".into()),
        ("ovr", "M92 X100 Y100 Z400\nM7777\nG54\nG21 \n".into()),
        ("empty.g", String::new()),
    ]
}

/// The configuration that a record begins with, and the settings that it changes.
pub fn machine(record: &Record) -> (&'static str, Vec<&str>) {
    let mut base = None;
    let mut settings = Vec::new();
    for line in &record.head {
        match line.split_once(": ") {
            Some(("config", "printer")) => base = Some(PRINTER),
            Some(("config", "delta")) => base = Some(DELTA),
            Some(("set", setting)) => settings.push(setting),
            _ => panic!("what is `{line}`?"),
        }
    }
    (base.expect("a configuration"), settings)
}

/// Returns the answers of a machine, exchange by exchange.
pub fn play(desk: &mut impl Desk, record: &Record) -> Vec<Vec<String>> {
    record.exchanges.iter().map(|exchange| answer(desk, exchange)).collect()
}

fn answer(desk: &mut impl Desk, exchange: &Exchange) -> Vec<String> {
    let mut heard = String::new();
    let last = exchange.steps.len() - 1;
    for (index, step) in exchange.steps.iter().enumerate() {
        let ended = exchange.theirs.last().is_some_and(|line| line == "ok");
        let patience = exchange.patience.as_ref().map_or(PATIENCE_S, |s| s.parse::<f64>().expect("seconds") + 5.0);
        let patience = if ended && index == last { patience.max(30.0) } else { patience };
        match step {
            Step::Line(text) => {
                desk.send(format!("{text}\n").as_bytes());
                heard.push_str(&reply(desk, patience, ended));
            }
            Step::Raw(text) => {
                desk.send(&unescaped(text));
                heard.push_str(&reply(desk, patience, false));
            }
            Step::Wait(seconds) => heard.push_str(&desk.hear(seconds.parse().expect("seconds"))),
            Step::Fault(text) => {
                desk.inject(text);
                // Until inputs have been read.
                heard.push_str(&desk.hear(0.05));
            }
            Step::Ours(text) => {
                desk.send(&unescaped(&format!("{text}\\n")));
                drop(desk.hear(0.3));
            }
        }
    }
    heard.lines().map(escaped).collect()
}

/// Listens until the line that ends an answer, or until nothing more is said.
fn reply(desk: &mut impl Desk, patience_s: f64, ends_with_ok: bool) -> String {
    let (mut heard, mut quiet, mut waited) = (String::new(), 0.0, 0.0);
    loop {
        let more = desk.hear(0.02);
        waited += 0.02;
        quiet = if more.is_empty() { quiet + 0.02 } else { 0.0 };
        heard.push_str(&more);
        let last = heard.lines().last().unwrap_or("");
        let ended = last.starts_with("ok") || last.starts_with("error") || last == "!!" || last.starts_with("rs ");
        let enough = !heard.is_empty() && (ended || !ends_with_ok);
        if quiet > QUIET_S && (enough || waited > patience_s) {
            return heard;
        }
    }
}

/// Bytes beyond ASCII as the records spell them.
fn escaped(line: &str) -> String {
    let mut text = String::new();
    for c in line.chars() {
        if c.is_ascii() {
            text.push(c);
        } else {
            let mut bytes = [0; 4];
            c.encode_utf8(&mut bytes).bytes().for_each(|byte| text += &format!("\\x{byte:02x}"));
        }
    }
    text
}

/// `\n`, `\x18` and the like.
fn unescaped(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut rest = text;
    while let Some(c) = rest.chars().next() {
        let escape = rest.strip_prefix('\\').and_then(|tail| tail.chars().next());
        let (byte, taken) = match escape {
            Some('n') => (b'\n', 2),
            Some('r') => (b'\r', 2),
            Some('x') => (u8::from_str_radix(&rest[2..4], 16).expect("two digits"), 4),
            _ => (rest.as_bytes()[0], c.len_utf8()),
        };
        if escape.is_none() {
            bytes.extend_from_slice(&rest.as_bytes()[..taken]);
        } else {
            bytes.push(byte);
        }
        rest = &rest[taken..];
    }
    bytes
}
