//! `$J=`, and what ends it.

use units::Actuator::Alpha;

use super::{Wait, refused, start};

#[test]
fn a_jog_has_its_own_units_and_distance_mode_and_one_ok() {
    let mut bench = start();
    bench.run(&["$H", "G90 G21 G1 X10 F6000", "G4 P0"]);
    for (jog, x) in [
        ("$J=G91 X5 F3000", 15.0),
        ("$J=G91X-5F3000", 10.0),
        ("$J=G90 G21 X20 F3000", 20.0),
        ("$J=G20G91X1F100", 45.4),
        ("$J=G53 X30 F3000", 30.0),
    ] {
        bench.run(&[jog]);
        bench.hear_until_idle();
        assert!((bench.carriage(Alpha) - x).abs() < 0.02, "{jog}: {}", bench.carriage(Alpha));
    }
    let said = bench.say("$G");
    assert!(
        said.contains("[GC:G1 ") && said.contains(" G21 ") && said.contains(" G90 "),
        "a jog changed modes: {said}"
    );
    // The program goes on from where the jogs ended.
    bench.run(&["G91 G1 X1 F3000", "G4 P0"]);
    assert!((bench.carriage(Alpha) - 31.0).abs() < 0.02);
}

#[test]
fn what_is_no_jog_is_refused_and_moves_nothing() {
    let mut bench = start();
    bench.run(&["$H", "G1 X10 F6000", "G4 P0"]);
    for (line, number) in [
        ("$J=X1", 22),
        ("$J=F100", 26),
        ("$J=G1 X1 F100", 16),
        ("$J=X1 F100 M3", 16),
        ("$J=X9999 F100", 15),
        ("$J=X1 F100 $", 1),
        ("$J", 3),
        ("$JX1 F100", 3),
    ] {
        refused(&mut bench, line, number);
    }
    assert!(bench.status().starts_with("<Idle|"), "a jog out of travel is no alarm");
    bench.run(&["G1 X30 F600"]);
    refused(&mut bench, "$J=G91 X1 F100", 8);
    bench.hear_until_idle();
    assert!((bench.carriage(Alpha) - 30.0).abs() < 0.02);
}

/// Pendants made for Smoothieware's `grbl_mode` go on working.
#[test]
fn a_jog_with_a_blank_is_that_of_smoothieware() {
    let mut bench = start();
    bench.run(&["$H", "G1 X10 F6000", "G4 P0", "$J X5 F3000"]);
    bench.hear_until_idle();
    assert!((bench.carriage(Alpha) - 15.0).abs() < 0.02, "a distance: {}", bench.carriage(Alpha));
    refused(&mut bench, "$J Q1", 20);
    bench.type_in("$J -c X-1 F3000\n");
    assert_eq!(bench.hear(0.2), "", "it goes on");
    bench.send(b"\x19");
    assert_eq!(bench.hear(0.5), "ok\n");
    assert!(bench.carriage(Alpha) < 14.0 && bench.status().starts_with("<Idle|"), "{}", bench.carriage(Alpha));
    bench.send(b"\x18");
    bench.hear(0.2);
    bench.type_in("M112\n");
    bench.hear(0.2);
    refused(&mut bench, "$J X1", 9);
}

#[test]
fn a_jog_is_cancelled_at_once_and_the_place_is_known() {
    for stop in [&b"\x85"[..], b"!"] {
        let mut bench = start();
        bench.run(&["$H", "$J=G91 X100 F1800", "$J=G91 Y100 F1800"]);
        bench.hear(1.0);
        assert!(bench.status().starts_with("<Jog|"), "{}", bench.status());
        refused(&mut bench, "G1 X5 F600", 9);
        bench.send(stop);
        bench.hear(0.5);
        let status = bench.status();
        assert!(status.starts_with("<Idle|"), "{status}");
        let x = bench.carriage(Alpha);
        assert!((30.0..40.0).contains(&x), "{x}");
        bench.run(&["$J=G91 X1 F600"]);
        bench.hear_until_idle();
        assert!((bench.carriage(Alpha) - x - 1.0).abs() < 0.02);
        bench.run(&["G91 G1 X1 F600", "G4 P0"]);
        assert!((bench.carriage(Alpha) - x - 2.0).abs() < 0.02);
    }
}

/// Many short jogs, as from a pendant, with the byte that ends them in their midst: none of them goes on.
#[test]
fn jogs_that_wait_for_room_end_with_the_others() {
    let mut bench = start();
    bench.run(&["$H"]);
    let jogs = "$J=G91 X0.1 F600\n".repeat(200);
    bench.type_in(&jogs);
    let mut said = bench.hear(1.0);
    bench.send(b"\x85");
    said += &bench.hear(3.0);
    assert_eq!(said, "ok\n".repeat(200));
    assert!(bench.status().starts_with("<Idle|"));
}
