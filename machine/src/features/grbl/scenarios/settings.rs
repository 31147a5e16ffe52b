//! Settings by `$$`, `$n=`, `$N`, `$RST` and `$I=`: values that are kept, and values that are refused.

use scenarios::Bench;
use units::Actuator::Alpha;

use super::{BANNER, LOCKED, plan, refused, start};

/// Returns a line `$n` of `$$`.
#[track_caller]
fn setting(bench: &mut Bench, number: u16) -> String {
    let said = bench.say("$$");
    let line = said.lines().find_map(|line| line.strip_prefix(&format!("${number}=")));
    line.unwrap_or_else(|| panic!("no ${number} in {said}")).into()
}

#[test]
fn settings_are_listed_in_grbls_order_and_form() {
    let mut bench = start();
    let said = bench.say("$$");
    let numbers: Vec<u16> = said
        .lines()
        .filter(|line| *line != "ok")
        .map(|line| {
            let (number, value) = line.strip_prefix('$').and_then(|line| line.split_once('=')).expect("a setting");
            assert!(value.parse::<f64>().is_ok(), "{line}");
            number.parse().expect("its number")
        })
        .collect();
    assert!(numbers.is_sorted() && numbers.len() == 34, "{numbers:?}");
    assert!(said.ends_with("\nok\n"));
    assert_eq!(setting(&mut bench, 100), "80.000");
    assert_eq!(bench.say("$"), "[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\nok\n");
}

#[test]
fn a_setting_acts_at_once_and_outlives_the_reset() {
    let mut bench = start();
    for (number, value) in [(100, "160.000"), (111, "1200.000"), (122, "50.500"), (11, "0.025"), (10, "3"), (13, "1")] {
        let line = format!("${number}={value}");
        assert_eq!(bench.say(&line), "ok\n", "{line}");
        assert_eq!(setting(&mut bench, number), value, "{line}");
    }
    // Twice the steps, so twice the carriage's way. Reports are in inches, settings are not.
    let from = bench.carriage(Alpha);
    bench.run(&["G21 G91 G1 X10 F600", "G4 P0"]);
    assert!((bench.carriage(Alpha) - from - 20.0).abs() < 0.02, "{}", bench.carriage(Alpha));
    let saved = bench.read_card("config-override").expect("what M500 saves");
    assert!(saved.contains("M92 X160.0") && saved.contains("M203 ") && saved.contains(" Y20.0"), "{saved}");
    let own = bench.read_card("grbl-settings").expect("the dialect's own");
    let mut bench = plan().file("config-override", &saved).file("grbl-settings", &own).start();
    bench.hear(0.5);
    for (number, value) in [(100, "160.000"), (111, "1200.000"), (122, "50.500"), (11, "0.025"), (10, "3"), (13, "1")] {
        assert_eq!(setting(&mut bench, number), value, "${number} after the reset");
    }
}

#[test]
fn in_inches_a_setting_is_in_mm_all_the_same() {
    let mut bench = start();
    bench.run(&["G20", "$110=3000", "$120=40"]);
    assert_eq!((setting(&mut bench, 110), setting(&mut bench, 120)), ("3000.000".into(), "40.000".into()));
    assert!(bench.say("$G").contains(" G20 "));
}

#[test]
fn what_cannot_be_set_is_refused_with_its_place_in_the_configuration() {
    let mut bench = start();
    assert!(refused(&mut bench, "$24=1", 3).contains("[endstops] slow_rate"));
    for (line, number) in [("$100=", 2), ("$100=x", 2), ("$100=-1", 4), ("$7=1", 3), ("$32=1", 17), ("$100", 3)] {
        refused(&mut bench, line, number);
    }
    assert_eq!(setting(&mut bench, 100), "80.000");
    // A backup that says what is so anyway is accepted whole.
    let backup = bench.say("$$");
    for line in backup.lines().filter(|line| *line != "ok") {
        assert_eq!(bench.say(line), "ok\n", "{line}");
    }
    bench.run(&["G1 X30 F600"]);
    refused(&mut bench, "$100=90", 8);
    assert_eq!(bench.read_card("config-override"), None, "nothing has changed");
}

#[test]
fn soft_limits_can_be_switched_off() {
    let mut bench = start();
    bench.run(&["$H", "$20=0"]);
    assert_eq!(setting(&mut bench, 20), "0");
    bench.run(&["G1 X-1 F600", "G1 X0", "G4 P0", "$20=1"]);
    refused(&mut bench, "$J=X-5 F600", 15);
}

#[test]
fn defaults_come_back() {
    let mut bench = start();
    bench.run(
        &["$100=160", "$10=2", "$N0=G55", "G10 L2 P1 X5", "$RST=$"]
            .map(|line| if line.starts_with("$RST") { "G4 P0" } else { line }),
    );
    assert_eq!(bench.say("$RST=$"), "[MSG:Restoring defaults]\nok\n");
    assert_eq!((setting(&mut bench, 100), setting(&mut bench, 10)), ("80.000".into(), "1".into()));
    assert!(bench.say("$#").contains("[G54:5.000,0.000,0.000]\n"), "offsets are no settings");
    assert_eq!(bench.say("$RST=#"), "[MSG:Restoring defaults]\nok\n");
    assert!(bench.say("$#").contains("[G54:0.000,0.000,0.000]\n"));
    assert!(bench.say("$N").starts_with("$N0=G55\n$N1=\n"));
    bench.say("$RST=*");
    assert_eq!(bench.say("$N"), "$N0=\n$N1=\nok\n");
    refused(&mut bench, "$RST=x", 3);
}

#[test]
fn startup_lines_run_at_boot_and_behind_a_reset() {
    let mut bench = start();
    bench.run(&["$N0=G20 G55", "$N1=G1 X30 F20", "$I=my mill"]);
    refused(&mut bench, "$N0=G999", 20);
    refused(&mut bench, "$N0=X@", 2);
    refused(&mut bench, &format!("$N0={}", "G21 ".repeat(30)), 14);
    assert!(bench.say("$G").contains(" G54 ") && !bench.moves(), "it is carried out now");
    let own = bench.read_card("grbl-settings").expect("the dialect's own");
    let mut bench = plan().file("grbl-settings", &own).start();
    let greeting = bench.greeting().to_owned() + &bench.hear(0.1);
    assert!(greeting.ends_with(&format!("{BANNER}>G20 G55:ok\n>G1 X30 F20:ok\n")), "{greeting}");
    assert!(bench.say("$G").contains(" G55 ") && bench.moves());
    assert!(bench.say("$I").starts_with("[VER:1.1f.20170801:my mill]\n[OPT:VNMH,"));
    bench.type_in("\x18");
    let said = bench.hear(1.0);
    assert!(said.ends_with(&format!("{BANNER}{LOCKED}")), "an alarm runs no startup line: {said}");
    bench.say("$X");
    bench.type_in("\x18");
    assert_eq!(bench.hear(0.5), format!("{BANNER}>G20 G55:ok\n>G1 X30 F20:ok\n"));
}
