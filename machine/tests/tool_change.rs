//! M6 and M0 in a file: the machine stands until the operator has done his part, with the rest of the line.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta, Gamma};

/// No extruder: T and M6 are about the spindle's tool.
const MILL: &str = include_str!("../../config/samples/cnc-mill.ini");

/// A machine, and the initial places of its carriages.
struct Shop {
    bench: Bench,
    zero: [f64; 3],
}

impl Shop {
    fn open(plan: Plan) -> Self {
        let bench = plan.start();
        let zero = [Alpha, Beta, Gamma].map(|motor| bench.carriage(motor));
        Self { bench, zero }
    }

    #[track_caller]
    fn stands_at(&self, place: [f64; 3]) {
        let now = [Alpha, Beta, Gamma].map(|motor| self.bench.carriage(motor));
        for ((now, zero), mm) in now.into_iter().zip(self.zero).zip(place) {
            assert!((now - zero - mm).abs() < 0.02, "{now} - {zero}, not {mm}");
        }
    }
}

fn mill(part: &str) -> Plan {
    Plan::new(MILL).file("part.nc", &format!("G28.3 X0 Y0 Z0\nG21 G90 G94 F600\n{part}"))
}

#[test]
fn what_stands_behind_m6_in_its_line_waits_for_the_operator() {
    let mut shop = Shop::open(mill("G0 X5\nT2 M6 G0 X9\nG0 Y3\n"));
    shop.bench.say("play part.nc -t");
    let heard = shop.bench.hear(3.0);
    assert!(heard.contains("put in tool 2 (M6): ~ or M24 goes on"), "{heard}");
    shop.stands_at([5.0, 0.0, 0.0]);
    // The operator may jog and touch off meanwhile.
    shop.bench.run(&["$J=G91 X1 F600"]);
    shop.bench.hear(1.0);
    shop.stands_at([6.0, 0.0, 0.0]);
    assert!(!shop.bench.hear(5.0).contains("Done"));
    shop.bench.send(b"~");
    shop.bench.hear_until("Done printing file", 10.0);
    shop.stands_at([9.0, 3.0, 0.0]);
}

#[test]
fn scripts_stand_before_and_behind_the_operator_s_part() {
    let scripts = ["[tool change] before_gcode = G53_G0_Y5", "[tool change] after_gcode = G53_G0_Y2_G4_P0.1"];
    let plan = scripts.into_iter().fold(mill("T1 M6 G0 X9\n"), Plan::set);
    let mut shop = Shop::open(plan);
    shop.bench.say("play part.nc -t");
    let heard = shop.bench.hear(3.0);
    assert!(heard.contains("put in tool 1 (M6)"), "{heard} {}", shop.bench.status());
    shop.stands_at([0.0, 5.0, 0.0]);
    shop.bench.run(&["M24"]);
    shop.bench.hear_until("Done printing file", 10.0);
    shop.stands_at([9.0, 2.0, 0.0]);
    // At a console the line waits.
    shop.bench.type_in("T3 M6 G0 X1\n");
    let heard = shop.bench.hear(2.0);
    assert!(heard.contains("put in tool 3 (M6): ~ goes on") && !heard.contains("ok\n"), "{heard}");
    shop.stands_at([9.0, 5.0, 0.0]);
    shop.bench.send(b"~");
    shop.bench.hear_until("ok\n", 5.0);
    shop.bench.hear(2.0);
    shop.stands_at([1.0, 2.0, 0.0]);
}

#[test]
fn a_changer_asks_nobody() {
    let plan = mill("T1 M6 G0 X9\n").set("[tool change] prompt = false");
    let mut shop = Shop::open(plan.set("[tool change] before_gcode = G53_G0_Y5"));
    shop.bench.say("play part.nc -t");
    let heard = shop.bench.hear_until("Done printing file", 10.0);
    assert!(!heard.contains("put in tool"), "{heard}");
    shop.stands_at([9.0, 5.0, 0.0]);
}

#[test]
fn a_job_that_is_aborted_there_makes_nothing_more() {
    for end in ["abort", "M112"] {
        let plan = mill("T1 M6 G0 X9\nG0 Y9\n").set("[tool change] after_gcode = G53_G0_Y2");
        let mut shop = Shop::open(plan);
        let heard = shop.bench.say("play part.nc -t") + &shop.bench.hear(2.0);
        assert!(heard.contains("put in tool 1"), "{end}: {heard}");
        shop.bench.say(end);
        shop.bench.send(b"~");
        shop.bench.hear(5.0);
        shop.stands_at([0.0, 0.0, 0.0]);
        shop.bench.say("$X");
        assert!(shop.bench.say("G0 X2").ends_with("ok\n"), "{end}");
        shop.bench.hear(2.0);
        shop.stands_at([2.0, 0.0, 0.0]);
    }
}

/// Smoothieware's dialect carries codes out as they stand.
#[test]
fn what_stands_behind_m0_waits_too() {
    let part = "G28.3 X0 Y0\nG1 X5 F600 M0 G1 X9\n";
    let mut shop = Shop::open(Plan::new(CARTESIAN).file("part.g", part));
    shop.bench.say("play part.g -t");
    shop.bench.hear(3.0);
    shop.stands_at([5.0, 0.0, 0.0]);
    shop.bench.run(&["M24"]);
    shop.bench.hear_until("Done printing file", 10.0);
    shop.stands_at([9.0, 0.0, 0.0]);
}
