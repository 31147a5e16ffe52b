//! M303, M304, M306 and M307 as a person types them.

use scenarios::{Bench, CARTESIAN, Plan};

const FAN: &str = "[temperature control] hotend.fan = fan";

/// Returns the least and greatest temperature of the last minute, after the target was held for a while.
fn held(bench: &mut Bench, heater: &str) -> [f64; 2] {
    bench.hear(90.0);
    (0..60).fold([f64::MAX, f64::MIN], |[least, most], _| {
        bench.hear(1.0);
        let celsius = bench.celsius(heater);
        [least.min(celsius), most.max(celsius)]
    })
}

#[test]
fn m306_finds_a_model_that_holds_and_m500_keeps_it() {
    let mut bench = Plan::new(CARTESIAN).set(FAN).start();
    let said = bench.say("M306 T0 S200");
    assert!(said.contains("Model found, of 40 W: model_capacity = ") && said.ends_with("ok\n"), "{said}");
    let figure = |key: &str| -> f64 {
        let rest = said.split(key).nth(1).expect("it is said");
        rest.trim_start_matches(" = ").split_whitespace().next().and_then(|word| word.parse().ok()).expect("a number")
    };
    // The plant has 12 J/K, 0.1 W/K, 0.02 W/K with the fan, and a lag of 1.5 s.
    assert!((figure("model_capacity") / 12.0 - 1.0).abs() < 0.12, "{said}");
    assert!((figure("model_loss") / 0.1 - 1.0).abs() < 0.15, "{said}");
    assert!((figure("model_fan_loss") / 0.02 - 1.0).abs() < 0.3, "{said}");
    assert!((figure("model_late") / 1.5 - 1.0).abs() < 0.3, "{said}");
    assert!(bench.say("M105").contains("T:") && bench.say("M105").contains("/0.0 @0"));
    bench.say("M109 S200");
    let [least, most] = held(&mut bench, "hotend");
    assert!(least > 199.5 && most < 200.5, "{least} to {most}");
    assert!(bench.say("M301 S0").contains("model, see M307"));
    let saved = bench.say("M503");
    let line = saved.lines().find(|line| line.starts_with("M307 S0 P40.0000 C")).expect("a line of it").to_owned();
    assert!(!saved.contains("M301 S0"), "{saved}");
    // The same line makes it so in a machine that has PID.
    let mut other = Plan::new(CARTESIAN).start();
    assert!(other.say("M307 S0").contains("not controlled by a model"));
    assert_eq!(other.say(&line), "ok\n");
    assert!(other.say("M503").contains(&line));
    assert_eq!(other.say("M301 S0 P11 I0.5 D30"), "ok\n");
    assert!(other.say("M503").contains("M301 S0 P11.0000 I0.5000 D30.0000"));
}

#[test]
fn m303_says_in_words_what_it_found_and_answers_meanwhile() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.type_in("M303 P254 S60\n");
    bench.hear(20.0);
    // Lines on the same console wait for the tuning; a query does not.
    let status = bench.status();
    assert!(status.contains("|B:") && status.contains(",60.0"), "{status}");
    let said = bench.hear_until("PID tuned: p_factor = ", 3_000.0);
    assert!(
        said.contains("C/s less what it loses, its sensor tells ") && said.contains(" % of the output holds 60 C"),
        "{said}"
    );
    bench.say("M190 S60");
    let [least, most] = held(&mut bench, "bed");
    assert!(least > 59.5 && most < 60.5, "{least} to {most}");
    assert_eq!(bench.say("M304 P20 I0.25 D40"), "ok\n");
    assert!(bench.say("M304").contains("P: 20.000000 I: 0.250000 D: 40.000000"));
}

#[test]
fn nonsense_is_refused_and_nothing_heats() {
    let mut bench = Plan::new(CARTESIAN).start();
    for (line, why) in [
        ("M303 P0 S280", "M303 swings 15 C above its target, and max_temp is 290 C: S275 at most"),
        ("M303 P0 S30", "so near to the air's"),
        ("M306 T254 S110", "max_temp is 120 C: S105 at most"),
        ("M306 T9 S100", "no temperature control has tool_id 9"),
        ("M307 S0 P40", "cannot be set on this temperature control"),
        ("M307 S253 P40 C10 D1", "cannot be set on this temperature control"),
    ] {
        assert!(bench.say(line).contains(why), "{line}: {}", bench.say(line));
    }
    bench.hear(2.0);
    assert!(bench.duty("hotend") == 0.0 && bench.duty("bed") == 0.0);
}

#[test]
fn a_warm_heater_cools_before_m303_and_is_refused_by_m306() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.world(|world| {
        let hotend = world.heater_index("hotend").expect("a hotend");
        world.soak(hotend, 190.0);
    });
    bench.hear(1.0);
    assert!(bench.say("M306 T0 S200").contains("it is warm: let it cool"));
    let said = bench.say("M303 P0 S200");
    assert!(said.contains("It cools to 148 C first") && said.contains("PID tuned"), "{said}");
}

#[test]
fn a_fault_in_the_middle_ends_in_a_halt_with_the_heater_off() {
    let mut bench = Plan::new(CARTESIAN).start();
    let before = bench.say("M301 S0");
    bench.type_in("M303 P0 S200\n");
    bench.hear(30.0);
    bench.world(|world| world.inject(&sim::world::Fault::ThermistorOpen("hotend".into()))).expect("a heater");
    let said = bench.hear(3.0);
    assert!(said.contains("Autopid aborted") && said.contains("HALT asserted"), "{said}");
    bench.hear(2.0);
    assert!(bench.duty("hotend") < 0.2);
    bench.say("M999");
    assert_eq!(bench.say("M301 S0"), before);
}

// --- waiting ---

const CHAMBER: &str = "\n[temperature control]\nchamber.enable = true\nchamber.thermistor_pin = ADC1_2\n\
                       chamber.thermistor = Semitec\nchamber.heater_pin = PB8\nchamber.max_temp = 90\nchamber.tool_id = 251\n\
                       chamber.designator = C\n";

#[test]
fn a_chamber_listens_to_its_own_codes() {
    let mut bench = Plan::new(CARTESIAN).adding(CHAMBER).start();
    assert_eq!(bench.say("M141 S40"), "ok\n");
    assert!(bench.say("M105").contains("C:") && bench.say("M105").contains("/40.0 @"));
    assert!(bench.say("M191 S45").ends_with("ok\n"));
    assert!(bench.celsius("chamber") >= 44.8, "{}", bench.celsius("chamber"));
    assert!(bench.duty("bed") == 0.0 && bench.duty("hotend") == 0.0);
}

#[test]
fn m109_s_takes_what_is_warmer_and_r_waits_until_it_has_cooled() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.world(|world| {
        let hotend = world.heater_index("hotend").expect("a hotend");
        world.soak(hotend, 120.0);
    });
    bench.hear(1.0);
    let before = bench.now_s();
    assert!(bench.say("M109 S100").ends_with("ok\n") && bench.now_s() - before < 1.0);
    assert!(bench.say("M109 R100").ends_with("ok\n"));
    assert!((99.0..101.2).contains(&bench.celsius("hotend")), "{}", bench.celsius("hotend"));
}

#[test]
fn a_wait_has_a_window_a_dwell_and_a_timeout() {
    let waited = |lines: &[&str]| {
        let plan = lines.iter().fold(Plan::new(CARTESIAN), |plan, line| plan.set(line));
        let mut bench = plan.start();
        let before = bench.now_s();
        let said = bench.say("M109 S60");
        (said, bench.now_s() - before, bench.celsius("hotend"))
    };
    let (_, plain_s, _) = waited(&[]);
    let (said, near_s, celsius) = waited(&["[temperature control] hotend.wait_window = 15"]);
    assert!(said.ends_with("ok\n") && near_s < plain_s && (44.0..60.0).contains(&celsius), "{near_s} {celsius}");
    let dwell = ["[temperature control] hotend.wait_window = 2", "[temperature control] hotend.wait_dwell = 20"];
    let (said, dwelt_s, _) = waited(&dwell);
    assert!(said.ends_with("ok\n") && dwelt_s > near_s + 20.0, "{dwelt_s}");
    let (said, seconds, _) = waited(&["[temperature control] hotend.wait_timeout = 3"]);
    assert!(said.contains("hotend is not at its target after 3 s, its wait_timeout; it goes on heating"), "{said}");
    assert!((3.0..4.0).contains(&seconds), "{seconds}");
}

#[test]
fn preheat_sets_every_heater_that_has_the_preset() {
    let mut bench = Plan::new(CARTESIAN)
        .set("[temperature control] hotend.presets = PLA 205, petg 235")
        .set("[temperature control] bed.presets = pla 60")
        .start();
    assert_eq!(bench.say("preheat"), "pla: bed 60.0 C\nPLA: hotend 205.0 C\npetg: hotend 235.0 C\nok\n");
    assert_eq!(bench.say("preheat pla"), "ok\n");
    let said = bench.say("M105");
    assert!(said.contains("/205.0 @") && said.contains("/60.0 @"), "{said}");
    assert_eq!(bench.say("preheat petg"), "ok\n");
    assert!(bench.say("M105").contains("/235.0 @"));
    assert_eq!(bench.say("M143 S0 P200"), "ok\n");
    assert!(bench.say("preheat pla").contains("205.0 C is above its max_temp 200.0 C"));
    assert!(bench.say("preheat nylon").contains("no heater has a preset nylon"));
    assert_eq!(bench.say("preheat off"), "ok\n");
    assert!(!bench.say("M105").contains("/60.0"));
}

/// Control follows a sensor that slides out: only what the heater takes tells of it.
#[test]
fn a_sensor_that_slides_out_slowly_is_told_by_what_its_heater_takes() {
    let model = ["control = model", "model_capacity = 12", "model_loss = 0.1", "model_fan_loss = 0.02"];
    let more = ["model_late = 1.5", "fan = fan", "max_temp = 400"];
    let plan = model
        .iter()
        .chain(&more)
        .fold(Plan::new(CARTESIAN), |plan, line| plan.set(&format!("[temperature control] hotend.{line}")));
    let mut bench = plan.start();
    bench.say("M109 S200");
    // Neither the fan nor its end is any news.
    for line in ["M106 S255", "M107"] {
        bench.say(line);
        let said = bench.hear(90.0);
        assert!(!said.contains("WARNING"), "{said}");
    }
    let drifts = sim::world::Fault::ThermistorDrifts("hotend".into(), -0.1);
    bench.world(|world| world.inject(&drifts)).expect("a sensor of this machine");
    let said = bench.hear_until("more heat than its model explains", 1_200.0);
    assert!(said.contains("WARNING: T takes 4"), "{said}");
    let is = bench.celsius("hotend");
    assert!((255.0..290.0).contains(&is), "told at {is} C");
    // The message comes only once.
    let said = bench.hear(60.0);
    assert!(!said.contains("its model explains"), "{said}");
}

/// In the first moments nothing is known of a sensor yet: that is no broken one, and no warm one.
#[test]
fn what_needs_a_temperature_right_after_boot_waits_for_the_first_reading() {
    let chip = ["sensor = max31856", "spi_channel = 0", "spi_select_pin = PD10", "tc_averaging = 16"];
    for line in ["M303 P0 S150", "M306 T0 S150", "M116 P0 A15", "M109 S50"] {
        let plan = chip
            .iter()
            .fold(Plan::new(CARTESIAN), |plan, line| plan.set(&format!("[temperature control] hotend.{line}")));
        let plan = plan.set("[player] on_boot_gcode_enable = true");
        let mut bench = plan.file("on_boot.gcode", &format!("{line}\nM118 it is done\n")).start();
        let said = bench.greeting().to_owned() + &bench.hear_until("it is done", 3_000.0);
        assert!(!said.contains("error") && !said.contains("ERROR"), "{line}: {said}");
        // A file is answered to nobody: what was found everybody hears.
        let found = if line.starts_with("M306") { "Model found" } else { "PID tuned: " };
        assert!(!line.starts_with("M30") || said.contains(found), "{line}: {said}");
    }
}

/// A heater that is named in another firmware's way is that one, or the code is refused: nothing looks done.
#[test]
fn a_heater_that_is_not_named_as_here_is_refused_and_marlins_e_is_carried_out() {
    let mut bench = Plan::new(CARTESIAN).start();
    let before = bench.say("M503");
    for (line, why) in [
        ("M301 E0 P22.2 I1.08 D114", "M301: S must say which heater"),
        ("M143 P250", "M143: S must say which heater"),
        ("M305 P1 B4138 R4700", "M305: S must say which heater"),
        ("M307 P40 C12", "M307: S must say which heater"),
        ("M303 E-1 S60 C3", "M303: P must say which heater"),
        ("M104 H1 S200", "M104 takes no H here"),
    ] {
        let said = bench.say(line);
        assert!(said.contains(why) && !said.contains("ok"), "{line}: {said}");
    }
    assert!(bench.say("M503") == before && !bench.heats());
    bench.say("dialect marlin");
    assert_eq!(bench.say("M301 E0 P22.2 I1.08 D114"), "ok\n");
    assert!(bench.say("M301 E0").contains("T(S0): PonM: 0 P: 22.200001 I: 1.080000 D: 114.000000"));
    assert_eq!(bench.say("M301 P23"), "ok\n");
    assert!(bench.say("M301 E0").contains("T(S0): PonM: 0 P: 23.000000 I: 1.080000"));
    assert!(bench.say("M301 E3 P1").contains("no temperature control has tool_id 3"));
    let said = bench.say("M303 E-1 S60 C3");
    assert!(said.contains("Running autopid on (B) bed") && said.contains("PID tuned"), "{said}");
}
