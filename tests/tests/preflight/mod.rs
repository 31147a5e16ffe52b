//! Preflight checks: a preflight says what the machine then says, and takes the time that the machine then
//! takes.

mod beside;
mod jobs;
mod limits;
mod time_left;

use std::fmt::Write;
use std::sync::LazyLock;

use config::BoardId;
use motion::Motion;
use preflight::{Finding, Listener, Preflight, TOLD_LINES, Told, Totals, dialect_of, read};
use scenarios::{CARTESIAN, COREXY, DELTA, Plan};

#[derive(Default)]
struct Found(Vec<Finding>);

impl Listener for Found {
    fn found(&mut self, finding: &Finding) {
        self.0.push(finding.clone());
    }
}

/// Files of subroutines: their names, and their text.
type Subs = [(&'static str, &'static str)];

fn preflight_beside(config: &str, text: &str, subs: &Subs) -> (Vec<Finding>, Totals) {
    let config = machine_config(config);
    let (mut motion, mut program, mut found) = (Box::new(Motion::new()), None, Found::default());
    let texts = base::failure::Texts::new();
    let mut preflight =
        Preflight::new(&texts, &config, dialect_of(text.as_bytes()), &mut program, &mut motion).expect("it can move");
    let sub = |name: &str| subs.iter().find(|(known, _)| *known == name).map(|(_, text)| text.as_bytes());
    read(&mut preflight, text.as_bytes(), &sub, &mut motion, &mut found).expect("they do not call too deep");
    (found.0, *preflight.totals())
}

fn preflight(config: &str, text: &str) -> (Vec<Finding>, Totals) {
    preflight_beside(config, text, &[])
}

fn machine_config(config: &str) -> config::MachineConfig {
    let (config, summary) = config::parse(config.as_bytes(), BoardId::default(), &mut ());
    assert!(summary.is_usable());
    config
}

fn told(config: &str, totals: &Totals) -> String {
    let config = &machine_config(config);
    (0..TOLD_LINES).map(|line| Told { config, totals, line }.to_string()).collect()
}

fn with(config: &str, line: &str) -> String {
    let parts = line.strip_prefix('[').and_then(|rest| rest.split_once("] ")).unwrap();
    let (key, value) = parts.1.split_once(" = ").unwrap();
    config::edit::apply(config, config::edit::Edit { section: parts.0, key, value: Some(value) })
}

// --- time ---

/// Walls of a vase with retractions, lifts and a fan, as slicers write them.
fn vase(layers: u32, sides: u32) -> String {
    let mut text = String::from("G90\nM83\nG1 Z0.2 F600\n");
    for layer in 0..layers {
        let _ = writeln!(text, "M106 S{}\nG1 E-0.8 F2400\nG0 X60 Y50 F9000\nG1 E0.8 F2400", 20 * layer);
        for side in 0..=sides {
            let angle = f64::from(side) / f64::from(sides) * std::f64::consts::TAU;
            let radius = 10.0 + 0.8 * (6.0 * angle).sin();
            let (x, y) = (50.0 + radius * angle.cos(), 50.0 + radius * angle.sin());
            let _ = writeln!(text, "G1 X{x:.3} Y{y:.3} E0.02 F{}", 1200 + 600 * (layer % 5));
        }
        let _ = writeln!(text, "G1 Z{:.2} F600", 0.2 * f64::from(layer + 2));
    }
    text
}

fn repeated(times: u32, text: &str) -> String {
    format!("G90\nG1 X10 Y10 Z1 F6000\n{}", text.repeat(times as usize))
}

/// Kinds of files, and the machines for them.
fn kinds() -> Vec<(&'static str, String, String)> {
    let square = "G1 X40 F4800\nG1 Y40\nG1 X10\nG1 Y10\n";
    let arcs = "G2 X30 Y10 I10 J0 F3000\nG3 X10 Y10 I-10 J5\nG2 X20 Y20 R12\nG1 X10 Y10\n";
    let smooth = with(&with(CARTESIAN, "[planner] jerk = 60000"), "[planner] x_axis_max_jerk = 90000");
    let shaped = with(&with(CARTESIAN, "[input shaper] shaper_freq_x = 45"), "[input shaper] shaper_freq_y = 38");
    vec![
        ("slicer's walls", CARTESIAN.into(), vase(12, 120)),
        ("squares", CARTESIAN.into(), repeated(8, square)),
        ("arcs", CARTESIAN.into(), repeated(8, arcs)),
        ("rounded corners (G64)", CARTESIAN.into(), format!("G64 P0.2\n{}", repeated(8, square))),
        ("exact stops (G61.1)", CARTESIAN.into(), format!("G61.1\n{}", repeated(6, square))),
        ("S-curves", smooth, vase(8, 90)),
        ("splines (G5)", CARTESIAN.into(), repeated(10, "G5 X30 Y20 I5 J8 P-6 Q-4 F2400\nG1 X10 Y10\n")),
        ("input shaper", shaped, repeated(8, square)),
        ("CoreXY", COREXY.into(), vase(8, 90)),
        ("delta", DELTA.into(), repeated(6, "G1 X20 Y-20 F6000\nG1 X-20 Y20\nG1 X10 Y10 Z5\nG1 Z1\n")),
        (
            "limits that change",
            CARTESIAN.into(),
            repeated(3, &format!("M204 S500\nM203 X30\n{square}M204 S3000\nM203 X300\nM205 X0.01\n{square}")),
        ),
        (
            "heating and dwells",
            CARTESIAN.into(),
            repeated(5, &format!("M104 S200\nM109 S200\nG4 P400\n{square}M400\n")),
        ),
        (
            "inverse time and loops",
            CARTESIAN.into(),
            repeated(2, "O1 repeat [4]\nG93\nG1 X30 F60\nG1 X10 Y20 F40\nG94\nO1 endrepeat\n"),
        ),
    ]
}

#[test]
fn the_time_of_a_file_is_foreseen_within_a_hundredth() {
    let mut table = String::new();
    let mut worst: f64 = 0.0;
    for (name, config, text) in kinds() {
        let homes = "G28\n";
        let (found, totals) = preflight(&config, &format!("{homes}{text}"));
        assert_eq!(totals.stops, 0, "{name}: {found:?}");
        let foreseen = totals.seconds() - totals.homing_seconds;
        let mut bench = Plan::new(&config).file("job.g", &text).start();
        bench.run(&["G28"]);
        if totals.heat_waits > 0 {
            bench.say("M109 S200");
        }
        let begun = bench.now_s();
        bench.type_in("play /sd/job.g -t\n");
        bench.hear_until("Done printing file", 3_000.0);
        let made = bench.now_s() - begun;
        let error = 100.0 * (foreseen / made - 1.0);
        worst = worst.max(error.abs());
        let _ = writeln!(table, "| {name} | {foreseen:.2} | {made:.2} | {error:+.2} % |");
    }
    println!("{table}");
    assert!(worst <= 1.0, "\n{table}");
}

// --- findings ---

const CORPUS: &str = include_str!("../data/preflight/corpus.txt");

/// A flawed file: its name, its lines, what is said of it.
fn corpus() -> Vec<(String, String, String)> {
    let cases = CORPUS.split("=== ").skip(1);
    cases
        .map(|case| {
            let (name, rest) = case.split_once('\n').expect("a name");
            let (text, said) = rest.split_once("---\n").unwrap_or((rest, ""));
            (name.to_owned(), text.to_owned(), said.to_owned())
        })
        .collect()
}

/// The sample laser, which homes by G28.
static LASER: LazyLock<String> = LazyLock::new(|| {
    include_str!("../../../config/samples/laser.ini").replace("grbl_mode = true", "grbl_mode = false")
});

fn machine_of(name: &str) -> &'static str {
    match name.split_once(": ") {
        Some(("delta", _)) => DELTA,
        Some(("corexy", _)) => COREXY,
        Some(("laser", _)) => &LASER,
        _ => CARTESIAN,
    }
}

fn said_of(name: &str, text: &str) -> String {
    preflight(machine_of(name), text).0.iter().map(|finding| format!("{finding}\n")).collect()
}

#[test]
fn each_flawed_file_gets_its_sentence() {
    let cases = corpus();
    assert!(cases.len() >= 40, "{} files", cases.len());
    if std::env::var_os("WRITE_PREFLIGHT").is_some() {
        let mut written = CORPUS.split("=== ").next().unwrap_or("").to_owned();
        for (name, text, _) in &cases {
            let _ = write!(written, "=== {name}\n{text}---\n{}", said_of(name, text));
        }
        std::fs::write("tests/data/preflight/corpus.txt", written).expect("the corpus");
        return;
    }
    for (name, text, said) in &cases {
        assert!(!said.is_empty(), "{name}: nothing is wrong with it");
        assert_eq!(&said_of(name, text), said, "{name}");
    }
}

/// The board's command has the desk's sentences.
#[test]
fn the_board_says_the_same() {
    for (name, text, said) in corpus() {
        let mut bench = Plan::new(machine_of(&name)).file("job.g", &text).start();
        let heard = bench.say("check /sd/job.g");
        let (found, rest): (Vec<_>, Vec<_>) = heard.lines().partition(|line| line.starts_with("line "));
        assert_eq!(found, said.lines().collect::<Vec<_>>(), "{name}: {heard}");
        let (_, totals) = preflight(machine_of(&name), &text);
        assert_eq!(rest.join("\n"), told(machine_of(&name), &totals) + "ok", "{name}");
    }
}

#[test]
fn the_board_foresees_the_same_time() {
    for (name, config, text) in kinds() {
        let text = format!("G28\n{text}");
        let heard = Plan::new(&config).file("job.g", &text).start().say("check /sd/job.g");
        let (_, totals) = preflight(&config, &text);
        assert!(heard.ends_with(&(told(&config, &totals) + "ok\n")), "{name}: {heard}");
    }
}

/// Faults that stop a job are found by the preflight check, and only those.
#[test]
fn a_job_stops_where_its_preflight_says() {
    for (name, text, said) in corpus() {
        let foreseen = said.lines().any(|line| line.contains(": stops: "));
        let alone = with(machine_of(&name), "[player] preflight = time");
        let mut bench = Plan::new(&alone).file("job.g", &text).start();
        bench.type_in("play /sd/job.g -t\n");
        let mut heard = String::new();
        let end = bench.now_s() + 900.0;
        let stops =
            |heard: &str| ["error:paused", "ALARM", "Error:", "halted", "error:"].iter().any(|w| heard.contains(w));
        while !heard.contains("Done printing file") && !stops(&heard) {
            assert!(bench.now_s() < end, "{name}: {heard}");
            heard.push_str(&bench.hear(0.05));
        }
        assert_eq!(stops(&heard), foreseen, "{name}:\n{said}\nand the machine said:\n{heard}");
    }
}
