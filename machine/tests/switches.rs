//! Outputs by number, servos, power supplies, inputs to wait for, and the button box.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::Alpha;

fn press(bench: &mut Bench, name: &str, down: bool) {
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, name, down)).expect("a button of this machine");
    bench.hear(0.2);
}

fn servo() -> Plan {
    Plan::new(CARTESIAN)
        .set("[pwm1] frequency = 50")
        .set("[switch] arm.enable = true")
        .set("[switch] arm.output_pin = PWM1_2")
        .set("[switch] arm.output_type = hwpwm")
        .set("[switch] arm.input_on_command = M280")
        .set("[switch] arm.input_off_command = M281")
}

/// Width of the servo's pulses, us.
fn pulse_us(bench: &mut Bench) -> f64 {
    bench.hear(0.01);
    bench.world(|world| world.pwm_duty(0, 1)) * 20_000.0
}

#[test]
fn a_servo_takes_percent_and_pulses_as_smoothieware_s_do() {
    let mut bench = servo().start();
    for (line, us) in [("M280 S5", 1_000.0), ("M280 P1500", 1_500.0), ("M280 S7.5", 1_500.0), ("M281", 0.0)] {
        bench.run(&[line]);
        let is = pulse_us(&mut bench);
        assert!((is - us).abs() < 1.0, "{line}: {is}");
    }
}

#[test]
fn a_halt_brings_a_servo_to_where_it_was_at_first() {
    let mut bench = servo().set("[switch] arm.startup_value = 6").start();
    bench.run(&["M280 S10"]);
    assert!((pulse_us(&mut bench) - 2_000.0).abs() < 1.0);
    bench.say("M112");
    let is = pulse_us(&mut bench);
    assert!((is - 1_200.0).abs() < 1.0, "{is}");
}

// Smoothieware v2: the value replaces startup_value, which on-codes without S then give, and which off-codes
// and halts of an output on a timer go to.
#[test]
fn a_value_that_is_typed_sets_an_output_once() {
    let mut bench = servo().set("[switch] arm.startup_value = 6").set("[switch] arm.default_on_value = 8").start();
    for (line, us) in [("M280", 1_600.0), ("M281", 1_200.0), ("M112", 1_200.0)] {
        assert_eq!(bench.say("switch arm 7"), "switch arm set to: 7\nok\n");
        let is = pulse_us(&mut bench);
        assert!((is - 1_400.0).abs() < 1.0, "{is}");
        bench.say(line);
        let is = pulse_us(&mut bench);
        assert!((is - us).abs() < 1.0, "{line}: {is}");
    }
    let mut bench = Plan::new(CARTESIAN).set("[switch] fan.startup_value = 64").start();
    let mean = |bench: &mut Bench| {
        bench.hear(0.1);
        let sum: f64 = (0..510).map(|_| (bench.hear(0.001), bench.world(|world| world.fan_speed(0))).1).sum();
        sum / 510.0
    };
    for (line, value) in [("switch fan 192", 192.0), ("M107", 0.0), ("M106", 64.0)] {
        bench.say(line);
        let is = 255.0 * mean(&mut bench);
        assert!((is - value).abs() < 6.0, "{line}: {is}");
    }
}

#[test]
fn an_input_takes_no_value() {
    let lid = "\n[switch]\nlid.enable = true\nlid.input_pin = PB7^\nlid.output_on_command = M118 open\n";
    let mut bench = Plan::new(CARTESIAN).adding(lid).start();
    assert_eq!(bench.say("switch lid 1"), "unknown command set-value.\nok\n");
    assert_eq!(bench.say("switch lid on"), "unknown command set-state.\nok\n");
    assert_eq!(bench.say("switch lid"), "switch lid is 0\nok\n");
    assert_eq!(bench.hear(0.5), "", "its command was not given");
}

#[test]
fn a_servo_that_is_described_takes_angles() {
    let plan = servo().set("[switch] arm.servo_max_angle = 180").set("[switch] arm.servo_max_us = 2200");
    let mut bench = plan.start();
    for (line, us) in [("M280 S0", 1_000.0), ("M280 S90", 1_600.0), ("M280 S180", 2_200.0), ("M280 S1500", 1_500.0)] {
        bench.run(&[line]);
        let is = pulse_us(&mut bench);
        assert!((is - us).abs() < 1.0, "{line}: {is}");
    }
    bench.run(&["M280 P9000"]);
    let is = pulse_us(&mut bench);
    assert!((is - 2_200.0).abs() < 1.0, "never wider: {is}");
}

#[test]
fn commands_by_name_switch_off_what_has_no_levels_and_turn_servos() {
    let plan = servo().set("[switch] arm.servo_max_angle = 180").set("[switch] fan.output_type = digital");
    let mut bench = plan.start();
    for (line, says) in [("SET_PIN PIN=fan VALUE=1", "is 1"), ("SET_PIN PIN=fan VALUE=0", "is 0")] {
        bench.say(line);
        assert!(bench.say("switch fan").contains(says), "{line}");
    }
    for (line, us) in [("SET_SERVO SERVO=arm ANGLE=45", 1_250.0), ("SET_SERVO SERVO=arm WIDTH=0.0017", 1_700.0)] {
        bench.say(line);
        let is = pulse_us(&mut bench);
        assert!((is - us).abs() < 1.0, "{line}: {is}");
    }
}

#[test]
fn a_servo_is_refused_where_its_pulses_do_not_fit() {
    for (line, says) in [
        ("[pwm1] frequency = 10000", "do not fit into the period of 10000 Hz"),
        ("[switch] arm.servo_max_us = 500", "no more than servo_min_us"),
    ] {
        let bench = servo().set("[switch] arm.servo_max_angle = 90").set(line).start();
        assert!(bench.greeting().contains(says), "{says}: {}", bench.greeting());
    }
}

#[test]
fn m42_sets_an_output_by_its_number() {
    let mut bench = Plan::new(CARTESIAN).set("[switch] fan.io_number = 4").start();
    bench.run(&["M42 P4 S128"]);
    assert!(bench.say("switch fan").contains("is 1"));
    bench.run(&["M42 P4 S0"]);
    assert!(bench.say("switch fan").contains("is 0"));
    assert!(bench.say("M42 P5 S1").contains("no output has io_number = 5"));
}

#[test]
fn commands_by_name_know_what_only_has_a_number() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[general] dialect = klipper")
        .set("[switch] valve.enable = true")
        .set("[switch] valve.output_pin = PI11")
        .set("[switch] valve.output_type = sigmadeltapwm")
        .set("[switch] valve.io_number = 7")
        .start();
    for (line, says) in [("SET_PIN PIN=valve VALUE=0.5", "is 1"), ("SET_PIN PIN=valve VALUE=0", "is 0")] {
        assert_eq!(bench.say(line), "ok\n", "{line}: {}", bench.greeting());
        assert!(bench.say("switch valve").contains(says), "{line}");
    }
}

/// A relay for mains is on once in a second, and a heater by it holds its target.
#[test]
fn what_has_a_cycle_switches_once_in_it() {
    let plan =
        Plan::new(CARTESIAN).set("[temperature control] bed.cycle_time = 1").set("[switch] fan.cycle_time = 0.5");
    let mut bench = plan.start();
    bench.say("M106 S64");
    let mut rises = 0;
    let mut before = 1.0;
    for _ in 0..1_000 {
        bench.hear(0.01);
        let now = bench.world(|world| world.fan_speed(0));
        rises += u32::from(before < 0.5 && now >= 0.5);
        before = now;
    }
    assert!((19..=21).contains(&rises), "{rises} times in ten seconds");
    bench.say("M190 S50");
    bench.hear(60.0);
    assert!((bench.celsius("bed") - 50.0).abs() < 1.0, "{} C", bench.celsius("bed"));
}

#[test]
fn m226_waits_for_an_input_as_long_as_it_takes() {
    let lid = "\n[switch]\nlid.enable = true\nlid.input_pin = PB7^\nlid.io_number = 1\n";
    for (line, downs) in [("M226 P1 S1", &[true][..]), ("M226 P1 S0", &[]), ("M226 P1", &[true])] {
        let mut bench = Plan::new(CARTESIAN).adding(lid).start();
        bench.type_in(&format!("{line}\n"));
        if !downs.is_empty() {
            assert_eq!(bench.hear(20.0), "", "{line}: it waits");
        }
        for down in downs {
            let at_ns = (bench.now_s() * 1e9) as u64;
            bench.world(|world| world.press(at_ns, "lid", *down)).expect("a switch of this machine");
        }
        assert_eq!(bench.hear(0.5), "ok\n", "{line}");
    }
}

#[test]
fn a_power_supply_has_come_up_before_the_next_line() {
    let psu = "\n[switch]\npsu.enable = true\npsu.output_pin = PI4!\npsu.output_type = digital\n\
               psu.input_on_command = M80\npsu.input_off_command = M81\npsu.on_delay = 2\n";
    let mut bench = Plan::new(CARTESIAN).adding(psu).start();
    let before = bench.now_s();
    bench.run(&["M80"]);
    assert!((1.9..2.2).contains(&(bench.now_s() - before)));
    let before = bench.now_s();
    bench.run(&["M80", "M81"]);
    assert!(bench.now_s() - before < 0.1, "it is on already, and off needs no time");
}

fn buttons(lines: &[&str]) -> Plan {
    let plan = Plan::new(CARTESIAN).set("[button box] one.pin = PB7^");
    lines.iter().fold(plan, |plan, line| plan.set(&format!("[button box] one.{line}")))
}

#[test]
fn a_button_sends_its_lines() {
    let mut bench = buttons(&["press = M106 S255", "release = M107"]).start();
    press(&mut bench, "one", true);
    assert!(bench.say("switch fan").contains("is 1"));
    press(&mut bench, "one", false);
    assert!(bench.say("switch fan").contains("is 0"));
}

#[test]
fn a_long_press_is_another_one() {
    let mut bench = buttons(&["press = M106", "long_press = M107", "long_press_time = 2"]).start();
    press(&mut bench, "one", true);
    press(&mut bench, "one", false);
    assert!(bench.say("switch fan").contains("is 1"));
    press(&mut bench, "one", true);
    bench.hear(2.0);
    assert!(bench.say("switch fan").contains("is 0"));
    press(&mut bench, "one", false);
    assert!(bench.say("switch fan").contains("is 0"));
}

#[test]
fn kill_halts_and_suspend_suspends_and_goes_on() {
    let mut bench = buttons(&["press = KILL"]).start();
    bench.say("M104 S100");
    press(&mut bench, "one", true);
    bench.assert_safe();
    let plan = buttons(&["press = SUSPEND"]).file("part.g", &"G91\nG1 X5 F600\nG1 X-5\n".repeat(60));
    let mut bench = plan.start();
    bench.say("play /sd/part.g");
    bench.hear(2.0);
    press(&mut bench, "one", true);
    press(&mut bench, "one", false);
    bench.hear(30.0);
    assert!(!bench.moves(), "it is suspended");
    press(&mut bench, "one", true);
    bench.hear(3.0);
    assert!(bench.moves(), "and goes on");
}

#[test]
fn a_jog_lasts_as_long_as_its_button_is_held() {
    let mut bench = buttons(&["press = $J -c X1 F600", "release = $J STOP"]).start_homed();
    let before = bench.carriage(Alpha);
    press(&mut bench, "one", true);
    bench.hear(2.0);
    assert!(bench.moves() && bench.carriage(Alpha) > before + 5.0);
    press(&mut bench, "one", false);
    bench.hear(1.0);
    let at = bench.carriage(Alpha);
    assert!(!bench.moves());
    bench.hear(2.0);
    assert!((bench.carriage(Alpha) - at).abs() < 1e-9);
    // Let go before it could begin: it never does.
    bench.type_in("G4 S2\n");
    bench.hear(0.5);
    press(&mut bench, "one", true);
    press(&mut bench, "one", false);
    bench.hear(5.0);
    assert!(!bench.moves() && (bench.carriage(Alpha) - at).abs() < 1e-9);
}

#[test]
fn a_heater_s_pin_is_no_switch_s() {
    let plan = Plan::new(CARTESIAN).set("[switch] fan.output_pin = PE0");
    let mut bench = plan.start();
    assert!(bench.greeting().contains("PE0 is used by"), "{}", bench.greeting());
    bench.type_in("M106\n");
    bench.hear(10.0);
    assert!(bench.celsius("hotend") < 30.0, "nobody drives it");
}

/// Any number that a code can have, as in Smoothieware, and no other code's.
#[test]
fn codes_above_those_of_the_table_switch_and_heat() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[switch] fan.input_on_command = M2106")
        .set("[switch] fan.input_off_command = G200")
        .set("[temperature control] bed.set_m_code = 12140")
        .start();
    let is_on = |bench: &mut Bench| bench.say("switch fan").contains("is 1");
    assert_eq!(bench.say("M2106 S255"), "ok\n");
    assert!(is_on(&mut bench));
    // M58 shares its bit.
    assert!(bench.say("M58").contains("ignored") && bench.say("M107").contains("ignored"));
    assert_eq!(bench.say("G200"), "ok\n");
    assert!(!is_on(&mut bench));
    assert_eq!(bench.say("M12140 S50"), "ok\n");
    assert!(bench.say("M105").contains("/50.0 @"));
}
