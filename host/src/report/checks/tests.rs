//! Every check passes on a perfect run and fails on the fault it is there for.

use super::*;
use crate::report::Report;
use crate::report::fake::{self, Edge};

/// The verdict on the check whose text begins so.
fn verdict(report: &Report, begins: &str) -> Verdict {
    let found = report.checks.iter().find(|check| check.what.starts_with(begins));
    found.unwrap_or_else(|| panic!("no check begins with {begins}")).verdict
}

fn report_with(spoil: impl FnOnce(&mut Vec<Edge>)) -> Report {
    let machine = Machine::printer();
    let program = Program::parse(fake::PROGRAM.as_bytes(), machine.beginning);
    let mut edges = fake::edges(&machine, &program);
    spoil(&mut edges);
    fake::report_of(machine, program, &edges)
}

#[test]
fn a_perfect_run_passes_everything_that_can_be_checked() {
    let report = fake::report();
    for check in &report.checks {
        let expected = if check.what.contains("250 ns") { Verdict::Skipped } else { Verdict::Pass };
        assert_eq!(check.verdict, expected, "{}: {}", check.what, check.found);
    }
    assert!(report.passes());
    assert!(report.text().contains("Two squares") && report.text().contains("pass  All heaters"));
}

#[test]
fn one_lost_step_at_the_end_is_noticed() {
    let report = report_with(|edges| {
        let last = edges.iter().rposition(|edge| edge.1 == Actuator::Beta).unwrap();
        edges.remove(last);
    });
    assert_eq!(verdict(&report, "X, Y and Z end"), Verdict::Fail);
    assert!(!report.passes());
}

#[test]
fn filament_short_by_five_steps_is_noticed() {
    let report = report_with(|edges| {
        for _ in 0..5 {
            let last = edges.iter().rposition(|edge| edge.1 == Actuator::Delta).unwrap();
            edges.remove(last);
        }
    });
    assert_eq!(verdict(&report, "Filament moved"), Verdict::Fail);
    assert_eq!(verdict(&report, "X, Y and Z end"), Verdict::Pass);
}

#[test]
fn a_detour_is_noticed_though_the_end_is_right() {
    // 16 steps out and back in the middle of the first side: 0.2 mm.
    let report = report_with(|edges| {
        let middle = edges.iter().filter(|edge| edge.1 == Actuator::Alpha).nth_back(1_000).unwrap().0;
        for step in 0..16 {
            edges.push((middle + step * 1_000_000, Actuator::Beta, 1));
            edges.push((middle + (step + 20) * 1_000_000, Actuator::Beta, -1));
        }
        edges.sort_by_key(|edge| edge.0);
    });
    assert_eq!(verdict(&report, "X, Y and Z end"), Verdict::Pass);
    assert_eq!(verdict(&report, "The executed path"), Verdict::Fail);
}

/// The checks of a perfect run with something changed in what the run says.
fn with_run(change: impl FnOnce(&mut Run)) -> Report {
    let mut report = fake::report();
    change(&mut report.run);
    Report::new(report.run, report.executed, report.machine, report.program, report.samples.period_s, report.title)
}

#[test]
fn what_the_run_itself_says_is_held_against_it() {
    type Fault = fn(&mut Run);
    let faults: [(&str, Fault); 10] = [
        ("The job ended", |run| run.summary.halted = Some("kill button".to_owned())),
        ("No errors", |run| run.summary.errors.push("error: bad".to_owned())),
        ("All heaters", |run| run.telemetry.as_mut().unwrap().columns[1][2] = Some(0.5)),
        ("The laser is off", |run| run.power = vec![Change { time_ns: 5, duty: 0.3 }]),
        ("The emulated board", |run| run.summary.board = Some(vec!["gated access".into()])),
        ("No carriage", |run| run.summary.actuators.get_mut("beta").unwrap().lost_mm = 0.0125),
        ("Every direction", |run| run.summary.timing_faults = Some(1)),
        ("The trace holds", |run| run.summary.actuators.get_mut("alpha").unwrap().steps += 1),
        ("The trace has", |run| run.summary.edge_hash = "1234".into()),
        ("No step edge", |run| {
            run.summary.step_error_ns = Some(crate::report::run::StepError { max: 800.0, rms: 9.0 })
        }),
    ];
    for (begins, change) in faults {
        assert_eq!(verdict(&with_run(change), begins), Verdict::Fail, "{begins}");
    }
    assert_eq!(verdict(&with_run(|run| run.summary.board = None), "The emulated board"), Verdict::Skipped);
    assert_eq!(verdict(&with_run(|run| run.telemetry = None), "All heaters"), Verdict::Skipped);
}

#[test]
fn without_configuration_or_program_the_page_still_says_what_it_can() {
    let report = fake::report();
    let period_s = report.samples.period_s;
    let missing = Err("cannot read config.ini".to_owned());
    let report = Report::new(report.run, report.executed, missing, report.program, period_s, report.title);
    assert_eq!(verdict(&report, "X, Y and Z end"), Verdict::Skipped);
    assert_eq!(verdict(&report, "All heaters"), Verdict::Pass);
    assert!(report.checks.iter().any(|check| check.found.contains("config.ini")));
}

#[test]
fn the_power_at_the_end_is_told_from_the_power_before() {
    // A running mean of one second, ten rows a second: full power, then off (or a fifth) for a while.
    let power_after = |rows: usize, power: f64| {
        let mut mean = 0.8;
        let mut column = vec![Some(mean); 5];
        for _ in 0..rows {
            mean = power + (mean - power) * (-0.1_f64).exp();
            column.push(Some(mean));
        }
        let time: Vec<f64> = (0..column.len()).map(|row| row as f64 * 0.1).collect();
        last_power(&time, &column).unwrap()
    };
    assert!(power_after(8, 0.0).abs() < 1e-9);
    assert!((power_after(8, 0.2) - 0.2).abs() < 1e-9);
    assert!(power_after(2, 0.0) > 0.3, "off too late to be sure");
    assert_eq!(last_power(&[], &[]), None);
}
