//! Jogging by `$J=`, and the commands that end it.

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
    // In a second the axis moves 10 mm, at 10 mm/s. Jogs that were received and not read do not continue
    // either.
    assert!((8.0..12.0).contains(&bench.carriage(Alpha)), "{}", bench.carriage(Alpha));
    bench.run(&["$J=G91 X1 F600"]);
}

/// Longer ones, of which the look-ahead takes few seconds' worth; and the same by Ctrl-Y and `!`.
#[test]
fn jogs_that_were_received_and_not_read_are_dropped() {
    for stop in [&b"\x85"[..], b"\x19", b"!"] {
        let mut bench = start();
        bench.run(&["$H"]);
        bench.type_in(&"$J=G91 X0.5 F1500\n".repeat(150));
        let mut said = bench.hear(0.1);
        bench.send(stop);
        said += &bench.hear(3.0);
        assert_eq!(said, "ok\n".repeat(150), "{stop:?}: each is answered");
        let x = bench.carriage(Alpha);
        assert!(x < 5.0 && bench.status().starts_with("<Idle|"), "{stop:?}: {x}");
        // Lines that are no jogs are carried out, and jogs behind the byte.
        bench.send(b"G90\n$J=G91 X0.5 F1500\n\x85G91\n$J=G91 X2 F1500\n");
        bench.hear(2.0);
        assert!((bench.carriage(Alpha) - x - 2.0).abs() < 0.02, "{stop:?}: {}", bench.carriage(Alpha));
        assert!(bench.say("$G").contains(" G91 "));
    }
}

/// Smoothieware's own jogs, in its own dialect: what is planned is made, as there, and no more of 75 mm.
#[test]
fn ctrl_y_drops_smoothiewares_jogs_too() {
    let mut bench = scenarios::Plan::new(scenarios::CARTESIAN).start_homed();
    bench.type_in(&"$J -r X0.5 F1500\n".repeat(150));
    let mut said = bench.hear(0.3);
    bench.send(b"\x19");
    said += &bench.hear(5.0);
    assert_eq!(said.matches("ok\n").count(), 150, "{said}");
    bench.hear_until_idle();
    assert!(bench.carriage(Alpha) < 30.0, "{}", bench.carriage(Alpha));
}
