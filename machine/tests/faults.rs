//! Faults: each gives one clear message and leaves the machine safe.

use scenarios::{Bench, CARTESIAN, Plan};
use sim::runner::CardState;
use units::Actuator::Alpha;

/// Runs lines without waiting for answers, until these words are said; the machine must then be safe.
fn ends_safely(mut bench: Bench, lines: &[&str], words: &str, patience_s: f64) {
    for line in lines {
        bench.type_in(line);
        bench.type_in("\n");
    }
    let said = bench.hear_until(words, patience_s);
    let also = bench.hear(0.5);
    let count = (said + &also).matches(words).count();
    assert_eq!(count, 1, "said {count} times: {words}");
    bench.assert_safe();
}

#[test]
fn an_open_thermistor_stops_heating() {
    let bench = Plan::new(CARTESIAN).fault("thermistor-open:hotend@20").start();
    ends_safely(bench, &["M104 S200"], "ERROR: MINTEMP or MAXTEMP triggered on T", 22.0);
}

#[test]
fn a_shorted_thermistor_stops_heating() {
    let bench = Plan::new(CARTESIAN).fault("thermistor-short:bed@20").start();
    ends_safely(bench, &["M140 S60"], "ERROR: MINTEMP or MAXTEMP triggered on B", 22.0);
}

#[test]
fn a_heater_that_does_not_heat_is_given_up() {
    let bench = Plan::new(CARTESIAN).fault("heater-dead:hotend").start();
    ends_safely(bench, &["M104 S200"], "ERROR: T was given full output for 20 s and did not warm by 2 C", 25.0);
}

#[test]
fn a_heater_that_is_too_slow_is_given_up_when_its_time_is_over() {
    let plan = Plan::new(CARTESIAN).with("hotend.runaway_heating_timeout = 240", "hotend.runaway_heating_timeout = 20");
    ends_safely(plan.start(), &["M104 S200"], "ERROR: Temperature took too long to be reached on T", 25.0);
}

#[test]
fn a_heater_that_fails_later_is_told_by_its_cooling() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.say("M109 S200");
    bench.hear(20.0);
    bench
        .world(|world| world.inject(&sim::world::Fault::HeaterDead("hotend".into())))
        .expect("a heater of this machine");
    ends_safely(bench, &[], "at full output: its heater has failed, or its sensor slides out", 30.0);
}

#[test]
fn a_sensor_that_slides_out_is_told_cold_and_hot() {
    // The first case is while the heater warms up, the second at its target.
    for (at_s, within_s) in [(20.0, 30.0), (100.0, 106.0)] {
        let bench = Plan::new(CARTESIAN).fault(&format!("thermistor-slip:hotend@{at_s}")).start();
        ends_safely(bench, &["M104 S200"], "its sensor", within_s);
    }
}

#[test]
fn a_loose_sensor_is_told() {
    let bench = Plan::new(CARTESIAN).fault("thermistor-loose:hotend@100").start();
    ends_safely(bench, &["M104 S200"], "ERROR: T: the reading jumps up and down", 115.0);
}

#[test]
fn a_converter_that_stands_is_told_while_heating_and_holding() {
    for at_s in [20.0, 100.0] {
        let bench = Plan::new(CARTESIAN).fault(&format!("adc-stands@{at_s}")).start();
        ends_safely(bench, &["M104 S200"], "ERROR: MINTEMP or MAXTEMP triggered on T", at_s + 0.5);
    }
}

#[test]
fn swapped_sensors_are_told_before_anything_is_hot() {
    for (line, words) in [("M104 S200", "T warms the sensor of B"), ("M140 S60", "B warms the sensor of T")] {
        let bench = Plan::new(CARTESIAN).fault("thermistors-swapped:hotend,bed").start();
        ends_safely(bench, &[line], words, 60.0);
    }
}

#[test]
fn homing_without_a_switch_ends_after_its_travel() {
    let plan = Plan::new(CARTESIAN).fault("switch-never:minx");
    ends_safely(plan.start(), &["G28"], "endstop was not reached within its travel", 120.0);
}

#[test]
fn homing_onto_a_stuck_switch_is_noticed() {
    let plan = Plan::new(CARTESIAN).fault("switch-always:minx");
    ends_safely(plan.start(), &["G28"], "endstop does not open when backed off: stuck, or wired inverted", 60.0);
}

#[test]
fn a_silent_driver_is_named_and_nothing_moves() {
    let mut bench = Plan::new(CARTESIAN).fault("driver-silent:beta").start();
    assert!(bench.greeting().contains("ERROR: motor driver beta does not answer"), "{}", bench.greeting());
    let answer = bench.say("G1 X10 F600");
    assert!(answer.starts_with("Error: motor driver beta does not answer"), "{answer}");
    assert_eq!(bench.world(|world| world.trace().total()), 0);
}

#[test]
fn a_driver_with_a_short_halts_and_says_which() {
    for (fault, side) in [("driver-short:alpha@3", "ground"), ("driver-short-to-supply:alpha@3", "supply")] {
        let bench = Plan::new(CARTESIAN).fault(fault).start();
        ends_safely(bench, &["G1 X10 F600"], &format!("ERROR: motor driver X: SHORT to {side} on channel A"), 10.0);
    }
}

#[test]
fn a_motor_with_an_open_coil_is_told_in_slow_motion_only() {
    let mut bench = Plan::new(CARTESIAN).fault("driver-open-load:alpha").start();
    bench.say("G1 X150 F12000");
    bench.say("G1 X0");
    let fast = bench.say("M400") + &bench.hear(3.0);
    assert!(!fast.contains("coil"), "{fast}");
    // 10 mm/s: fifty full steps a second.
    bench.type_in("G1 X80 F600\n");
    let said = bench.hear_until("WARNING: X: no current through coil A: check the motor's plug and cable", 5.0);
    let later = bench.hear(6.0);
    assert_eq!((said + &later).matches("coil").count(), 1);
    assert!(!bench.status().contains("<Alarm"), "it goes on");
}

#[test]
fn a_driver_that_overheats_halts() {
    let bench = Plan::new(CARTESIAN).fault("driver-overheat:alpha@3").start();
    ends_safely(bench, &["G1 X10 F600"], "ERROR: motor driver X: Overtemperature Shutdown", 10.0);
}

#[test]
fn losing_motor_supply_while_moving_halts_and_forgets_homing() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.run(&["G28"]);
    bench.world(|world| world.inject(&sim::world::Fault::MotorSupply(0.5))).expect("a supply");
    bench.type_in("G1 X150 F1200\n");
    bench.hear_until("ERROR: motor supply lost while moving", 3.0);
    assert_eq!(bench.say("M999").lines().last(), Some("ok"));
    assert_eq!(bench.say("G28.6"), "X:0 Y:0 Z:0 \nok\n");
    let answer = bench.say("G1 X10 F600");
    assert!(answer.starts_with("Error: motor supply is off (vmotor below 6 V)"), "{answer}");
}

#[test]
fn motor_supply_that_returns_lets_the_machine_work_again() {
    let mut bench = Plan::new(CARTESIAN).fault("motor-supply:0").start();
    assert!(bench.greeting().contains("WARNING: motor supply is off"), "{}", bench.greeting());
    bench.world(|world| world.inject(&sim::world::Fault::MotorSupply(24.0))).expect("a supply");
    bench.hear_until("// NOTICE motor supply is on", 3.0);
    bench.run(&["G28", "M400"]);
    assert!(bench.carriage(Alpha).abs() < 0.013);
}

#[test]
fn without_a_card_the_console_says_so_and_the_machine_stays_off() {
    let mut bench = Plan::new(CARTESIAN).card(CardState::Missing).start();
    assert!(
        bench.greeting().contains("ERROR: cannot read /sd/config.ini: no SD card found: insert a card and reset"),
        "{}",
        bench.greeting()
    );
    let answer = bench.say("G28");
    assert_eq!(answer, "error:the configuration has errors: mend config.ini and reset\n");
    assert_eq!(bench.ask("version").lines().next(), Some("host on Prime. board_id: 00"));
}

#[test]
fn a_config_that_cannot_be_read_leaves_the_machine_off() {
    let bench = Plan::new(CARTESIAN).card(CardState::Unreadable).start();
    assert!(bench.greeting().contains("ERROR: cannot read /sd/config.ini"), "{}", bench.greeting());
    assert!(bench.greeting().contains("There was a fatal error in the config.ini"));
}

#[test]
fn a_mistake_in_the_config_is_located_and_can_be_mended_over_the_console() {
    let plan = Plan::new(CARTESIAN).with("alpha.steps_per_mm = 80 ", "alpha.steps_per_mm = eighty ");
    let mut bench = plan.start();
    let line = bench.greeting().lines().find(|line| line.contains("alpha.steps_per_mm")).expect("a finding").to_owned();
    assert!(line.starts_with("config.ini: line 39, ") && line.contains("fatal: "), "{line}");
    assert!(bench.say("G1 X10 F600").starts_with("error:the configuration has errors"));
    bench.run(&["cd /sd"]);
    assert_eq!(bench.say("M28 config.ini"), "Writing to file: config.ini\nok\n");
    assert_eq!(bench.say("M29"), "Done saving file.\nok\n");
    assert_eq!(bench.read_card("config.ini").as_deref(), Some(""));
    assert!(bench.say("reset").starts_with("Reset will occur in 1 second\n"));
}

#[test]
fn a_heat_fault_during_m109_ends_the_job_at_that_line() {
    let plan = Plan::new(CARTESIAN).file("last.g", "M109 S200\n").fault("thermistor-open:hotend@15");
    let mut bench = plan.start();
    bench.say("M23 last.g");
    bench.type_in("M24\n");
    let said = bench.hear_until("ERROR: MINTEMP or MAXTEMP triggered on T", 22.0) + &bench.hear(2.0);
    assert!(!said.contains("Done printing"), "{said}");
    assert_eq!(said.matches("ERROR").count(), 1, "{said}");
    bench.assert_safe();
}

#[test]
fn a_heat_fault_during_m109_lets_no_further_line_of_the_job_run() {
    let plan = Plan::new(CARTESIAN).file("heat.g", "M109 S200\nG1 X50 F600\n").fault("thermistor-short:hotend@15");
    let mut bench = plan.start();
    bench.say("M23 heat.g");
    bench.type_in("M24\n");
    bench.hear_until("ERROR: MINTEMP or MAXTEMP triggered on T", 22.0);
    bench.assert_safe();
    assert_eq!(bench.world(|world| world.trace().total()), 0, "the line after M109 has moved something");
}

#[test]
fn a_silent_driver_is_told_once() {
    let mut bench = Plan::new(CARTESIAN).fault("driver-silent:beta").start();
    let said = bench.greeting().to_owned() + &bench.hear(5.0);
    assert_eq!(said.matches("does not answer").count(), 1, "{said}");
}

#[test]
fn a_driver_that_falls_silent_halts_with_one_message() {
    let bench = Plan::new(CARTESIAN).fault("driver-silent:alpha@3").start();
    ends_safely(bench, &["G1 X100 F600"], "driver does not answer, check its supply and wiring", 10.0);
}

#[test]
fn heating_without_supply_is_refused_and_told_at_boot() {
    let mut bench = Plan::new(CARTESIAN).fault("fet-supply:0").start();
    let said = bench.greeting().to_owned() + &bench.hear(5.0);
    let words = "WARNING: heater supply is off (vfet below 6 V), heaters and fans do nothing";
    assert_eq!(said.matches(words).count(), 1, "{said}");
    let answer = bench.say("M104 S200");
    assert!(answer.starts_with("Error: heater supply is off (vfet below 6 V): switch it on, then M999"), "{answer}");
    bench.assert_safe();
}

#[test]
fn losing_the_heaters_supply_while_heating_halts() {
    let bench = Plan::new(CARTESIAN).fault("fet-supply:0.5@10").start();
    ends_safely(bench, &["M104 S200"], "ERROR: heater supply lost while heating (vfet below 6 V)", 14.0);
}

#[test]
fn heater_supply_that_returns_lets_the_machine_heat_again() {
    let mut bench = Plan::new(CARTESIAN).fault("fet-supply:0").start();
    bench.hear_until("WARNING: heater supply is off", 5.0);
    bench.world(|world| world.inject(&sim::world::Fault::FetSupply(24.0))).expect("a supply");
    bench.hear_until("// NOTICE heater supply is on", 3.0);
    bench.run(&["M104 S60"]);
    bench.hear(3.0);
    assert!(bench.duty("hotend") > 0.5);
}
