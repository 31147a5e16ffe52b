//! Fans that run by themselves, and `[temperature switch]`.

use scenarios::{Bench, CARTESIAN, Plan};

/// Returns the index of the simulated fan of this name.
fn fan(bench: &Bench, name: &str) -> usize {
    bench.world(|world| world.config().fans.iter().position(|fan| fan.name == name)).expect("a fan of this machine")
}

fn rpm(bench: &Bench, name: &str) -> f64 {
    let index = fan(bench, name);
    bench.world(|world| world.fan_rpm(index))
}

/// Adds a second fan on its MOSFET, without codes that switch it.
fn second(plan: Plan, kind: &str) -> Plan {
    plan.set("[switch] cooling.enable = true")
        .set("[switch] cooling.output_pin = PI11")
        .set(&format!("[switch] cooling.output_type = {kind}"))
}

fn following(what: &str, lines: &[&str]) -> Plan {
    let plan = second(Plan::new(CARTESIAN), "sigmadeltapwm")
        .set("[fan] cooling.enable = true")
        .set(&format!("[fan] cooling.follows = {what}"));
    lines.iter().fold(plan, |plan, line| plan.set(&format!("[fan] cooling.{line}")))
}

const TACHOMETER: [&str; 3] = ["tachometer_pin = PD12^", "min_rpm = 1000", "stopped_after = 3"];

#[test]
fn a_hot_end_s_fan_runs_while_it_heats_and_until_it_is_cold() {
    let mut bench = following("heaters", &["sensors = hotend", "speed = 80"]).start();
    bench.hear(3.0);
    assert!(rpm(&bench, "cooling") < 1.0, "cold, and off");
    bench.say("M104 S200");
    bench.hear(2.0);
    assert!(rpm(&bench, "cooling") > 4_500.0, "from the moment it is to heat");
    bench.hear(60.0);
    bench.say("M104 S0");
    while bench.celsius("hotend") > 55.0 {
        assert!(rpm(&bench, "cooling") > 4_500.0, "it is still hot");
        bench.hear(5.0);
    }
    bench.hear(60.0);
    assert!(rpm(&bench, "cooling") < 100.0, "{} C", bench.celsius("hotend"));
    assert_eq!(bench.say("M123"), "cooling 0%\nok\n");
    // The console cannot switch a fan that runs by itself.
    assert!(bench.say("switch cooling on").contains("cooling runs by itself: see [fan] in config.ini"));
}

#[test]
fn a_cabinet_s_fan_runs_with_the_motors_and_lingers() {
    let mut bench = following("electronics", &["idle_speed = 40", "linger = 20"]).start();
    bench.hear(2.0);
    assert_eq!(bench.say("M123"), "cooling 0%\nok\n");
    bench.say("M17");
    bench.hear(1.0);
    assert_eq!(bench.say("M123"), "cooling 100%\nok\n");
    bench.say("M18");
    bench.hear(1.0);
    assert_eq!(bench.say("M123"), "cooling 40%\nok\n");
    bench.hear(20.0);
    assert_eq!(bench.say("M123"), "cooling 0%\nok\n");
}

/// The heater warms the sensor; the fan is asked to keep it from 60 degrees on.
#[test]
fn a_fan_keeps_a_temperature() {
    let lines = ["sensors = hotend", "temperature = 60", "control = pid", "p_factor = 2", "i_factor = 0"];
    let mut bench = following("temperature", &lines).start();
    bench.say("M104 S80");
    bench.hear(0.5);
    assert_eq!(bench.say("M123"), "cooling 0%\nok\n");
    bench.say("M109 S80");
    bench.hear(30.0);
    let said = bench.say("M123");
    let percent: f64 = said.strip_prefix("cooling ").and_then(|rest| rest.split('%').next()).unwrap().parse().unwrap();
    assert!((35.0..45.0).contains(&percent), "2 % for each of 20 degrees: {said}");
}

#[test]
fn a_fan_that_stops_is_told_once_or_halts_and_one_without_power_is_not() {
    let mut lines = TACHOMETER.to_vec();
    lines.extend(["sensors = hotend"]);
    let plan = following("heaters", &lines);
    let mut bench = plan.clone().fault("fan-stopped:cooling@10").fault("repaired@30").start();
    assert_eq!(bench.hear(9.0), "", "it stands, and has no power");
    bench.say("M104 S100");
    let said = bench.hear_until("WARNING: fan cooling has stopped: 0 rpm, not 1000\n", 12.0);
    assert!(bench.now_s() > 12.0, "not at once: {said}");
    assert_eq!(bench.hear(10.0), "");
    assert!(bench.say("M123").contains(" 0 rpm, stopped\n"));
    bench.hear_until("// NOTICE fan cooling turns again", 15.0);
    let mut halts = plan.set("[fan] cooling.when_stopped = halt").fault("fan-slow:cooling@10").start();
    halts.say("M104 S100");
    halts.hear_until("ERROR: fan cooling has stopped: 240 rpm, not 1000\n", 20.0);
    halts.hear(0.1);
    halts.assert_safe();
    assert_eq!(halts.hear(10.0), "", "in a halt it has no supply");
}

#[test]
fn how_fast_a_fan_turns_is_said() {
    let plan = Plan::new(CARTESIAN).set("[fan] fan.enable = true").set("[fan] fan.tachometer_pin = PD12^");
    let mut bench = plan.start();
    bench.say("M106 S128");
    bench.hear(5.0);
    let said = bench.say("M123");
    let turns: f64 = said.strip_prefix("fan 50% ").and_then(|rest| rest.split(' ').next()).unwrap().parse().unwrap();
    assert!((turns - rpm(&bench, "fan")).abs() < 40.0, "{said}: {}", rpm(&bench, "fan"));
}

#[test]
fn a_kick_start_turns_a_fan_that_its_power_would_not() {
    for (seconds, turns) in [("0", false), ("0.3", true)] {
        let plan = Plan::new(CARTESIAN).set("[fan] fan.enable = true");
        let mut bench = plan.set(&format!("[fan] fan.kick_start_time = {seconds}")).start();
        bench.say("M106 S20");
        bench.hear(5.0);
        assert_eq!(rpm(&bench, "fan") > 300.0, turns, "{seconds} s: {}", rpm(&bench, "fan"));
    }
}

#[test]
fn powers_have_a_least_and_a_greatest() {
    let plan = ["enable = true", "off_below = 10", "min_power = 30", "max_power = 80"]
        .iter()
        .fold(Plan::new(CARTESIAN), |plan, line| plan.set(&format!("[fan] fan.{line}")));
    let mut bench = plan.start();
    for (s, percent) in [(20, 0), (30, 30), (128, 50), (255, 80), (0, 0)] {
        bench.say(&format!("M106 S{s}"));
        assert_eq!(bench.say("M123"), format!("fan {percent}%\nok\n"), "S{s}");
    }
}

/// In a halt the fan's output stays on, for fans with a supply of their own; those on the MOSFETs lose it.
#[test]
fn a_halt_leaves_a_fan_that_follows_heaters_on() {
    let plan = following("heaters", &["sensors = hotend"]);
    let mut bench = plan.set("[switch] cooling.output_pin = PD10").start();
    bench.say("M104 S150");
    bench.hear(30.0);
    bench.type_in("\x18");
    bench.hear(5.0);
    assert!(rpm(&bench, "cooling") > 5_000.0, "{}", rpm(&bench, "cooling"));
}

#[test]
fn a_fan_is_refused_where_its_settings_contradict() {
    for (lines, says) in [
        (&["[fan] pump.enable = true"][..], "there is no [switch] pump"),
        (&["[fan] fan.enable = true", "[fan] fan.follows = heaters"], "codes switch [switch] fan"),
        (&["[fan] fan.enable = true", "[fan] fan.min_rpm = 50"], "without a tachometer"),
        (&["[fan] fan.enable = true", "[fan] fan.tachometer_pin = PE0"], "PE0 is used by"),
        (&["[fan] fan.enable = true", "[fan] fan.sensors = hotend"], "watches nothing"),
    ] {
        let bench = lines.iter().fold(Plan::new(CARTESIAN), |plan, line| plan.set(line)).start();
        assert!(bench.greeting().contains(says), "{says}: {}", bench.greeting());
    }
}

/// Adds the temperature switch that Smoothieware describes: the pump of a cooled spindle, or the fan of a hot
/// end.
fn ruled(lines: &[&str]) -> Plan {
    let plan = second(Plan::new(CARTESIAN), "digital")
        .set("[temperature switch] hot.enable = true")
        .set("[temperature switch] hot.designator = T")
        .set("[temperature switch] hot.switch = cooling")
        .set("[temperature switch] hot.heatup_poll = 2")
        .set("[temperature switch] hot.cooldown_poll = 5");
    lines.iter().fold(plan, |plan, line| plan.set(&format!("[temperature switch] hot.{line}")))
}

#[test]
fn a_switch_follows_a_temperature_both_ways() {
    let mut bench = ruled(&[]).start();
    bench.say("M104 S100");
    while bench.celsius("hotend") < 48.0 {
        assert_eq!(bench.say("switch cooling"), "switch cooling is 0\nok\n");
        bench.hear(0.5);
    }
    bench.hear(6.0);
    assert_eq!(bench.say("switch cooling"), "switch cooling is 1\nok\n");
    bench.say("M104 S0");
    bench.hear(400.0);
    assert!(bench.celsius("hotend") < 48.0);
    assert_eq!(bench.say("switch cooling"), "switch cooling is 0\nok\n");
}

/// The power supply goes off once all is cold, if it was asked to.
#[test]
fn an_armed_edge_acts_once() {
    let plan = ruled(&["trigger = falling", "arm_mcode = 801"]).set("[switch] cooling.startup_state = true");
    let mut bench = plan.start();
    let cool_down = |bench: &mut Bench| {
        bench.say("M104 S100");
        bench.hear(40.0);
        bench.say("M104 S0");
        bench.hear(300.0);
        bench.say("switch cooling")
    };
    assert_eq!(cool_down(&mut bench), "switch cooling is 1\nok\n", "it is not armed");
    assert_eq!(bench.say("M801 S1"), "ok\n");
    assert_eq!(cool_down(&mut bench), "switch cooling is 0\nok\n");
    bench.say("switch cooling on");
    assert_eq!(cool_down(&mut bench), "switch cooling is 1\nok\n", "once");
    bench.run(&["M801 S1", "M801 S0"]);
    assert_eq!(cool_down(&mut bench), "switch cooling is 1\nok\n", "disarmed");
}

// Smoothieware v2: it acts when the threshold is passed the next time.
#[test]
fn a_level_that_is_armed_acts_at_once() {
    let mut bench = ruled(&["arm_mcode = 801", "heatup_poll = 60", "cooldown_poll = 60"]).start();
    bench.say("M109 S100");
    assert_eq!(bench.say("switch cooling"), "switch cooling is 0\nok\n", "it is not armed");
    for _ in 0..2 {
        bench.run(&["M801 S1"]);
        bench.hear(0.5);
        assert_eq!(bench.say("switch cooling"), "switch cooling is 1\nok\n");
        bench.run(&["M801 S0"]);
        bench.say("switch cooling off");
        bench.hear(150.0);
        assert_eq!(bench.say("switch cooling"), "switch cooling is 0\nok\n", "it is disarmed");
    }
}

#[test]
fn a_rule_that_has_nothing_to_do_is_refused() {
    for (line, says) in [
        ("[temperature switch] hot.designator = X", "has a designator that begins like 'X'"),
        ("[temperature switch] hot.switch = pump", "there is no [switch] pump"),
    ] {
        let bench = ruled(&[]).set(line).start();
        assert!(bench.greeting().contains(says), "{says}: {}", bench.greeting());
    }
}

/// In Smoothieware's dialect S is percent there, as in v2; other printers' firmwares know no such outputs.
#[test]
fn s_of_a_fan_on_hardware_pwm_is_percent_in_smoothiewares_dialect_alone() {
    for (dialect, line) in [
        ("smoothie", "M106 S50"),
        ("marlin", "M106 S127.5"),
        ("reprapfirmware", "M106 S0.5"),
        ("klipper", "M106 S127.5"),
    ] {
        let mut bench = Plan::new(CARTESIAN)
            .set("[pwm1] frequency = 5000")
            .set("[switch] fan.output_pin = PWM1_1")
            .set("[switch] fan.output_type = hwpwm")
            .set("[switch] fan.startup_value = 0")
            .set(&format!("[general] dialect = {dialect}"))
            .start();
        for line in [line, "SET_FAN_SPEED FAN=fan SPEED=0.5"] {
            bench.run(&["M107"]);
            bench.hear(0.02);
            assert!(bench.world(|world| world.pwm_duty(0, 0)) < 1e-9, "{dialect}");
            bench.run(&[line]);
            bench.hear(0.02);
            let duty = bench.world(|world| world.pwm_duty(0, 0));
            assert!((duty - 0.5).abs() < 0.003, "{line} in {dialect}: {duty}");
        }
    }
}
