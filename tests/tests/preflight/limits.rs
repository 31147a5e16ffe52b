//! Reports of the time that limits cost: as much as raising them saves.

use preflight::Limit;
use scenarios::{CARTESIAN, Plan};

use super::{preflight, repeated, told, vase, with};

/// Files that ask for more than a machine gives, the settings that cut it, and the same raised so that they
/// do not.
fn limited() -> Vec<(&'static str, String, Vec<&'static str>, Vec<&'static str>)> {
    let hops = "G1 X40 F4800\nG1 Z6 F1800\nG1 X10 F4800\nG1 Z1 F1800\n";
    let circles = "G2 X30 Y10 I10 J0 F6000\nG2 X10 Y10 I-10 J0\nG1 X10.5 F6000\nG1 X10\n";
    let primes = "G1 X30 E20 F6000\nG1 X10 E20\n";
    let z = vec!["[motion control] z_axis_max_speed = 300", "[actuator] gamma.max_rate = 1800"];
    vec![
        (
            "z_axis_max_speed",
            repeated(6, hops),
            z,
            vec!["[motion control] z_axis_max_speed = 1800", "[actuator] gamma.max_rate = 1800"],
        ),
        (
            "x_axis_max_speed",
            repeated(2, &vase(4, 120).replace("M83", "").replace("E0.02", "").replace("F1", "F6")),
            vec!["[motion control] x_axis_max_speed = 1500"],
            vec!["[motion control] x_axis_max_speed = 60000"],
        ),
        (
            "alpha.max_rate",
            repeated(6, circles),
            vec!["[actuator] alpha.max_rate = 1200"],
            vec!["[actuator] alpha.max_rate = 9000"],
        ),
        (
            "delta.max_rate",
            format!("M302\nM104 S200\n{}", repeated(4, &format!("M83\n{primes}"))),
            vec!["[actuator] delta.max_rate = 1200"],
            vec!["[actuator] delta.max_rate = 9000"],
        ),
        (
            "beta.acceleration",
            format!("M204 S3000\n{}", repeated(8, "G1 X40 Y40 F6000\nG1 X10 Y10\n")),
            vec!["[actuator] beta.acceleration = 300"],
            vec!["[actuator] beta.acceleration = 3000"],
        ),
    ]
}

fn made_in(config: &str, text: &str) -> f64 {
    let mut bench = Plan::new(config).file("job.g", text).start();
    bench.run(&["G28"]);
    if text.contains("M104") {
        bench.say("M109 S200");
    }
    bench.type_in("play /sd/job.g -t\n");
    let begun = bench.now_s();
    bench.hear_until("Done printing file", 3_000.0);
    bench.now_s() - begun
}

#[test]
fn what_a_limit_costs_is_what_raising_it_saves() {
    for (name, text, low, high) in limited() {
        let of = |lines: &[&str]| lines.iter().fold(CARTESIAN.to_owned(), |config, line| with(&config, line));
        let (low, high) = (of(&low), of(&high));
        let (found, totals) = preflight(&low, &format!("G28\n{text}"));
        assert_eq!(totals.stops, 0, "{name}: {found:?}");
        let cost = Limit::ALL.into_iter().zip(totals.limits).find(|(limit, _)| limit.to_string() == name).unwrap().1;
        assert!((totals.lost_seconds() - cost).abs() < 0.01 * cost + 0.05, "{name} is all: {:?}", totals.limits);
        let saved = made_in(&low, &text) - made_in(&high, &text);
        println!("{name}: {cost:.2} s foreseen, {saved:.2} s saved of {:.2} s", totals.seconds());
        assert!(cost > 1.0 && (cost - saved).abs() <= 0.02 * saved + 0.05, "{name}: {cost} and {saved}");
        let told = told(&low, &totals);
        assert!(told.contains("\nlimits cost ") && told.contains(&format!(": {name} ")), "{told}");
    }
}

/// The limit of flow is a code's: the same file without it.
#[test]
fn what_the_flow_limit_costs_is_what_the_file_saves_without() {
    let of = |most: f64| {
        let moves = repeated(6, "G1 X40 E6 F4800\nG1 Y40 E0.5\nG1 X10 E6\nG1 Y10 E0.5\n");
        format!("M83\nM302\nM200 D1.75\nM104 S200\nM203 V{most}\n{moves}")
    };
    let (found, totals) = preflight(CARTESIAN, &format!("G28\n{}", of(5.0)));
    assert_eq!(totals.stops, 0, "{found:?}");
    let (cost, saved) =
        (totals.limits[Limit::Flow.index()], made_in(CARTESIAN, &of(5.0)) - made_in(CARTESIAN, &of(0.0)));
    println!("flow: {cost:.2} s foreseen, {saved:.2} s saved of {:.2} s", totals.seconds());
    assert!(cost > 1.0 && (cost - saved).abs() <= 0.02 * saved + 0.05, "{cost} and {saved}");
}
