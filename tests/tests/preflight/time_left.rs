//! Reports of the time that is left in a job.

use std::fmt::Write;

use scenarios::{CARTESIAN, Plan};

use super::{kinds, repeated, with};

/// Parses the answer of `progress`: seconds left, total seconds, and source of the estimate.
fn time_left(said: &str) -> Option<(f64, f64, String)> {
    let clock = |text: &str| text.split(':').fold(0.0, |sum, part| 60.0 * sum + part.parse::<f64>().expect("a clock"));
    let (_, rest) = said.split_once("est time: ")?;
    let (left, rest) = rest.split_once(" of ")?;
    let (total, rest) = rest.split_once(" by the ")?;
    Some((clock(left), clock(total), rest.split(|c: char| !c.is_alphabetic()).next()?.to_owned()))
}

/// Plays a file with the feed override; returns the times left that were told, with the second of each, and
/// the duration.
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
