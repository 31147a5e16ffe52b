//! `[homing_override]`: what stands for G28, when, and who can begin it.

use scenarios::Bench;
use units::Actuator::{Alpha, Gamma};

use super::with;

/// Homes X and Y, and goes aside; Z is lifted from where the file says that it is.
const OVERRIDE: &str = "\
[homing_override]
axes: z
set_position_z: 5
gcode:
  RESPOND MSG=\"{params.X|default('no')} {'Z' in params} {printer.toolhead.homed_axes} {printer.toolhead.position.z}\"
  G90
  G1 Z7 F600
  G28 X Y
  G1 X30 F6000
  G28 Z
";

/// Returns where X is, and how far Z has been lifted since the start.
fn at(bench: &mut Bench) -> f64 {
    bench.run(&["M400"]);
    bench.carriage(Alpha)
}

#[test]
fn a_template_stands_for_homing_whoever_asks() {
    for (line, said) in [
        ("G28", "echo: no False z 5.0\nok\n"),
        ("G28 X0 Z", "echo: 0 True z 5.0\nok\n"),
        ("$H", "echo: no False z 5.0\nok\n"),
        ("PARK", "echo: no True z 5.0\nok\n"),
    ] {
        let mut bench = with(&(OVERRIDE.to_string() + "[gcode_macro PARK]\ngcode:\n  G28 Z0\n")).start();
        assert_eq!(bench.say(line), said, "{line}");
        assert!((at(&mut bench) - 30.0).abs() < 0.05, "{line}: {}", bench.carriage(Alpha));
        assert!(bench.say("G28.6").contains("X:1 Y:1 Z:1"), "{line}");
    }
}

#[test]
fn axes_that_the_template_is_not_for_home_as_ever() {
    let mut bench = with(OVERRIDE).start();
    assert_eq!(bench.say("G28 X Y"), "ok\n");
    assert!(at(&mut bench).abs() < 0.05);
    assert!(bench.say("G28.6").contains("Z:0"), "Z was not declared");
    let mut bench = with(&OVERRIDE.replace("axes: z\n", "")).start();
    assert!(bench.say("G28 X").starts_with("echo: "), "all axes without the option");
}

#[test]
fn a_job_homes_by_it_and_can_be_held() {
    let mut bench = with(OVERRIDE).file("a.g", "G28\nG91\nG1 X10 F6000\n").start();
    bench.type_in("M32 a.g\n");
    bench.hear_until("echo: no", 5.0);
    bench.type_in("!");
    bench.hear(1.0);
    let held = [Alpha, Gamma].map(|motor| bench.carriage(motor));
    bench.hear(1.0);
    assert_eq!([Alpha, Gamma].map(|motor| bench.carriage(motor)), held);
    bench.type_in("~");
    bench.hear_until("Done printing file", 60.0);
    assert!((at(&mut bench) - 40.0).abs() < 0.05);
}

#[test]
fn a_macro_that_has_taken_g28_leads_to_it() {
    let text = OVERRIDE.to_string()
        + "[gcode_macro G28]\nrename_existing: G28.9\ngcode:\n  RESPOND MSG=before\n  G28.9 {rawparams}\n";
    let mut bench = with(&text).start();
    // Within the template G28 is the macro that is under way, as in Klipper.
    let said = bench.say("G28 X1");
    assert!(said.starts_with("echo: before\n") && !said.contains("echo: 1"), "X homes as ever: {said}");
    let text = text.replace("  G28 X Y\n", "  G28.9 X Y\n").replace("  G28 Z\n", "  G28.9 Z\n");
    let mut bench = with(&text).start();
    assert_eq!(bench.say("G28 Z0"), "echo: before\necho: no True z 5.0\nok\n");
    assert!((at(&mut bench) - 30.0).abs() < 0.05);
}

#[test]
fn what_is_wrong_in_it_is_named_before_anything_moves() {
    for (text, why) in [
        (
            "[homing_override]\nset_position_z: low\ngcode:\n  G28\n",
            "[homing_override] set_position_z: this is no number",
        ),
        ("[homing_override]\ngcode:\n  G28\n  {nothing.more}\n", "printer.cfg line 4 column"),
        ("[homing_override]\naxes: z\n", "[homing_override] has no option gcode"),
    ] {
        let mut bench = with(text).start();
        let before = bench.carriage(Alpha);
        let said = bench.say("G28");
        assert!(said.starts_with("error:") && said.contains(why), "{said}");
        assert_eq!(bench.carriage(Alpha), before, "{text}");
    }
}

/// Where Z has no switch, a line of the configuration homes it, within the template too.
#[test]
fn z_homes_by_a_line_within_it() {
    let plan = |text: &str| {
        let line = "[endstops] common.home_z_gcode = G91_G1_Z3_F600_G90_G28.3_Z12";
        with(text).set("[endstops] minz.enable = false").set(line)
    };
    let mut bench = plan(OVERRIDE).start();
    assert_eq!(bench.say("G28"), "echo: no False z 5.0\nok\n");
    bench.run(&["M400"]);
    assert!(bench.say("M114.2").contains("Z:12"), "{}", bench.say("M114.2"));
    let mut bench = plan("[printer]\n").start();
    bench.run(&["G28", "M400"]);
    assert!(bench.say("G28.6").contains("X:1 Y:1") && bench.say("M114.2").contains("Z:12"));
    bench.run(&["G1 X20 F6000", "G28 Z", "M400"]);
    assert!((at(&mut bench) - 20.0).abs() < 0.05, "Z alone");
}

#[test]
fn a_grid_is_not_measured_by_homing_past_it() {
    let mut bench = with(OVERRIDE)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] leveling = cartesian grid")
        .set("[cartesian grid leveling strategy] x_size = 100")
        .set("[cartesian grid leveling strategy] y_size = 100")
        .start();
    assert!(bench.say("G32").starts_with("error:home the machine with G28 first: home_gcode or [homing_override]"));
}
