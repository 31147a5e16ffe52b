//! Codes and commands that Smoothieware v2 has, on a whole machine; and what makes v2 itself hang or lose
//! something, which ours does not.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Gamma};

fn start() -> Bench {
    Plan::new(CARTESIAN).start()
}

fn with_probe() -> Bench {
    let plan = ["enable = true", "probe_pin = PB10^", "slow_feedrate = 5", "max_travel = 40"];
    plan.iter().fold(Plan::new(CARTESIAN), |plan, line| plan.set(&format!("[zprobe] {line}"))).start()
}

// --- positions ---

#[test]
fn motors_are_said_to_be_elsewhere() {
    let mut bench = start();
    bench.run(&["G28.4 X12 Y3 Z4"]);
    assert_eq!(bench.say("M114.3"), "ok APOS: X:12.0000 Y:3.0000 Z:4.0000 E:0.0000 \n");
    assert_eq!(bench.say("G28.6"), "X:1 Y:1 Z:1 \nok\n");
    // The code sets only the axes that are named.
    bench.run(&["G28.5", "G28.4 Y7"]);
    assert_eq!(bench.say("G28.6"), "X:0 Y:1 Z:0 \nok\n");
}

#[test]
fn m306_has_this_place_read_as_given_from_the_next_homing_on() {
    let mut bench = start();
    assert_eq!(bench.say("M306 X1"), "error:Axis X must be homed before setting Homing offset\n");
    bench.run(&["G28", "G1 X10 F3000", "M400"]);
    let said = bench.say("M306 X12.5");
    assert_eq!(said, "// Homing Offset: X 2.500 Y 0.000 Z 0.000 will take effect next home\nok\n");
    assert_eq!(bench.say("G28.6"), "X:0 Y:1 Z:1 \nok\n");
    let carriage = bench.carriage(Alpha);
    bench.run(&["G28 X0", "G1 X12.5 F3000", "M400"]);
    assert!((bench.carriage(Alpha) - carriage).abs() < 0.02, "the same place reads 12.5 now");
    assert!(bench.say("M503").contains("M206 X2.50 "));
    // In the units of the program; M206 is mm.
    bench.run(&["G20"]);
    assert!(bench.say("M306 X1").starts_with("// Homing Offset: X 15.400 "));
    assert!(bench.say("M206 X2.5").ends_with("ok\n"));
    assert!(bench.say("M503").contains("M206 X2.50 "));
}

#[test]
fn g30_parks_at_its_own_position_where_the_configuration_says_so() {
    let plan = Plan::new(CARTESIAN).set("[general] grbl_mode = true").set("[motion control] nist_G30 = true");
    let mut bench = plan.start();
    bench.say("$H");
    let undefined = bench.say("G30");
    assert!(undefined.contains("Use G30.1 to define it"), "{undefined}");
    for line in ["G90 G0 X20 Y30 Z5", "G4 P0.5", "G30.1", "G0 X1 Y1 Z1", "G30", "G4 P0.5"] {
        assert!(bench.say(line).ends_with("ok\n"), "{line}");
    }
    assert!((bench.carriage(Alpha) - 20.0).abs() < 0.02 && (bench.carriage(Gamma) - 5.0).abs() < 0.02);
    assert!(bench.say("$#").contains("[G30:20.000,30.000,5.000]"));
    assert!(bench.say("M503").contains("G30.1 X20.0000 Y30.0000 Z5.0000"));
    // P searches, also there; without a probe that is refused.
    assert!(!bench.say("G30 P1").contains("Use G30.1"));
}

#[test]
fn of_two_numbers_m110_takes_its_dialects() {
    let mut bench = start();
    let numbered = |line: &str| format!("{line}*{}", line.bytes().fold(0, |sum, byte| sum ^ byte));
    for (dialect, expected) in [("smoothie", 1), ("marlin", 6)] {
        bench.say(&format!("dialect {dialect}"));
        assert_eq!(bench.say(&numbered("N0 M110 N5")), "ok\n");
        assert_eq!(bench.say(&numbered("N100 M105")), format!("rs N{expected}\n"), "{dialect}");
        assert_eq!(bench.say("M110 N7"), "ok\n");
        assert_eq!(bench.say(&numbered("N100 M105")), "rs N8\n", "{dialect}");
    }
}

#[test]
fn an_offset_is_set_of_a_system_that_is_named() {
    for (dialect, error) in [("smoothie", "error:Must supply P, column 1\n"), ("marlin", "ok\n")] {
        let mut bench = start();
        bench.say(&format!("dialect {dialect}"));
        assert_eq!(bench.say("G10 L20 X5"), error, "{dialect}");
    }
}

// --- sensors and drivers ---

#[test]
fn a_sensor_is_described_anew_and_saved() {
    let mut bench = start();
    assert!(bench.say("M305").contains("T(S0): using PID"));
    assert_eq!(bench.say("M305 S0 B4000 R100000 X25"), "ok\n");
    let saved = bench.say("M503");
    assert!(saved.contains("M305 S0 B4000.000000000000 R100000.000000000000 X25.000000000000\n"), "{saved}");
    assert_eq!(bench.say("M305 S0 P1"), "ok\n");
    assert!(bench.say("M305").contains("Using predefined thermistor 1 in S/H table: EPCOS100K"));
    assert_eq!(bench.say("M305 S0 I0.0007 J0.0002 K0.0000001"), "ok\n");
    for (line, why) in [
        ("M305 S0 B4000 P1", "nothing of another kind"),
        ("M305 S0 P77", "P is the number of no sensor"),
        ("M305 S9 B4000", "no temperature control has tool_id 9"),
    ] {
        assert!(bench.say(line).contains(why), "{line}");
    }
    // Without other words the code restores the configured sensor.
    assert_eq!(bench.say("M305 S0"), "ok\n");
    assert!(!bench.say("M503").contains("M305"));
    bench.run(&["M104 S60"]);
    bench.hear(0.5);
    assert!(bench.say("M305 S0 P1").contains("the heater is on"), "what it is measured by stays while it heats");
}

#[test]
fn m305_never_changes_a_temperature_in_silence() {
    let mut bench = start();
    let before = bench.say("M305");
    // The sensor has coefficients: no beta is known that a resistance would fit.
    for line in ["M305 S0 R10000", "M305 S0 X30", "M305 S0 R10000 X30"] {
        assert!(bench.say(line).contains("M305: R and X need B"), "{line}");
    }
    assert_eq!(bench.say("M305"), before);
    // A single coefficient in a code changes only that one.
    let said = bench.say("M305 S0 I0.0008");
    assert_eq!(said, "ok\n");
    let said = bench.say("M305");
    assert!(said.contains("S/H c1= 0.000800000000, c2= 0.000213433144, c3= 0.000000065339\n"), "{said}");
    assert_eq!(bench.say("M305 S0 B4000"), "// NOTE it has 100000 Ohm at 25.0 C\nok\n");
    assert!(bench.say("M305 S0 J0.0002").contains("I, J and K are needed"));
    assert_eq!(bench.say("M305 S0 R90000"), "ok\n");
    assert!(bench.say("M503").contains("M305 S0 B4000.000000000000 R90000.000000000000 X25.000000000000\n"));
    // A sensor of the table comes with the resistors that it is meant for, and with its beta.
    assert_eq!(bench.say("M305 S0 P131"), "// NOTE its divider is now r1 = 680 Ohm, r2 = 1600 Ohm\nok\n");
    assert!(bench.say("M503").contains("M305 S0 P131.000000000000\n"));
    assert_eq!(bench.say("M305 S0 R11000"), "// NOTE its divider is now r1 = 0 Ohm, r2 = 4700 Ohm\nok\n");
    let saved = bench.say("M503");
    assert!(saved.contains("M305 S0 B3964.000000000000 R11000.000000000000 X25.000000000000\n"), "{saved}");
}

#[test]
fn microsteps_and_registers_change_until_the_next_reset() {
    let mut bench = start();
    let before: f64 = steps(&bench.say("M92"));
    assert_eq!(bench.say("M909 X64"), "microsteps for X temporarily changed to: 1/64\nok\n");
    assert_eq!(steps(&bench.say("M92")), before);
    let said = bench.say("M909.1 X32");
    assert!(said.contains("microsteps for X temporarily changed to: 1/32\nsteps/mm for X temporarily changed to: "));
    assert_eq!(steps(&bench.say("M92")), before / 2.0);
    assert!(bench.say("M909 X5").contains("cannot be set so"));
    assert_eq!(bench.say("M911.1 P0"), "X,0,5,54,5,0,0\nok\n");
    assert_eq!(bench.say("M911.3 P0 S1 U4 V36 W6 X2 Y1"), "ok\n");
    assert_eq!(bench.say("M911.1 P0"), "X,0,4,36,6,2,1\nok\n");
    assert_eq!(bench.say("M911.3 P0 S4 Z1"), "ok\n");
    assert!(bench.say("M911 P0").contains("Step interpolation is on"));
    assert!(bench.say("M911.3 P0 S3 Z0").starts_with("error:"), "double edges are what the step engine counts on");
    assert_eq!(bench.say("M911.2 P0 R1 V4"), "ok\n");
    assert!(bench.say("M911 P0").contains("driver control register: 00104("), "and stay, whatever is written");
    assert!(bench.say("M911.2").contains("R255"));
    assert_eq!(bench.say("setregs X 00003,901B4,A0000,D0A0D,EF072"), "registers temporarily set for motor 0\nok\n");
    assert!(bench.say("M911 P0").contains("config-set tmc2590 alpha.reg = 00103,901B4,A0000,D0A0D,EF072"));
}

fn steps(said: &str) -> f64 {
    said.split([' ', ':']).nth(1).and_then(|word| word.parse().ok()).expect("steps")
}

#[test]
fn the_flow_of_filament_has_its_limit() {
    let mut bench = Plan::new(CARTESIAN).set("[extruder] hotend.filament_diameter = 1.75").start();
    bench.run(&["M83", "G91", "G1 X10 E10 F3000", "M203 V2"]);
    bench.run(&["M400"]);
    let began = bench.now_s();
    bench.run(&["G1 X10 E10", "M400"]);
    let took = bench.now_s() - began;
    assert!((5.0..5.3).contains(&took), "10 mm3 at 2 mm3/s took {took} s");
    for code in ["M404", "M405", "M406", "M407"] {
        assert!(bench.say(code).contains("ignored"), "{code}");
    }
    assert!(bench.say("M221 R1000").contains("(not there yet)"));
}

// --- files ---

#[test]
fn files_are_copied_cut_and_summed() {
    let plan = Plan::new(CARTESIAN).file("a.g", &"G1 X1\nG1 X2\n".repeat(200));
    let mut bench = plan.start();
    bench.run(&["cp a.g \"b c.g\""]);
    assert_eq!(bench.read_card("b c.g"), bench.read_card("a.g"));
    assert_eq!(bench.say("truncate \"b c.g\" 12"), "File b c.g truncated to 12 bytes\nok\n");
    assert_eq!(bench.read_card("b c.g").as_deref(), Some("G1 X1\nG1 X2\n"));
    assert_eq!(bench.read_card("previous-b c.g"), None, "nothing stays behind");
    // RFC 1321 calls it the digest of nothing.
    bench.write_card("empty", b"");
    assert_eq!(bench.ask("md5sum empty nosuch"), "d41d8cd98f00b204e9800998ecf8427e empty\nFile not found: nosuch\n");
    assert_eq!(bench.say("cp nosuch x"), "File nosuch does not exist\nok\n");
    assert!(bench.say("cp a.g a.g").contains("the file is in use"));
    bench.type_in("cat -d \"b c.g\"\n");
    assert_eq!(bench.hear(4.5), "", "time to begin recording");
    assert_eq!(bench.hear(1.0), "G1 X1\nG1 X2\n\x1a\n");
    assert_eq!(bench.ask("echo -n part"), "partok\n");
    assert!(bench.ask("modules").contains("extruder: hotend\n"));
    assert!(bench.say("thermistors").contains("129 - EPCOS100K\n"));
    let said = bench.say("calc_thermistor 25,100000,150,1641.9,250,226.15");
    assert!(said.starts_with("Steinhart Hart coefficients:  I0.0007"), "{said}");
    assert!(bench.say("calc_thermistor 25").starts_with("error:usage"));
}

#[test]
fn the_clock_is_set_and_goes_on() {
    let mut bench = start();
    assert!(bench.say("date").starts_with("2000-01-01 00:00:0"), "nobody has set it");
    bench.run(&["date 260102030405"]);
    bench.hear(3.0);
    assert_eq!(bench.say("date"), "2026-01-02 03:04:08\nok\n");
    assert_eq!(bench.say("get fk 1,2,3"), "cartesian= X 1.000000, Y 2.000000, Z 3.000000\nok\n");
    assert_eq!(bench.say("get ik 10"), "actuator= X 10.000000, Y 10.000000, Z 10.000000\nok\n");
    assert_eq!(bench.ask("$S fan"), "switch fan is 0\n");
}

// --- what v2 itself does not survive ---

#[test]
fn what_hangs_v2_is_refused_or_done() {
    let mut bench = with_probe();
    for code in ["G29", "G31", "G32"] {
        assert_eq!(bench.say(code), format!("error:No strategy found to handle {code}\n"));
    }
    assert_eq!(bench.say("date 26"), "error:write date YYMMDDhhmmss\n");
    assert!(bench.say("G4 P-1").starts_with("error:a dwell lasts 0 to"));
    let told = bench.say("break");
    assert!(told.starts_with("no debugger is attached\n") && told.contains("config.ini was read"), "{told}");
    let name = "a name of much more than fifteen characters.gcode";
    assert_eq!(bench.say(&format!("M28 {name}")), format!("Writing to file: {name}\nok\n"));
    bench.run(&["G4 P1"]);
    assert!(bench.say("M29").starts_with("Done saving file."));
    assert_eq!(bench.read_card(name).as_deref(), Some("G4 P1\n"));
    assert!(bench.say("M105").starts_with("ok "), "it still answers");
}

#[test]
fn what_is_typed_ahead_keeps_its_lines() {
    let mut bench = start();
    bench.type_in("M109 S40\nM143 S0 P60\nM105\nM114\nM114\n");
    let said = bench.hear_until("C: X:0.0000 Y:0.0000 Z:0.0000 E:0.0000 \nok C:", 60.0) + &bench.hear(0.1);
    assert!(!said.contains("WARNING"), "no two lines are one: {said}");
    assert_eq!(said.matches("ok C: X:0.0000 Y:0.0000 Z:0.0000 E:0.0000 \n").count(), 2, "{said}");
    bench.run(&["M104 S0"]);
}

#[test]
fn a_file_keeps_its_last_line_and_loses_the_ends_of_the_others() {
    let file = "G28.3 X0 Y0 Z0\r\nG1 X10 F6000\r\nmkdir new\r\nG1 X15";
    let mut bench = Plan::new(CARTESIAN).file("a.g", file).start();
    bench.say("play a.g");
    bench.hear(2.0);
    assert!(bench.say("M114").contains(" X:15.0000 "), "a last line without an end is whole");
    let listed = bench.say("ls");
    assert!(listed.contains(" 0  new\n"), "no CR is a part of a name: {listed:?}");
    bench.write_card("b.g", b"G1 X20 F300\nG1 X30\n");
    bench.say("play b.g -t");
    bench.hear(0.5);
    bench.type_in("abort\n");
    let said = bench.hear(3.0);
    assert!(!said.contains("Done printing file"), "it is not done: {said}");
}

#[test]
fn m306_sets_all_that_it_names_or_nothing() {
    let mut bench = start();
    bench.run(&["G28 X"]);
    assert_eq!(bench.say("M306 X5 Y3"), "error:Axis Y must be homed before setting Homing offset\n");
    assert!(bench.say("M206").starts_with("X: 0.000 Y: 0.000 "));
}

#[test]
fn a_halt_ends_a_dwell() {
    let mut bench = start();
    bench.type_in("G4 S100\n");
    bench.hear(0.5);
    bench.send(b"\x18");
    assert!(bench.hear(1.0).contains("!!"), "its line is answered");
    assert!(bench.say("M999").ends_with("ok\n"));
}

#[test]
fn an_upload_stores_what_v2_carries_out() {
    let mut bench = Plan::new(CARTESIAN).file("b.g", "G4 P1\n").start();
    bench.say("M28 a.g");
    for line in ["M23 b.g", "M30 b.g", "M32 b.g", "M117 text"] {
        assert_eq!(bench.say(line), "ok\n");
    }
    bench.say("M29");
    assert_eq!(bench.read_card("a.g").as_deref(), Some("M23 b.g\nM30 b.g\nM32 b.g\nM117 text\n"));
    assert!(bench.read_card("b.g").is_some(), "nothing was removed");
}

#[test]
fn a_contact_is_said_in_the_units_of_the_program() {
    let mut bench = with_probe();
    bench.run(&["G28", "G1 Z10 F600", "G28.4 Z30"]);
    assert!(bench.say("G38.2 Z-20").starts_with("[PRB:"));
    let probed = |bench: &mut Bench| -> f64 {
        let said = bench.say("$#");
        let place = said.split("[PRB:").nth(1).and_then(|rest| rest.split(':').next()).expect("a place");
        place.split(',').nth(2).and_then(|z| z.parse().ok()).expect("its Z")
    };
    let mm = probed(&mut bench);
    assert!(mm > 1.0, "{mm}");
    bench.run(&["G20"]);
    assert!((probed(&mut bench) - mm / 25.4).abs() < 1e-3, "{mm} mm");
}

#[test]
fn a_probe_in_inches_comes_back_to_where_it_began() {
    let mut bench = with_probe();
    bench.run(&["G28", "G1 Z10 F600", "M400", "G20"]);
    let before = bench.carriage(Gamma);
    bench.say("G30");
    bench.run(&["M400"]);
    assert!((bench.carriage(Gamma) - before).abs() < 0.02, "{} is not {before}", bench.carriage(Gamma));
}

#[test]
fn the_feed_rate_in_dollar_g_is_in_the_units_of_the_program() {
    let mut bench = start();
    bench.run(&["G1 F600"]);
    assert!(bench.say("$G").contains(" F600.0000 "));
    bench.run(&["G20"]);
    assert!(bench.say("$G").contains(" F23.6220 "), "{}", bench.say("$G"));
}
