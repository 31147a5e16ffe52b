//! An error in the configuration costs the part it is about: that stays off and says why, the rest works.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta};

fn broken(piece: &str, instead: &str) -> Bench {
    Plan::new(CARTESIAN).with(piece, instead).start()
}

fn moves(bench: &mut Bench) {
    let before = bench.carriage(Alpha);
    bench.run(&["G91", "G1 X5 F3000", "M400", "G90"]);
    assert!((bench.carriage(Alpha) - before - 5.0).abs() < 0.02, "the machine moves");
}

#[test]
fn a_broken_bed_stays_cold_and_the_machine_prints_without_it() {
    let mut bench = broken("bed.max_temp = 120", "bed.max_temp = hot");
    let greeting = bench.greeting().to_owned();
    assert!(greeting.contains("error: [temperature control] bed.max_temp: 'hot' is not a number"), "{greeting}");
    assert!(
        greeting.contains("WARNING: until config.ini is mended these stay off: temperature control bed\n"),
        "{greeting}"
    );
    assert!(!greeting.contains("fatal"), "{greeting}");
    moves(&mut bench);
    let said = bench.say("M140 S60");
    assert!(said.starts_with("error:temperature control bed is off: see [temperature control] bed.max_temp"), "{said}");
    assert!(bench.say("M190 S60").starts_with("error:temperature control bed is off"));
    assert_eq!(bench.say("M140 S0"), "ok\n", "off is no wish");
    bench.run(&["M104 S100"]);
    bench.hear(30.0);
    assert!(bench.duty("bed") == 0.0 && bench.celsius("bed") < 25.0, "the bed heats");
    assert!(bench.celsius("hotend") > 40.0, "the hotend does not");
}

/// Not even the way round the M-codes turns it on.
#[test]
fn nothing_else_heats_a_heater_that_is_off() {
    let mut bench = broken("hotend.thermistor_pin = ADC1_1", "hotend.thermistor_pin = ADC1_9");
    for line in ["M303 P0 S150", "M301 S0 P100", "M143 S0 P300", "M104 S200", "resume"] {
        bench.say(line);
    }
    bench.hear(10.0);
    assert_eq!(bench.duty("hotend"), 0.0);
    assert!(bench.say("M303 P0 S150").contains("is off: see [temperature control] hotend.thermistor_pin"));
}

#[test]
fn a_broken_switch_stays_off() {
    let mut bench = broken("fan.output_type = sigmadeltapwm", "fan.output_type = pwm");
    let said = bench.say("M106 S255");
    assert!(said.starts_with("error:switch fan is off: see [switch] fan.output_type in config.ini, line "), "{said}");
    assert_eq!(bench.say("M107"), "ok\n");
    assert!(bench.say("switch fan on").starts_with("error:switch fan is off"));
    assert_eq!(bench.say("switch fan"), "switch fan is 0\nok\n");
    moves(&mut bench);
}

#[test]
fn a_broken_extruder_refuses_filament_and_nothing_else() {
    let mut bench = broken("hotend.filament_diameter = 0 ", "hotend.filament_diameter = thick ");
    for line in ["G1 E5 F300", "G10", "G11"] {
        assert!(bench.say(line).starts_with("error:extruder hotend is off"), "{line}");
    }
    bench.run(&["G92 E0", "M400"]);
    assert!(bench.carriage(Delta).abs() < 1e-9);
    moves(&mut bench);
}

#[test]
fn a_broken_probe_leaves_probing_refused() {
    let mut bench = Plan::new(CARTESIAN).adding("\n[zprobe]\nenable = true\nprobe_pin = PL1\n").start();
    assert!(bench.say("G30").starts_with("error:[zprobe] is off: see [zprobe] "));
    moves(&mut bench);
}

#[test]
fn a_broken_player_plays_nothing() {
    let plan = Plan::new(CARTESIAN).adding("\n[player]\nleave_heaters_on_suspend = maybe\n");
    let mut bench = plan.file("part.gcode", "G91\nG1 X50 F3000\n").file("on_boot.gcode", "G91\nG1 X50 F3000\n").start();
    bench.hear(3.0);
    for line in ["M23 part.gcode", "M24", "M32 part.gcode", "M600"] {
        assert!(bench.say(line).starts_with("error:[player] is off"), "{line}");
    }
    assert!(bench.ask("play /sd/part.gcode").starts_with("error:[player] is off"));
    assert_eq!(bench.world(|world| world.trace().total()), 0, "a file was played");
    moves(&mut bench);
}

/// A spindle that does not turn breaks the tool: the file must not go on.
#[test]
fn a_job_that_needs_a_part_that_is_off_halts() {
    let plan = Plan::new(CARTESIAN).with("fan.output_type = sigmadeltapwm", "fan.output_type = pwm");
    let mut bench = plan.file("part.gcode", "G91\nM106 S255\nG1 X50 F3000\n").start();
    bench.say("M23 part.gcode");
    let said = bench.say("M24") + &bench.hear(1.0);
    assert!(said.contains("Entering Alarm/Halt state"), "{said}");
    assert!(said.contains("Error: switch fan is off: see [switch] fan.output_type"), "{said}");
    assert_eq!(bench.world(|world| world.trace().total()), 0);
}

#[test]
fn an_error_that_motion_depends_on_leaves_nothing_but_console_and_card() {
    let mut bench = broken("minx.pin = PD0^", "minx.pin = PD0+");
    assert!(bench.greeting().contains("fatal: [endstops] minx.pin"), "{}", bench.greeting());
    for line in ["G28", "G1 X5 F600", "M104 S200", "M106"] {
        assert!(bench.say(line).contains("mend config.ini"), "{line}");
    }
    assert!(bench.say("M20").contains("config.ini"));
    bench.hear(5.0);
    assert!(bench.duty("hotend") == 0.0 && !bench.is_energised(Alpha));
}
