//! Live numbers: what a clock, a converter or a moving machine says is masked before two replies are
//! compared.

/// Lines that hold one of these say nothing but live numbers.
const LIVE: &[&str] = &[
    "temp: ",
    "S/H temp=",
    "beta temp=",
    ": adc= ",
    "adc= ",
    "elapsed time",
    "SD printing byte",
    "SD print is paused at",
    "Autopid Status",
    "bytes free",
    "bytes total",
    "vbat: ",
    "vmotor: ",
    "vfet: ",
    "vref: ",
    "Build version",
    "Print started at",
    "Print stopped at",
    "config.ini",
    "configuration: read",
];

/// The reply with its live numbers as `#`; a run of lines that are equal then counts once. Entries of
/// directories are sorted: each card has its own order.
pub fn mask(input: &str, lines: &[String]) -> Vec<String> {
    let mut masked: Vec<String> = Vec::new();
    for line in lines {
        let line = one(line);
        if line.contains('#') && masked.last() == Some(&line) {
            continue;
        }
        masked.push(line);
    }
    if input.starts_with("ls") || input.starts_with("M20") {
        masked.sort();
    }
    masked
}

fn one(line: &str) -> String {
    let line = line.trim_end();
    if let Some(said) = line.strip_prefix("[MSG:").and_then(|rest| rest.strip_suffix(']')) {
        return format!("[MSG:{}]", one(said));
    }
    if line.starts_with(';') {
        // A comment of a file of saved settings.
        return ";#".to_owned();
    }
    if line.starts_with('<') || line.starts_with("Idle|") || line.starts_with("Alarm|") || line.starts_with("Run|") {
        return status(line);
    }
    if let Some((_, rest)) = line.split_once("Dir(s)") {
        return format!("# Dir(s){}", if rest.is_empty() { "" } else { ", # bytes free" });
    }
    if let Some((_, name)) = line.split_once("  ").filter(|_| is_dated(line) && line.contains('/')) {
        // An entry of a directory, where sizes and marks are those of the card that was recorded.
        return format!("# {}", name.trim_start().split_once("  ").map_or(name, |(_, name)| name));
    }
    if LIVE.iter().any(|live| line.contains(live)) || is_dated(line) {
        return numbers(line);
    }
    if line.starts_with("T:") || line.starts_with("B:") || line.starts_with("ok B:") || line.starts_with("ok T:") {
        return temperatures(line);
    }
    line.to_owned()
}

/// `2021/05/18 18:20` or `2026-01-02 03:04:05` stands in it.
fn is_dated(line: &str) -> bool {
    let clock = line.split(' ').any(|word| word.len() >= 5 && word.as_bytes().get(2) == Some(&b':'));
    let day = line.split(' ').any(|word| word.len() == 10 && matches!(word.as_bytes().get(4), Some(b'/' | b'-')));
    clock && day
}

/// Every number of a text.
fn numbers(text: &str) -> String {
    let mut masked = String::new();
    let mut in_number = false;
    for c in text.chars() {
        let part = c.is_ascii_digit() || (in_number && c == '.');
        if part && !in_number {
            while masked.ends_with([' ', '-', '0']) {
                masked.pop();
            }
            masked.push_str(" #");
        } else if !part {
            masked.push(c);
        }
        in_number = part;
    }
    masked
}

/// `T:22.0 /40.0 @17`: all but what is asked for.
fn temperatures(line: &str) -> String {
    let words = line.split(' ').map(|word| match word.split_once(':') {
        Some((name, _)) => format!("{name}:#"),
        None if word.starts_with('@') => "@#".to_owned(),
        None => word.to_owned(),
    });
    words.collect::<Vec<_>>().join(" ")
}

/// A status report: places and speeds while it moves, temperatures, progress.
fn status(line: &str) -> String {
    let moves = ["<Run", "<Home", "<Hold", "<Jog", "Run|"].iter().any(|state| line.starts_with(state));
    let fields = line.split('|').map(|field| {
        let Some((name, values)) = field.split_once(':') else { return field.to_owned() };
        let end = if values.ends_with('>') { ">" } else { "" };
        match name {
            "MPos" | "WPos" if moves => format!("{name}:#"),
            "F" if moves => {
                format!("F:#,{}", values.split_once(',').map_or("", |(_, rest)| rest))
            }
            "SD" => format!("SD:#,#{end}"),
            "T" | "B" | "P" => format!("{name}:#,{}", values.split_once(',').map_or("", |(_, target)| target)),
            _ => field.to_owned(),
        }
    });
    fields.collect::<Vec<_>>().join("|")
}
