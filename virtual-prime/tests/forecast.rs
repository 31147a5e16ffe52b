//! Look-ahead of the image at files: findings and forecast, their speed, and that nothing waits for them.

use crate::common::velvet::{CONFIG, Plan, SECOND, Velvet};
use config::BoardId;
use motion::Motion;
use preflight::{Finding, Listener, Preflight, TOLD_LINES, Told, Totals, dialect_of, read};

/// Sliced part: 4,770 lines, a minute and a half.
const PART: &str = include_str!("../../demo/part.gcode");

#[derive(Default)]
struct Found(String);

impl Listener for Found {
    fn found(&mut self, finding: &Finding) {
        self.0 += &format!("{finding}\n");
    }
}

/// Returns the findings and totals of the desk's check.
fn preflight(text: &str) -> (String, Totals) {
    let (config, _) = config::parse(CONFIG.as_bytes(), BoardId::default(), &mut ());
    let (mut motion, mut program, mut found) = (Box::new(Motion::new()), None, Found::default());
    let texts = base::failure::Texts::new();
    let mut preflight =
        Preflight::new(&texts, &config, dialect_of(text.as_bytes()), &mut program, &mut motion).expect("it can move");
    read(&mut preflight, text.as_bytes(), &|_| None, &mut motion, &mut found).expect("it calls nothing");
    let totals = *preflight.totals();
    let told: String =
        (0..TOLD_LINES).map(|line| Told { config: &config, totals: &totals, line }.to_string()).collect();
    (found.0 + &told, totals)
}

fn check(velvet: &mut Velvet, name: &str) -> (String, f64) {
    let begun = velvet.now_ms();
    let said = velvet.ask(&format!("check {name}"), 60 * SECOND);
    (said, (velvet.now_ms() - begun) as f64 * 1e-3)
}

#[test]
fn the_image_finds_and_foresees_what_the_desk_does_two_hundred_times_as_fast_as_the_job() {
    let flawed = "G28\nG1 X999 F6000\nM999999\nG1 X10 E5 F90000\nT7\nG2 X20 Y20\nG1 X1..2\n";
    let mut velvet = Plan::new().file("part.g", PART).file("flawed.g", flawed).start();
    for (name, text) in [("flawed.g", flawed), ("part.g", PART)] {
        let (desk, totals) = preflight(text);
        let (said, took) = check(&mut velvet, name);
        assert_eq!(said, desk + "ok\n", "{name}");
        let factor = totals.seconds() / took;
        println!("{name}: {} lines, {:.1} s, looked at in {took:.3} s: {factor:.0}", totals.lines, totals.seconds());
        assert!(name != "part.g" || factor > 200.0, "only {factor:.0} times as fast");
    }
}

#[test]
fn a_job_takes_the_time_that_is_told_while_it_is_made() {
    let lines: String = (0..60).map(|n| format!("G1 X{} Y{} F6000\n", 10 + 25 * (n % 2), 10 + n % 7)).collect();
    let text = format!("G90\nG1 X10 Y10 Z1 F6000\n{lines}");
    let mut velvet = Plan::new().file("job.g", &text).start();
    velvet.ask("G28", 30 * SECOND);
    let begun = velvet.now_ms();
    velvet.type_in("play /sd/job.g -t");
    velvet.hear(SECOND);
    let said = velvet.ask("progress", SECOND);
    let told = said.split_once(" of 00:00:").and_then(|(_, rest)| rest.get(..2)?.parse::<f64>().ok());
    let told = told.unwrap_or_else(|| panic!("{said}"));
    assert!(said.contains(" by the planner"), "{said}");
    velvet.hear_until("Done printing file", 60 * SECOND);
    let made = (velvet.now_ms() - begun) as f64 * 1e-3;
    println!("told {told} s, made {made:.2} s");
    assert!((told - made).abs() < 0.7, "told in whole seconds: {told}, made {made}");
}
