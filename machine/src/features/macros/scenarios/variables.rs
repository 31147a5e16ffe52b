//! Variables of macros, variables on the card, G-code that comes later, the configuration's text.

use super::with;

#[test]
fn variables_are_set_and_read() {
    let text = "[gcode_macro COUNT]\nvariable_n: 1\nvariable_list: [1, 'two']\ngcode:\n  \
                RESPOND MSG=\"{n} {list[1]} {printer['gcode_macro COUNT'].n + 1}\"\n  \
                SET_GCODE_VARIABLE MACRO=COUNT VARIABLE=n VALUE={n + 1}\n";
    let mut bench = with(text).start();
    assert_eq!(bench.say("COUNT"), "echo: 1 two 2\nok\n");
    assert_eq!(bench.say("COUNT"), "echo: 2 two 3\nok\n");
    bench.run(&["SET_GCODE_VARIABLE MACRO=count VARIABLE=list VALUE=\"{'a': (1,)}\""]);
    assert_eq!(bench.say("COUNT"), "echo: 3  4\nok\n", "a dict without this key");
    for (line, why) in [
        ("SET_GCODE_VARIABLE MACRO=COUNT VARIABLE=m VALUE=1", "no variable_m"),
        ("SET_GCODE_VARIABLE MACRO=NONE VARIABLE=m VALUE=1", "no macro NONE"),
        ("SET_GCODE_VARIABLE MACRO=COUNT VARIABLE=n VALUE=word", "quotes"),
        ("SET_GCODE_VARIABLE MACRO=COUNT VARIABLE=n", "needs"),
    ] {
        let said = bench.say(line);
        assert!(said.starts_with("error:") && said.contains(why), "{line}: {said}");
    }
    bench.say("macros reload");
    assert_eq!(bench.say("COUNT"), "echo: 1 two 2\nok\n");
}

#[test]
fn saved_variables_outlast_a_power_cycle() {
    let text = "[save_variables]\nfilename: ~/printer_data/config/variables.cfg\n[gcode_macro TELL]\ngcode:\n  \
                {% set kept = printer.save_variables.variables %}\n  \
                RESPOND MSG=\"{kept.height|default('none')} {kept|length}\"\n";
    let mut bench = with(text).start();
    assert_eq!(bench.say("TELL"), "echo: none 0\nok\n");
    bench.run(&["SAVE_VARIABLE VARIABLE=height VALUE=2.50", "SAVE_VARIABLE VARIABLE=a VALUE=\"'x'\""]);
    assert_eq!(bench.read_card("variables.cfg").unwrap(), "[Variables]\na = 'x'\nheight = 2.5\n\n");
    bench.cycle_power();
    bench.hear(0.5);
    assert_eq!(bench.say("TELL"), "echo: 2.5 2\nok\n");
    let said = bench.say("SAVE_VARIABLE VARIABLE=Height VALUE=1");
    assert!(said.contains("upper case"), "{said}");
    let mut bench = with("[printer]\n").start();
    assert!(bench.say("SAVE_VARIABLE VARIABLE=a VALUE=1").contains("[save_variables]"));
}

#[test]
fn delayed_code_comes_when_it_is_due() {
    let text = "[delayed_gcode first]\ninitial_duration: 2\ngcode: RESPOND MSG=first\n[delayed_gcode again]\n\
                gcode:\n  RESPOND MSG=again\n  UPDATE_DELAYED_GCODE ID=again DURATION=1\n";
    let mut bench = with(text).start();
    bench.hear_until("echo: first", 3.0);
    bench.run(&["UPDATE_DELAYED_GCODE ID=again DURATION=0.5"]);
    let heard = bench.hear(2.7);
    assert_eq!(heard.matches("echo: again").count(), 3, "{heard}");
    bench.run(&["UPDATE_DELAYED_GCODE ID=again DURATION=0"]);
    assert_eq!(bench.hear(2.0), "");
    assert!(bench.say("UPDATE_DELAYED_GCODE ID=none DURATION=1").contains("no [delayed_gcode none]"));
}

#[test]
fn an_idle_machine_does_what_the_configuration_says() {
    let text = "[idle_timeout]\ntimeout: 3\ngcode:\n  RESPOND MSG=\"idle\"\n[gcode_macro TELL]\n\
                gcode: RESPOND MSG=\"{printer.idle_timeout.state}\"\n";
    let mut bench = with(text).start();
    bench.hear_until("echo: idle", 4.0);
    assert_eq!(bench.hear(5.0), "", "once");
    bench.run(&["SET_IDLE_TIMEOUT TIMEOUT=1"]);
    assert_eq!(bench.say("TELL"), "echo: Ready\nok\n");
    bench.hear_until("echo: idle", 2.0);
    let mut bench = with("[idle_timeout]\ntimeout: 2\n").start();
    bench.run(&["M104 S50"]);
    bench.hear(3.0);
    assert!(bench.say("get temp hotend").contains("/0.0"));
}

#[test]
fn the_configuration_answers_with_klippers_types() {
    let text = "[stepper_x]\nposition_max: 250\nmicrosteps: 16\n[bed_mesh]\nmesh_min: 10, 5.5\n[gcode_macro TELL]\n\
                gcode:\n  {% set s = printer.configfile.settings %}\n  \
                RESPOND MSG=\"{s.stepper_x.position_max} {s['stepper_x'].microsteps} {s.bed_mesh.mesh_min[1]}\"\n  \
                RESPOND MSG=\"{s.stepper_x.homing_speed} {'bed_mesh' in s} {'probe' in s} {s.none is defined}\"\n  \
                RESPOND MSG=\"{printer.configfile.config.stepper_x.position_max ~ '!'}\"\n";
    let mut bench = with(text).start();
    assert_eq!(bench.say("TELL"), "echo: 250.0 16 5.5\necho: 5.0 True False False\necho: 250!\nok\n");
}

#[test]
fn the_machine_answers_in_klippers_names() {
    let text = "[gcode_macro TELL]\ngcode:\n  {% set t = printer.toolhead %}\n  \
                RESPOND MSG=\"{t.homed_axes} {t.axis_maximum.x} {t.position.x} {t.position[1]} {t.extruder}\"\n  \
                {% set m = printer.gcode_move %}\n  \
                RESPOND MSG=\"{m.gcode_position.x} {m.absolute_coordinates} {m.speed} {m.speed_factor}\"\n  \
                RESPOND MSG=\"{printer.print_stats.state} {printer.pause_resume.is_paused} {printer.fan.speed}\"\n  \
                RESPOND MSG=\"{printer[t.extruder].can_extrude} {'extruder' in printer} {'probe' in printer}\"\n  \
                RESPOND MSG=\"{printer.heaters.available_heaters|join(' ')} {printer.query_endstops.last_query.x}\"\n";
    let mut bench = with(text).start_homed();
    bench.run(&["G0 X20 Y10 F3000", "G92 X5", "M400", "M106 S255"]);
    let said = bench.say("TELL");
    let lines: Vec<&str> = said.lines().collect();
    assert!(lines[0].starts_with("echo: xyz ") && lines[0].ends_with(" 20.0 10.0 extruder"), "{said}");
    assert_eq!(lines[1], "echo: 5.0 True 3000.0 1.0", "{said}");
    assert_eq!(lines[2], "echo: standby False 1.0", "{said}");
    assert_eq!(lines[3], "echo: True True False", "{said}");
    assert_eq!(lines[4], "echo: heater_bed extruder 0", "{said}");
}

#[test]
fn modes_are_kept_by_names() {
    let mut bench = with("[printer]\n").start_homed();
    bench.run(&["G90", "G0 X30 Y20 F3000", "SAVE_GCODE_STATE NAME=one", "G91", "G0 X5", "SAVE_GCODE_STATE NAME=two"]);
    bench.run(&["G90", "RESTORE_GCODE_STATE NAME=two", "G0 X5", "M400"]);
    assert!(bench.say("M114").contains("X:40.0"), "relative again");
    bench.run(&["RESTORE_GCODE_STATE NAME=one MOVE=1 MOVE_SPEED=50", "M400"]);
    assert!(bench.say("M114").contains("X:30.0"), "back where it was");
    bench.run(&["G0 X6", "M400"]);
    assert!(bench.say("M114").contains("X:6.0"), "absolute again");
    bench.run(&["M302 P1", "G92 E10", "SAVE_GCODE_STATE", "M83", "G1 E-4 F600", "RESTORE_GCODE_STATE", "M400"]);
    let said = bench.say("M114");
    assert!(said.contains("E:10.0"), "the extruder counts on from where it was: {said}");
    assert!(bench.say("RESTORE_GCODE_STATE NAME=three").contains("no state is kept as three"));
    for wrong in ["MOVE=yes", "MOVE=1 MOVE_SPEED=fast"] {
        let said = bench.say(&format!("RESTORE_GCODE_STATE NAME=one {wrong}"));
        assert!(said.starts_with("error:") && said.contains("MOVE and MOVE_SPEED are numbers"), "{said}");
    }
}

#[test]
fn the_filament_detector_is_seen_with_its_switch() {
    let text = "[gcode_macro TELL]\ngcode:\n {% set sensor = printer['filament_switch_sensor runout'] %}\n \
                RESPOND MSG=\"{sensor.enabled} {sensor.filament_detected}\"\n";
    let detector = "\n[filament detector]\nenable = true\ndetector_pin = PB7^\n";
    let mut bench = with(text).adding(detector).start();
    assert_eq!(bench.say("TELL"), "echo: True True\nok\n");
    let at_ns = (bench.now_s() * 1e9) as u64;
    bench.world(|world| world.press(at_ns, "filament", true)).expect("an input of this machine");
    bench.hear(2.0);
    assert_eq!(bench.say("TELL"), "echo: True False\nok\n");
    bench.say("SET_FILAMENT_SENSOR SENSOR=runout ENABLE=0");
    assert_eq!(bench.say("TELL"), "echo: False True\nok\n");
}

#[test]
fn objects_of_the_print_are_seen_with_their_outlines() {
    let text = "[extruder]\nnozzle_diameter: 0.5\n[gcode_macro AREA]\ngcode:\n \
                {% set all = printer.exclude_object.objects | map(attribute='polygon') | sum(start=[]) %}\n \
                RESPOND MSG=\"{all | map(attribute=0) | min | default(-1)} {all | map(attribute=1) | max | default(-1)}\"\n \
                {% for object in printer.exclude_object.objects %}\n \
                RESPOND MSG=\"{object.name} at {object.center[0]}\"\n {% endfor %}\n \
                RESPOND MSG=\"{printer.exclude_object.current_object} of {printer.exclude_object.excluded_objects}\"\n \
                RESPOND MSG=\"{printer.configfile.settings.extruder.max_extrude_cross_section}\"\n";
    let mut bench = super::with(text).start();
    assert_eq!(bench.say("AREA"), "echo: -1 -1\necho: None of []\necho: 1.0\nok\n");
    bench.run(&[
        "EXCLUDE_OBJECT_DEFINE NAME=A POLYGON=[[10,20],[30,20],[30,50]]",
        "EXCLUDE_OBJECT_DEFINE NAME=B POLYGON=[[60,5],[70,8]]",
        "EXCLUDE_OBJECT_START NAME=A",
    ]);
    bench.say("EXCLUDE_OBJECT NAME=B");
    let said = "echo: 10.0 50.0\necho: A at 20.0\necho: B at 65.0\necho: A of ['B']\necho: 1.0\nok\n";
    assert_eq!(bench.say("AREA"), said);
}

#[test]
fn more_of_the_machine_is_seen_by_klippers_names() {
    let text = "[z_tilt]\n[bed_mesh]\n[probe]\nspeed: 7\n[stepper_x]\n[gcode_macro TELL]\ngcode:\n \
                RESPOND MSG=\"{printer.z_tilt.applied} {'quad_gantry_level' in printer} {printer.display_status.message}\"\n \
                {% set p = printer.bed_mesh.profiles %}\n RESPOND MSG=\"{p|length} {'pei' in p} {'glass' in p} {p|list|join}\"\n \
                {% set s = printer.configfile.settings %}\n \
                RESPOND MSG=\"{s.probe.lift_speed} {s.probe.samples} {s.z_tilt.retries} {s.bed_mesh.probe_count[1]}\"\n \
                RESPOND MSG=\"{s.stepper_x.homing_retract_speed} {'lift_speed' in printer.configfile.config.probe}\"\n";
    let mut bench = with(text).file("pei.mesh", "x").file("note.txt", "x").start();
    bench.run(&["M117 Layer 5"]);
    let said = "echo: False False Layer 5\necho: 1 True False pei\necho: 7.0 1 0 3\necho: 5.0 False\nok\n";
    assert_eq!(bench.say("TELL"), said);
    bench.run(&["M117"]);
    assert!(bench.say("TELL").starts_with("echo: False False None\n"), "an empty text takes it away");
    bench.run(&[&format!("M117 {}", "é".repeat(40))]);
    assert!(bench.say("TELL").contains(&format!(" {}\n", "é".repeat(32))), "as much as is kept, in whole letters");
}

#[test]
fn a_sender_that_is_too_slow_is_counted() {
    let text = "[gcode_macro STALLS]\ngcode: RESPOND MSG=\"{printer.toolhead.stalls}\"\n";
    let mut bench = with(text).start();
    bench.run(&["G91"]);
    assert_eq!(bench.say("STALLS"), "echo: 0\nok\n");
    bench.type_in("G1 X30 F3000\n");
    bench.hear(0.4);
    for _ in 0..60 {
        bench.type_in("G1 X0.5\n");
        bench.hear(0.02);
    }
    bench.hear(1.0);
    let said = bench.say("STALLS");
    assert!(said != "echo: 0\nok\n" && said.ends_with("\nok\n"), "{said}");
}
