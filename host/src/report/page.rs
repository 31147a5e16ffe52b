//! The page: data as JSON, charts and 3D view by libraries that are part of the page. No network is needed.

mod account;
mod power;

use super::Report;
use super::checks::anchor;
use super::path::{Corner, Kind};
use crate::page::fill;
use account::AccountData;
use power::PowerData;
use serde::Serialize;
use std::fmt::Write;

const TEMPLATE: &str = include_str!("../../assets/report.html");
/// Greatest number of corners drawn; a graphics card turns ten times as many without effort, but a page of
/// ten megabytes loads slowly.
const MOST_CORNERS: usize = 60_000;
/// Greatest number of points in a chart: two for each pixel of a wide screen.
const MOST_CHART_POINTS: usize = 5_000;
const MOST_CONSOLE_LINES: usize = 500;
/// Filament of slicers' default, for the thickness of drawn lines only.
const FILAMENT_DIAMETER_MM: f64 = 1.75;
/// Width of a laser's beam, for the thickness of drawn lines only.
const BEAM_MM: f64 = 0.1;

#[derive(Serialize)]
struct Data<'a> {
    title: &'a str,
    seconds: f64,
    lines: u64,
    edges: u64,
    hash: String,
    halted: Option<&'a str>,
    checks: &'a [super::Check],
    motors: Vec<MotorRow<'a>>,
    heaters: Vec<HeaterRow<'a>>,
    path: PathData,
    account: AccountData<'a>,
    speed: SpeedData,
    power: Option<PowerData>,
    telemetry: TelemetryData<'a>,
    console: String,
}

#[derive(Serialize)]
struct MotorRow<'a> {
    name: &'a str,
    edges: u64,
    max_rate: f64,
    position: f64,
}

#[derive(Serialize)]
struct HeaterRow<'a> {
    name: &'a str,
    last: f64,
    max: f64,
}

/// Arrays of little-endian numbers in base 64.
#[derive(Serialize)]
struct PathData {
    xyz: String,
    time: String,
    speed: String,
    work: String,
    /// Power of a laser on the way to each corner, share of full power.
    power: Option<String>,
    tube: f64,
    filament: f64,
}

#[derive(Serialize)]
struct SpeedData {
    time: Vec<f64>,
    tool: Vec<f64>,
    filament: Vec<f64>,
}

#[derive(Serialize)]
struct TelemetryData<'a> {
    time: Vec<f64>,
    temperatures: Vec<Series<'a>>,
    duties: Vec<Series<'a>>,
    volts: Vec<Series<'a>>,
    cpu: Vec<Series<'a>>,
}

#[derive(Serialize)]
struct Series<'a> {
    name: &'a str,
    values: Vec<Option<f64>>,
}

/// Returns the whole HTML page of a report.
pub fn render(report: &Report) -> String {
    fill(TEMPLATE, &report.title, &data(report))
}

fn data(report: &Report) -> Data<'_> {
    let summary = &report.run.summary;
    Data {
        title: &report.title,
        seconds: summary.virtual_seconds,
        lines: summary.lines,
        edges: report.executed.edges.iter().sum(),
        hash: format!("{:016x}", report.executed.hash),
        halted: summary.halted.as_deref(),
        checks: &report.checks,
        motors: motors(report),
        heaters: summary.heaters.iter().map(|(name, h)| HeaterRow { name, last: h.final_c, max: h.max_c }).collect(),
        path: path(report),
        account: account::data(report),
        speed: speed(report),
        power: power::data(&report.run.power, summary.virtual_seconds, MOST_CHART_POINTS),
        telemetry: telemetry(report),
        console: console(report.run.console.as_deref().unwrap_or_default()),
    }
}

fn motors(report: &Report) -> Vec<MotorRow<'_>> {
    let rows = report.run.summary.actuators.iter().map(|(name, motor)| MotorRow {
        name,
        edges: motor.steps,
        max_rate: motor.max_steps_per_s,
        position: motor.position_mm,
    });
    let mut rows: Vec<_> = rows.collect();
    rows.sort_by_key(|row| units::Actuator::from_name(row.name).map_or(usize::MAX, |motor| motor as usize));
    rows
}

/// Returns the corners in the program's coordinates from the end of homing on, or all of them if those are
/// not known.
fn path(report: &Report) -> PathData {
    let has_extruder = report.machine.as_ref().is_ok_and(|machine| !machine.extruders.is_empty());
    let mut corners = report.samples.corners(has_extruder, 0.01, 6.0, MOST_CORNERS);
    if let (Ok(machine), Ok(program)) = (&report.machine, &report.program)
        && let Some(anchor) = anchor(&report.executed, machine, program)
    {
        let begin_s = if anchor.stop.until_ns == u64::MAX { 0.0 } else { anchor.stop.until_ns as f64 * 1e-9 };
        corners.retain(|corner| corner.time_s >= begin_s - report.samples.period_s);
    }
    let mut powers = None;
    if !report.run.power.is_empty() {
        let (cut, along) = power::along(&corners, &report.samples, &report.run.power);
        (corners, powers) = (cut, Some(along));
    }
    let tube = tube(&corners, powers.is_some());
    let floats = |of: &dyn Fn(&Corner) -> f64| base64(corners.iter().flat_map(|c| (of(c) as f32).to_le_bytes()));
    PathData {
        xyz: base64(corners.iter().flat_map(|c| c.at).flat_map(|mm| (mm as f32).to_le_bytes())),
        time: floats(&|corner| corner.time_s),
        speed: floats(&|corner| corner.speed),
        work: base64(corners.iter().map(|corner| u8::from(corner.kind == Kind::Work))),
        power: powers.map(|powers| base64(powers.into_iter().flat_map(|share| (share as f32).to_le_bytes()))),
        tube,
        filament: corners.iter().filter(|c| c.kind == Kind::Work).map(|c| c.fed).sum(),
    }
}

/// Returns the thickness of the drawn line in mm: that of a round line with the material that went into it;
/// thin if none did, and as thin as a beam if a laser burned it.
fn tube(corners: &[Corner], is_burned: bool) -> f64 {
    let (mut length, mut fed) = (0.0, 0.0);
    let mut low = [f64::INFINITY; 3];
    let mut high = [f64::NEG_INFINITY; 3];
    for pair in corners.windows(2).filter(|pair| pair[1].kind == Kind::Work) {
        length += (0..3).map(|axis| (pair[1].at[axis] - pair[0].at[axis]).powi(2)).sum::<f64>().sqrt();
        fed += pair[1].fed;
        for axis in 0..3 {
            low[axis] = low[axis].min(pair[1].at[axis]);
            high[axis] = high[axis].max(pair[1].at[axis]);
        }
    }
    let size = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    if is_burned {
        return (size / 1_000.0).max(BEAM_MM);
    }
    if length > 0.0 && fed > 0.0 { FILAMENT_DIAMETER_MM * (fed / length).sqrt() } else { (size / 300.0).max(0.05) }
}

/// Returns in each slot of time the largest speed, and the filament speed of largest size: peaks matter
/// most.
fn speed(report: &Report) -> SpeedData {
    let samples = &report.samples;
    let per_point = samples.points.len().div_ceil(MOST_CHART_POINTS).max(1);
    let mut data = SpeedData { time: Vec::new(), tool: Vec::new(), filament: Vec::new() };
    for first in (0..samples.points.len()).step_by(per_point) {
        let slot = first..(first + per_point).min(samples.points.len());
        let tool = slot.clone().map(|index| samples.speed(index)).fold(0.0, f64::max);
        let filament = slot.map(|index| samples.filament_speed(index));
        let filament = filament.fold(0.0, |peak: f64, speed| if speed.abs() > peak.abs() { speed } else { peak });
        data.time.push(rounded(first as f64 * samples.period_s, 1e3));
        data.tool.push(rounded(tool, 1e2));
        data.filament.push(rounded(filament, 1e3));
    }
    data
}

fn telemetry(report: &Report) -> TelemetryData<'_> {
    let Some(table) = &report.run.telemetry else {
        let (time, temperatures, duties) = (Vec::new(), Vec::new(), Vec::new());
        return TelemetryData { time, temperatures, duties, volts: Vec::new(), cpu: Vec::new() };
    };
    let stride = table.time_s.len().div_ceil(MOST_CHART_POINTS).max(1);
    let series = |suffix: &'static str| {
        let columns = table.ending(suffix).map(|(name, column)| {
            let values = column.iter().step_by(stride).map(|value| value.map(|value| rounded(value, 1e3)));
            Series { name, values: values.collect() }
        });
        // A quantity that was never recorded, or never on, makes no curve.
        let empty = if suffix == "_duty" { Some(0.0) } else { None };
        columns.filter(|series| series.values.iter().any(|v| v.is_some() && *v != empty)).collect::<Vec<_>>()
    };
    TelemetryData {
        time: table.time_s.iter().step_by(stride).map(|time| rounded(*time, 1e4)).collect(),
        temperatures: series("_c"),
        duties: series("_duty"),
        volts: series("_v"),
        cpu: series("cpu_load"),
    }
}

/// Returns beginning and end of the console, when it is long.
fn console(text: &str) -> String {
    let lines: Vec<&str> = text.lines().collect();
    if lines.len() <= MOST_CONSOLE_LINES {
        return lines.join("\n");
    }
    let (head, tail) = (MOST_CONSOLE_LINES / 5, MOST_CONSOLE_LINES * 4 / 5);
    let left_out = lines.len() - head - tail;
    format!("{}\n... {left_out} lines ...\n{}", lines[..head].join("\n"), lines[lines.len() - tail..].join("\n"))
}

fn rounded(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}

/// Encodes bytes in base 64, RFC 4648 section 4.
pub fn base64(bytes: impl Iterator<Item = u8>) -> String {
    const ALPHABET: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let bytes: Vec<u8> = bytes.collect();
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for chunk in bytes.chunks(3) {
        let group = chunk.iter().chain([0, 0].iter()).take(3).fold(0_u32, |group, byte| group << 8 | u32::from(*byte));
        for place in 0..4 {
            let sextet = group >> (18 - 6 * place) & 63;
            let written = if place <= chunk.len() { char::from(ALPHABET[sextet as usize]) } else { '=' };
            let _ = text.write_char(written);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_is_that_of_the_standard() {
        let pairs =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        for (plain, coded) in pairs {
            assert_eq!(base64(plain.bytes()), coded);
        }
    }

    #[test]
    fn a_long_console_keeps_its_beginning_and_end() {
        let text: String = (0..2_000).map(|n| format!("line {n}\n")).collect();
        let short = console(&text);
        assert!(short.starts_with("line 0\n") && short.ends_with("line 1999") && short.contains("... 1500 lines ..."));
        assert_eq!(console("a\nb\n"), "a\nb");
    }

    #[test]
    fn power_is_drawn_along_the_path_where_there_was_some() {
        let mut report = super::super::fake::report();
        let without = serde_json::to_value(data(&report)).expect("a page's data");
        assert!(without["power"].is_null() && without["path"]["power"].is_null());
        let half_ns = report.executed.end_ns / 2;
        let change = |time_ns, duty| super::super::power::Change { time_ns, duty };
        report.run.power = vec![change(half_ns, 0.5), change(half_ns + 200_000_000, 0.0)];
        let with = serde_json::to_value(data(&report)).expect("a page's data");
        assert_eq!(with["power"]["on_seconds"], 0.2);
        let highest = with["power"]["highest"].as_array().expect("points").iter().filter_map(|share| share.as_f64());
        assert_eq!(highest.fold(0.0, f64::max), 50.0);
        // A number of four bytes for each corner, of which there are more: the power changes between two.
        let length = |data: &serde_json::Value, part: &str| data["path"][part].as_str().map_or(0, str::len);
        assert_eq!(length(&with, "power"), length(&with, "time"));
        assert!(length(&with, "time") > length(&without, "time"));
    }

    #[test]
    fn the_page_stands_alone_and_text_of_the_run_cannot_break_it() {
        let mut report = super::super::fake::report();
        report.title = "</script><script>alert(1)</script>".to_owned();
        report.run.console = Some("ok </script>".to_owned());
        let page = render(&report);
        assert!(!page.contains("alert(1)</script>") && !page.contains("ok </script>"));
        for outside in ["src=\"http", "href=\"http", "@import", "url(http"] {
            assert!(!page.contains(outside), "{outside}");
        }
        assert!(!page.contains("{{") || page.contains("uPlot"), "no slot is left open");
        assert!(page.len() < 5_000_000, "{} bytes", page.len());
    }
}
