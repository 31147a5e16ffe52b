//! G38 as senders of GRBL stream it, with the lines that count on what it finds right behind it.

use scenarios::{Bench, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator::{Beta, Gamma};

use super::plan;

fn with_probe() -> Plan {
    plan().set("[zprobe] enable = true").set("[zprobe] probe_pin = PB10^").set("[zprobe] slow_feedrate = 1")
}

fn at_z10(plan: Plan) -> Bench {
    let mut bench = plan.start();
    bench.run(&["$H", "G1 Z10 F3000", "G4 P0"]);
    bench
}

/// A zero that is set from a search that has not been made lies where the tool happened to stand.
#[test]
fn a_search_that_cannot_begin_halts_and_refuses_what_was_sent_behind_it() {
    let closed = || at_z10(with_probe().fault("switch-always:probe@0.1"));
    let open = || at_z10(with_probe());
    let none = || at_z10(plan());
    for (mut bench, search) in [
        (closed(), "G38.2 Z-5"),
        (closed(), "G38.3 Z-5"),
        (open(), "G38.4 Z5"),
        (open(), "G38.5 Z5"),
        (none(), "G38.2 Z-5"),
    ] {
        let before = bench.say("$#");
        bench.type_in(&format!("G91 {search} F100\nG10 L20 P1 Z12\nG0 Z3\n"));
        let said = bench.hear(3.0);
        assert!(said.contains("\nALARM:4\n") && said.matches("error:9\n").count() >= 2, "{search}: {said}");
        assert!((bench.carriage(Gamma) - 10.0).abs() < 0.01, "{search}: it has moved");
        bench.say("$X");
        assert_eq!(bench.say("$#"), before, "{search}");
        bench.run(&["G90 G1 Z11 F600", "G4 P0"]);
    }
}

/// A file waits for its operator as ever, and he goes on or does not.
#[test]
fn a_file_waits_where_its_search_cannot_begin() {
    let file = "G91 G38.2 Z-5 F100\nG10 L20 P1 Z12\n";
    let mut bench = at_z10(with_probe().fault("switch-always:probe@0.1").file("part.nc", file));
    let before = bench.say("$#");
    bench.type_in("play part.nc\n");
    let said = bench.hear(3.0);
    assert!(said.contains("paused, line 1 of") && !said.contains("ALARM"), "{said}");
    assert_eq!(bench.say("$#"), before);
}

#[test]
fn words_without_a_code_go_on_searching_as_in_rs_274() {
    let mut bench = at_z10(with_probe());
    bench.run(&["G91"]);
    assert!(bench.say("G38.3 Z-2 F100").contains(":0]"));
    let modes = bench.say("$G");
    assert!(modes.contains("[GC:G38.3 ") && modes.contains(" F100 "), "{modes}");
    let (begun, y) = (bench.now_s(), bench.carriage(Beta));
    assert!(bench.say("F300 Y3").contains(":0]"), "a search");
    assert!((bench.carriage(Beta) - y - 3.0).abs() < 0.02);
    let took = bench.now_s() - begun;
    assert!((0.5..1.5).contains(&took), "at 5 mm/s, not as a rapid: {took}");
    // The axis stops at the contact. A rate alone, and a speed of the spindle, search nothing.
    bench.lay(Surface { bed: Some(Bed::level(7.5)), ..Surface::default() });
    bench.run(&["F120", "S100"]);
    assert!(bench.say("G94 Z-3").contains(":1]"));
    assert!((bench.carriage(Gamma) - 7.5).abs() < 0.01);
    assert!(bench.say("G38.3").contains("error:26"), "a search without a way is none");
    bench.run(&["G0 Z2", "Z1", "G4 P0"]);
    assert!((bench.carriage(Gamma) - 10.5).abs() < 0.01 && bench.say("$G").contains("[GC:G0 "));
    bench.say("G38.3 Y1 F100");
    bench.run(&["M2"]);
    assert!(bench.say("$G").contains("[GC:G1 "));
}
