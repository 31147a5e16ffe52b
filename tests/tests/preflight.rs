//! A preflight says what the machine then says, and takes the time that the machine then takes.

use std::fmt::Write;

use config::BoardId;
use machine::preflight::{Finding, Listener, Preflight, TOLD_LINES, Told, Totals, dialect_of, read};
use machine::sessions::SessionId;
use motion::Motion;
use scenarios::{CARTESIAN, COREXY, DELTA, Plan};

#[derive(Default)]
struct Found(Vec<Finding>);

impl Listener for Found {
    fn found(&mut self, finding: &Finding) {
        self.0.push(finding.clone());
    }
}

fn preflight(config: &str, text: &str) -> (Vec<Finding>, Totals) {
    let (config, summary) = config::parse(config.as_bytes(), BoardId::default(), &mut ());
    assert!(summary.is_usable());
    let (mut motion, mut program, mut found) = (Box::new(Motion::new()), None, Found::default());
    let mut preflight =
        Preflight::new(&config, dialect_of(text.as_bytes()), &mut program, &mut motion).expect("it can move");
    read(&mut preflight, text.as_bytes(), &mut motion, &mut found);
    (found.0, *preflight.totals())
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

// --- time left ---

/// What `progress` says: seconds left, of how many, and who says so.
fn time_left(said: &str) -> Option<(f64, f64, String)> {
    let clock = |text: &str| text.split(':').fold(0.0, |sum, part| 60.0 * sum + part.parse::<f64>().expect("a clock"));
    let (_, rest) = said.split_once("est time: ")?;
    let (left, rest) = rest.split_once(" of ")?;
    let (total, rest) = rest.split_once(" by the ")?;
    Some((clock(left), clock(total), rest.split(|c: char| !c.is_alphabetic()).next()?.to_owned()))
}

/// Plays a file with the feed override and gives what was told at which second, and when it ended.
fn played(config: &str, text: &str, percent: u32) -> (Vec<(f64, f64, f64)>, f64) {
    let mut bench = Plan::new(config).file("job.g", text).start();
    bench.run(&["G28", &format!("M220 S{percent}")]);
    if text.contains("M109") {
        bench.say("M109 S200");
    }
    bench.type_in("play /sd/job.g -t\n");
    let (begun, mut told, mut heard) = (bench.now_s(), Vec::new(), String::new());
    while !heard.contains("Done printing file") {
        let now = bench.now_s() - begun;
        assert!(now < 3_000.0, "{heard}");
        bench.type_in("progress\n");
        let said = bench.hear(0.25);
        if let Some((left, total, who)) = time_left(&said) {
            assert_eq!(who, "planner");
            told.push((now, left, total));
        }
        heard.push_str(&said);
    }
    (told, bench.now_s() - begun)
}

#[test]
fn progress_says_how_much_time_is_left() {
    let mut table = String::new();
    for (name, config, text) in kinds() {
        let (told, made) = played(&config, &text, 100);
        assert!(told.len() as f64 > 2.0 * made, "{name}: it is told at once, and to the end: {told:?}");
        // Told in whole seconds, and by lines; asked four times a second.
        let worst = told.iter().map(|(now, left, _)| (now + left - made).abs()).fold(0.0, f64::max);
        let _ = writeln!(table, "| {name} | {made:.1} | {:.0} | {worst:.1} |", told[0].2);
        assert!(worst <= 1.3 + 0.01 * made && (told[0].2 - made).abs() < 1.0, "{name}: {told:?} of {made}\n{table}");
    }
    println!("{table}");
}

/// By the law of [`machine`]'s forecast, without looking again.
#[test]
fn an_override_changes_what_is_left() {
    for (name, config, text) in kinds().into_iter().take(3) {
        let (_, plain) = played(&config, &text, 100);
        for percent in [50, 80, 130, 200] {
            let (told, made) = played(&config, &text, percent);
            println!("{name} {percent} %: told {:.0}, made {made:.1}, without {plain:.1}", told[0].2);
            assert!((told[0].2 - made).abs() <= 0.6 + 0.01 * made, "{name} at {percent} %: {told:?} of {made}");
        }
        // Changed by the operator on the way.
        let mut bench = Plan::new(&config).file("job.g", &text).start();
        bench.run(&["G28"]);
        bench.type_in("play /sd/job.g -t\n");
        let _ = bench.hear(0.4 * plain);
        let begun = bench.now_s();
        bench.type_in("M220 S50\nprogress\n");
        let (left, ..) = time_left(&bench.hear(0.3)).expect("the planner's");
        bench.hear_until("Done printing file", 3_000.0);
        let made = bench.now_s() - begun;
        println!("{name}, slowed down on the way: {left} left, {made:.1} made");
        assert!((left - made).abs() <= 2.0 + 0.04 * made, "{name}: {left} and {made}");
    }
}

#[test]
fn the_slicer_is_asked_where_nobody_looks_ahead() {
    let text = format!(";TIME:600\n{}", repeated(20, "G1 X40 F600\nG1 X10\n"));
    let mut bench = Plan::new(&with(CARTESIAN, "[player] preflight = off")).file("job.g", &text).start();
    bench.run(&["G28"]);
    bench.type_in("play /sd/job.g\n");
    let _ = bench.hear(2.0);
    let said = bench.say("progress");
    let (left, total, who) = time_left(&said).expect("the slicer's");
    assert!((total, who.as_str()) == (600.0, "slicer") && left > 500.0 && left < 600.0, "{said}");
    assert!(bench.say("M27").contains("// time left: 00:08:"), "{}", bench.say("M27"));
}

// --- jobs that are found to leave the travel ---

const LEAVES: &str = "G28\nG1 X10 Y10 F6000\nG4 P2000\nG1 X999\nG1 X20\n";

#[test]
fn a_job_pauses_before_the_line_that_would_halt_it() {
    let mut bench = Plan::new(CARTESIAN).file("job.g", LEAVES).start();
    bench.type_in("play /sd/job.g -t\n");
    let said = bench.hear_until("the job pauses before it\n", 5.0);
    assert!(said.contains("// WARNING line 4: stops: machine X 999.000 is out of travel"), "{said}");
    bench.hear_until("Print Suspended", 30.0);
    assert!(bench.say("get state").contains("Suspended") || bench.say("progress").contains("Suspended"));
    assert!(bench.say("abort").contains("Suspend cleared"));
    assert!(bench.say("G1 X20 F6000").ends_with("ok\n"), "nothing has halted");
}

#[test]
fn a_job_is_refused_where_the_whole_file_is_looked_at_first() {
    let plan = || Plan::new(&with(CARTESIAN, "[player] preflight = refuse"));
    let mut bench = plan().file("job.g", LEAVES).file("good.g", "G28\nG1 X10 F6000\n").start();
    bench.type_in("play /sd/job.g -t\n");
    let said = bench.hear_until("play --force file begins it all the same\n", 5.0);
    assert!(said.contains("line 4: stops: machine X 999.000") && said.contains("1 of its lines"), "{said}");
    assert!(bench.say("progress").contains("Not currently playing"), "nothing is open");
    assert!(!bench.say("M114").contains("X:10"), "nothing has moved");
    bench.type_in("play /sd/good.g -t\n");
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(said.contains("// nothing in it stops the job"), "{said}");
    bench.type_in("play --force /sd/job.g -t\n");
    let said = bench.hear_until("was not carried out", 60.0);
    assert!(!said.contains("looked at") && !said.contains("the job pauses before"), "{said}");
}

#[test]
fn a_file_that_is_not_looked_at_is_said_nothing_of() {
    let mut bench = Plan::new(&with(CARTESIAN, "[player] preflight = off")).file("job.g", LEAVES).start();
    bench.type_in("play /sd/job.g -t\n");
    let said = bench.hear_until("was not carried out", 60.0);
    assert!(!said.contains("WARNING line 4"), "{said}");
}

/// `check` beside a job that moves: the job's steps are the same.
#[test]
fn a_look_beside_a_job_changes_no_step() {
    let job = repeated(6, "G1 X40 F4800\nG1 Y40\nG1 X10\nG1 Y10\n");
    let run = |looks: bool| {
        let config = with(CARTESIAN, "[player] preflight = off");
        let mut bench = Plan::new(&config).file("job.g", &job).file("other.g", &vase(12, 120)).start();
        bench.run(&["G28"]);
        bench.type_in("play /sd/job.g -t\n");
        let mut said = bench.hear(0.5);
        if looks {
            bench.type_in("check /sd/other.g\n");
        }
        said += &bench.hear_until("Done printing file", 60.0);
        assert_eq!(said.contains("0 stop the job"), looks, "{said}");
        bench.world(|world| format!("{:?}", world.trace_mut().take()))
    };
    assert_eq!(run(true), run(false));
}

#[test]
fn a_file_that_changes_meanwhile_is_looked_at_no_more() {
    let mut bench = Plan::new(CARTESIAN).file("big.g", &vase(200, 120)).start();
    // Beside: whoever types on the other console.
    bench.type_on(SessionId(1), "check /sd/big.g\n");
    let _ = bench.hear_on(SessionId(1), 0.01);
    let _ = bench.say("rm /sd/big.g");
    let said = bench.hear_on(SessionId(1), 1.0);
    assert!(said.contains("error:the file has changed meanwhile"), "{said}");
}

// --- findings ---

const CORPUS: &str = include_str!("data/preflight/corpus.txt");

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

fn machine_of(name: &str) -> &'static str {
    match name.split_once(": ") {
        Some(("delta", _)) => DELTA,
        Some(("corexy", _)) => COREXY,
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
        let told: String = (0..TOLD_LINES).map(|line| Told { totals: &totals, line }.to_string()).collect();
        assert_eq!(rest.join("\n"), told + "ok", "{name}");
    }
}

#[test]
fn the_board_foresees_the_same_time() {
    for (name, config, text) in kinds() {
        let text = format!("G28\n{text}");
        let heard = Plan::new(&config).file("job.g", &text).start().say("check /sd/job.g");
        let (_, totals) = preflight(&config, &text);
        let told: String = (0..TOLD_LINES).map(|line| Told { totals: &totals, line }.to_string()).collect();
        assert!(heard.ends_with(&(told + "ok\n")), "{name}: {heard}");
    }
}

/// What stops a job is found before, and what is found stops it.
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
