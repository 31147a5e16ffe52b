//! Scripts that calls come to: lines that the machine carries out.

use core::fmt::Write as _;

use heapless::String;

use crate::calls::{Call, Method, Quantity, SCRIPT_BYTES};

/// Script of a call.
pub type Script = String<SCRIPT_BYTES>;

/// Letters of axes that may be moved by hand.
const AXES: &str = "xyzabc";

/// Returns the script of a call. `text` is what the call is about.
///
/// # Errors
/// The parameter that is missing or wrong.
pub fn of(call: &Call, text: &str) -> Result<Script, &'static str> {
    if text.bytes().any(|byte| byte < b' ' && !matches!(byte, b'\n' | b'\r' | b'\t')) {
        return Err("texts have no control characters");
    }
    let mut script = Script::new();
    let written = match call.method {
        Method::Script | Method::Ask if text.trim().is_empty() => return Err("the script is empty"),
        Method::Script | Method::Ask => script.write_str(text),
        Method::Pause => script.write_str("M25"),
        Method::Resume => script.write_str("M24"),
        Method::Cancel => script.write_str("abort"),
        Method::Release => script.write_str("M999"),
        Method::Play if text.is_empty() || text.contains(['\n', '\r']) => return Err("filename is missing"),
        Method::Play => write!(script, "play \"/sd/{}\"", text.trim_start_matches('/')),
        Method::Home => home(text, &mut script)?,
        Method::JogStep => jog(call, text, &mut script)?,
        Method::Override => {
            let feed = call.number(Quantity::Feed).filter(|share| (0.0..=10.0).contains(share));
            write!(script, "M220 S{:.0}", feed.ok_or("feed is missing, or not a share from 0 to 10")? * 100.0)
        }
        Method::Identify
        | Method::AccessInfo
        | Method::Login
        | Method::Logout
        | Method::GetUser
        | Method::SetPassword
        | Method::MakeKey
        | Method::ListKeys
        | Method::RevokeKey
        | Method::ServerInfo
        | Method::PrinterInfo
        | Method::ListObjects
        | Method::QueryObjects
        | Method::Subscribe
        | Method::JogStart
        | Method::JogBeat
        | Method::JogStop
        | Method::PathSince
        | Method::Temperatures
        | Method::Lines
        | Method::Help
        | Method::EmergencyStop
        | Method::Files(_) => Ok(()),
    };
    written.map(|()| script).map_err(|_| "the text is too long")
}

/// Writes the line that homes axes: all where none is named.
fn home(axes: &str, script: &mut Script) -> Result<core::fmt::Result, &'static str> {
    if axes.is_empty() {
        return Ok(script.write_str("$H"));
    }
    if !axes.bytes().all(|axis| AXES.as_bytes().contains(&axis)) {
        return Err("axes are letters, as xy, or nothing for all");
    }
    Ok(script
        .write_str("G28")
        .and_then(|()| axes.chars().try_for_each(|axis| write!(script, " {}", axis.to_ascii_uppercase()))))
}

/// Writes the line that moves an axis by hand.
fn jog(call: &Call, name: &str, script: &mut Script) -> Result<core::fmt::Result, &'static str> {
    let letter = axis(name)?;
    let mm = call.number(Quantity::Mm).filter(|mm| mm.abs() <= 10_000.0).ok_or("mm is missing, or too far")?;
    Ok(write!(script, "$J {letter}{mm:.4} F{:.0}", speed(call)?))
}

/// Returns the letter of the axis of a jog.
///
/// # Errors
/// There is no such axis.
pub fn axis(name: &str) -> Result<char, &'static str> {
    let letter = name.chars().next().filter(|letter| name.len() == 1 && AXES.contains(*letter));
    letter.map(|letter| letter.to_ascii_uppercase()).ok_or("axis is a letter, as x")
}

/// Returns the speed of a jog, mm per minute.
///
/// # Errors
/// The call has no `mm_per_min`, or one that is no speed.
pub fn speed(call: &Call) -> Result<f64, &'static str> {
    let speed = call.number(Quantity::MmPerMin).filter(|speed| (1.0..=1e6).contains(speed));
    speed.ok_or("mm_per_min is missing, or no speed")
}

#[cfg(test)]
mod tests {
    use base::snapshot::Snapshot;

    use super::*;
    use crate::calls::Reader;

    /// Reads a call of this method with these parameters. Returns its script, or why there is none.
    fn script(method: &str, parameters: &str) -> Result<String<SCRIPT_BYTES>, &'static str> {
        let mut reader = Reader::new();
        let message = format!(r#"{{"params":{{{parameters}}},"method":"{method}","id":1}}"#);
        reader.read(&mut message.as_bytes(), &Snapshot::default());
        let call = reader.end().expect("a call");
        of(&call, &reader.text)
    }

    #[test]
    fn calls_come_to_lines() {
        for (method, parameters, line) in [
            ("printer.gcode.script", r#""script":"G28\nM105""#, "G28\nM105"),
            ("printer.print.start", r#""filename":"a b.gcode""#, "play \"/sd/a b.gcode\""),
            ("printer.print.pause", "", "M25"),
            ("printer.print.resume", "", "M24"),
            ("printer.print.cancel", "", "abort"),
            ("printer.firmware_restart", "", "M999"),
            ("velvet.home", r#""axes":"""#, "$H"),
            ("velvet.home", r#""axes":"xz""#, "G28 X Z"),
            ("velvet.jog.step", r#""axis":"y","mm":-0.05,"mm_per_min":3000"#, "$J Y-0.0500 F3000"),
            ("velvet.override.set", r#""feed":1.25"#, "M220 S125"),
        ] {
            assert_eq!(script(method, parameters).as_deref(), Ok(line), "{method}");
        }
    }

    #[test]
    fn parameters_that_are_wrong_are_refused() {
        for (method, parameters) in [
            ("printer.gcode.script", r#""script":"  ""#),
            ("printer.gcode.script", r#""script":"G1\u0018""#),
            ("printer.print.start", r#""filename":"""#),
            ("printer.print.start", r#""filename":"a\nM104 S200""#),
            ("velvet.home", r#""axes":"q""#),
            ("velvet.home", r#""axes":"x; M104 S200""#),
            ("velvet.jog.step", r#""axis":"xy","mm":1,"mm_per_min":60"#),
            ("velvet.jog.step", r#""axis":"x","mm_per_min":60"#),
            ("velvet.jog.step", r#""axis":"x","mm":1e9,"mm_per_min":60"#),
            ("velvet.jog.step", r#""axis":"x","mm":1,"mm_per_min":0"#),
            ("velvet.override.set", r#""feed":"fast""#),
            ("velvet.override.set", r#""feed":99"#),
        ] {
            assert!(script(method, parameters).is_err(), "{method} {parameters}");
        }
    }
}
