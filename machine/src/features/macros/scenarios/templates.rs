//! Templates of other sections than macros: buttons, filament sensors, the probe.

use scenarios::{Bench, Plan};
use sim::models::surface::{Bed, Surface};
use units::Actuator::Alpha;

use super::with;

const TEXT: &str = "\
[gcode_button stop]
pin: PB1
press_gcode:
  {% for turn in range(2) %}
    RESPOND MSG=\"turn {turn} of {params.COUNT|default(2)}\"
  {% endfor %}
release_gcode: {action_raise_error('let go')}
[filament_switch_sensor runout]
runout_gcode:
  RESPOND MSG=\"out at {printer.pause_resume.is_paused}\"
insert_gcode: RESPOND MSG=\"in\"
";

fn press(bench: &mut Bench, name: &str, is_pressed: bool) {
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, name, is_pressed)).expect("an input of this machine");
}

#[test]
fn a_template_of_any_section_is_carried_out() {
    let mut bench = with(TEXT).start();
    let said = bench.say("RUN_TEMPLATE SECTION=\"gcode_button stop\" OPTION=press_gcode COUNT=5");
    assert_eq!(said, "echo: turn 0 of 5\necho: turn 1 of 5\nok\n");
    for (line, why) in [
        ("SECTION=\"gcode_button stop\" OPTION=release_gcode", "error:let go"),
        ("SECTION=\"gcode_button stop\" OPTION=other_gcode", "error:[stop] has no option other_gcode"),
        (
            "SECTION=\"gcode_button go\" OPTION=press_gcode",
            "error:RUN_TEMPLATE: the printer.cfg has no [gcode_button go]",
        ),
        ("SECTION=\"gcode_button stop\"", "error:RUN_TEMPLATE needs SECTION= and OPTION="),
    ] {
        let said = bench.say(&format!("RUN_TEMPLATE {line}"));
        assert!(said.starts_with(why), "{said}");
    }
}

#[test]
fn a_button_carries_its_templates_out() {
    let mut bench = with(TEXT)
        .set("[button box] stop.pin = PB7^")
        .set("[button box] stop.press = RUN_TEMPLATE SECTION=\"gcode_button stop\" OPTION=press_gcode")
        .set("[button box] stop.release = RUN_TEMPLATE SECTION=\"gcode_button stop\" OPTION=release_gcode")
        .start();
    bench.hear(0.5);
    press(&mut bench, "stop", true);
    assert_eq!(bench.hear(0.5), "echo: turn 0 of 2\necho: turn 1 of 2\n");
    press(&mut bench, "stop", false);
    assert!(bench.hear(0.5).contains("let go"));
}

fn with_detector(suspends: bool) -> Plan {
    let line = |option: &str| {
        format!("[filament detector] {option} = RUN_TEMPLATE SECTION=\"filament_switch_sensor runout\" OPTION={option}")
    };
    with(TEXT)
        .set("[filament detector] enable = true")
        .set("[filament detector] detector_pin = PB7^")
        .set(&format!("[filament detector] suspends = {suspends}"))
        .set(&line("runout_gcode"))
        .set(&line("insert_gcode"))
        .file("a.g", "G91\nG1 X10 F600\nG1 X10\nG1 X10\n")
}

#[test]
fn filament_that_runs_out_acts_once_the_job_is_suspended() {
    let mut bench = with_detector(true).start();
    bench.type_in("M32 a.g\n");
    bench.hear(0.5);
    press(&mut bench, "filament", true);
    let said = bench.hear(5.0);
    assert!(said.contains("the job is being suspended") && said.contains("echo: out at True"), "{said}");
    press(&mut bench, "filament", false);
    let said = bench.hear(0.5);
    assert!(said.contains("echo: in"), "{said}");
    bench.type_in("resume\n");
    bench.hear_until("Done printing file", 30.0);
}

#[test]
fn without_a_suspension_the_job_goes_on() {
    let mut bench = with_detector(false).start();
    let before = bench.carriage(Alpha);
    bench.type_in("M32 a.g\n");
    bench.hear(0.5);
    press(&mut bench, "filament", true);
    let said = bench.hear(1.0);
    assert!(said.contains("NOTE the filament has run out") && said.contains("echo: out at False"), "{said}");
    press(&mut bench, "filament", false);
    assert!(!bench.hear(0.5).contains("echo: in"), "not while a job runs");
    press(&mut bench, "filament", true);
    let said = bench.hear_until("Done printing file", 30.0);
    assert!(said.contains("echo: out at False"), "once more: {said}");
    assert!((bench.carriage(Alpha) - before - 30.0).abs() < 0.05);
}

fn with_probe(text: &str) -> Bench {
    let line = |option: &str| format!("RUN_TEMPLATE SECTION=probe OPTION={option}");
    let mut bench = with(text)
        .set("[zprobe] enable = true")
        .set("[zprobe] probe_pin = PB10^")
        .set("[zprobe] slow_feedrate = 5")
        .set("[zprobe] max_travel = 60")
        .set(&format!("[zprobe] deploy_gcode = {}", line("activate_gcode")))
        .set(&format!("[zprobe] stow_gcode = {}", line("deactivate_gcode")))
        .start_homed();
    bench.run(&["G1 X50 Y60 Z20 F6000", "M400"]);
    bench.lay(Surface { bed: Some(Bed::level(1.5)), ..Surface::default() });
    bench
}

#[test]
fn a_probe_is_brought_out_and_away_by_templates() {
    let text = "[probe]\nactivate_gcode:\n  {% if printer.toolhead.homed_axes != 'xyz' %}\n    {action_raise_error('home')}\n  \
                {% endif %}\n  {action_respond_info('out')}\n  OUT BY=7\n  SET_PIN PIN=fan VALUE=0.5\n  G4 P100\n\
                deactivate_gcode: {action_respond_info('away')}\n\
                [gcode_macro OUT]\ngcode:\n  G53 G0 X{50 + params.BY|int}\n  G4 P10\n\
                [gcode_macro TOUCH]\ngcode:\n  G30\n  RESPOND MSG=touched\n";
    let mut bench = with_probe(text);
    let said = bench.say("TOUCH");
    let [out, away, touched] = ["// out\n", "// away\n", "echo: touched\n"].map(|text| said.find(text));
    assert!(out.is_some() && out < away && away < touched, "{said}");
    let said = bench.say("switch fan");
    assert!(said.contains("is 1"), "{said}");
    let [_, most] = bench.world(|world| world.reached_mm(Alpha)).expect("a motor");
    assert!((most - 57.0).abs() < 0.1, "the macro has moved aside: {most}");
}

#[test]
fn what_a_probe_cannot_carry_out_is_named_and_nothing_is_probed() {
    for (lines, why) in [
        ("G28", "[zprobe] deploy_gcode: G28 is none of moves"),
        ("SET_HEATER_TEMPERATURE HEATER=extruder TARGET=50", "heats: a probe's script does not"),
        ("SAVE_VARIABLE VARIABLE=a VALUE=1", "[zprobe] deploy_gcode: SAVE_VARIABLE is none of moves"),
        ("NOT_THERE", "[zprobe] deploy_gcode: NOT_THERE is not known here"),
        ("{nothing.more}", "printer.cfg line 3 column"),
        ("DEEP", "DEEP: a macro that is under way is called recursively"),
    ] {
        let text =
            format!("[probe]\nactivate_gcode:\n  {lines}\ndeactivate_gcode: G4 P1\n[gcode_macro DEEP]\ngcode: DEEP\n");
        let mut bench = with_probe(&text);
        let said = bench.say("G30");
        assert!(said.contains("error:") && said.contains(why), "{lines}: {said}");
        bench.run(&["G4 P1"]);
    }
}
