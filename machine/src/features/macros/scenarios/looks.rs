//! The look at a job before it begins reads through macros.

use scenarios::{Bench, Plan};

use super::with;

/// Returns a plan whose jobs are looked at whole before they begin.
fn refusing(text: &str) -> Plan {
    with(text).adding("\n[player]\npreflight = refuse\n")
}

/// Returns what `check` says of a file.
fn check(bench: &mut Bench, file: &str) -> String {
    bench.say(&std::format!("check {file}"))
}

/// Returns what a machine with these macros says of this job.
fn checked(macros: &str, job: &str) -> String {
    let mut bench = with(macros).file("a.g", job).start();
    bench.run(&["G28"]);
    let said = check(&mut bench, "a.g");
    assert!(bench.say("G4 P1").ends_with("ok\n"));
    said
}

#[test]
fn a_name_that_nobody_knows_is_found_and_those_of_macros_are_not() {
    let text = "[gcode_macro ONE]\ngcode: G4 P1\n[gcode_macro M109]\nrename_existing: M109.1\ngcode: M109.1 S{params.S}\n\
                [gcode_macro PAUSE]\nrename_existing: BASE_PAUSE\ngcode: BASE_PAUSE\n[gcode_macro G28.7]\ngcode: ONE\n";
    let said = checked(text, "ONE\none\nM109 S40\nM109.1 S40\nBASE_PAUSE\nG28.7\nSAVE_GCODE_STATE\nPARK\n");
    assert!(said.starts_with("line 8: stops: PARK is not known here"), "{said}");
    assert_eq!(said.matches("stops").count(), 1, "{said}");
    let mut bench = refusing(text).file("a.g", "G28\nONE\nPARK\n").file("b.g", "G28\nONE\n").start();
    bench.type_in("M32 a.g\n");
    let said = bench.hear_until("begins it all the same", 5.0);
    assert!(said.contains("line 3: stops: PARK is not known here"), "{said}");
    bench.type_in("M32 b.g\n");
    bench.hear_until("Done printing file", 60.0);
}

#[test]
fn positions_and_modes_are_followed_through_macros() {
    let text = "[gcode_macro ASIDE]\ngcode:\n  SAVE_GCODE_STATE NAME=aside\n  G91\n  INNER BY={params.BY}\n  \
                RESTORE_GCODE_STATE NAME=aside\n[gcode_macro INNER]\ngcode:\n  {% for turn in range(2) %}\n  \
                G1 X{params.BY} F6000\n  {% endfor %}\n[gcode_macro BACK]\ngcode:\n  SAVE_GCODE_STATE\n  G1 X5 Y7\n  \
                RESTORE_GCODE_STATE MOVE=1\n";
    let said = checked(text, "G90\nG1 X100 F6000\nASIDE BY=30\nG1 X100\nASIDE BY=70\nG1 X0\n");
    assert!(said.starts_with("line 5: stops: INNER line 5: machine X 240.000 is out of travel"), "{said}");
    assert_eq!(said.matches("stops").count(), 1, "G91 is over behind it: {said}");
    let said = checked(text, "G90\nG1 X200 F6000\nBACK\nG91\nG1 X30\n");
    assert!(said.starts_with("line 5: stops: machine X 230.000"), "{said}");
}

#[test]
fn a_job_whose_macro_leaves_the_travel_is_not_begun() {
    let text = "[gcode_macro PARK]\ngcode:\n  G90\n  G1 X{params.X|default(999)} F6000\n";
    let mut bench = with(text).file("a.g", "G28\nPARK\n").file("b.g", "G28\nPARK X=50\n").start();
    bench.type_in("M32 a.g\n");
    let said = bench.hear_until("begins it all the same", 5.0);
    assert!(said.contains("// WARNING line 2: stops: PARK line 3: machine X 999.000 is out of travel"), "{said}");
    assert!(said.contains("it would leave the travel"), "{said}");
    bench.type_in("M32 b.g\n");
    let said = bench.hear_until("Done printing file", 60.0);
    assert!(!said.contains("//"), "{said}");
}

#[test]
fn temperatures_and_time_behind_a_macro_count() {
    let text = "[gcode_macro PRINT_START]\ngcode:\n  M104 S{params.T}\n  G4 P{90000}\n";
    let said = checked(text, "PRINT_START T=500\n");
    assert!(said.starts_with("line 1: stops: PRINT_START line 2: hotend") && said.contains("00:01:3"), "{said}");
    let said = checked(text, "PRINT_START T=200\nG1 X10 E5 F600\n");
    assert!(!said.contains("is fed while"), "{said}");
    let said = checked(text, "PRINT_START T=0\nG1 X10 E5 F600\n");
    assert!(said.contains("line 2: warning: filament is fed while hotend is off"), "{said}");
}

#[test]
fn what_depends_on_the_state_of_the_machine_stops_no_job() {
    let text = "[gcode_macro HOMES]\ngcode:\n  {% if 'x' not in printer.toolhead.homed_axes %}\n    G28\n  {% endif %}\n\
                [gcode_macro LIFTS]\ngcode:\n  G90\n  G1 Z{printer.toolhead.position.z + 500} F600\n\
                [gcode_macro LIMITS]\ngcode:\n  G90\n  G1 X{printer.toolhead.axis_maximum.x + 5} F6000\n";
    let said = checked(text, "HOMES\nG1 X10 F6000\nLIFTS\n");
    assert!(said.starts_with("line 3: warning: LIFTS line 3: machine Z 500.000 is out of travel"), "{said}");
    let said = checked(text, "LIMITS\n");
    assert!(said.starts_with("line 1: stops: LIMITS line 3: machine X 225.000"), "a limit is no state: {said}");
    let homes = "\n[motion control]\nmust_be_homed = true\n";
    let mut bench = refusing(text).adding(homes).file("a.g", "G28.5\nHOMES\nG1 X10 F6000\n").start();
    bench.run(&["G28"]);
    let said = check(&mut bench, "a.g");
    assert!(said.contains("line 3: warning: Must be homed") && !said.contains("stops:"), "{said}");
    bench.type_in("M32 a.g\n");
    bench.hear_until("Done printing file", 60.0);
}

#[test]
fn a_macro_that_cannot_be_rendered_now_is_a_remark() {
    let text = "[gcode_macro PRINT_START]\ngcode:\n  {% if printer.toolhead.homed_axes == '' %}\n    \
                {action_raise_error('home first')}\n  {% endif %}\n  M104 S200\n\
                [gcode_macro LATER]\ngcode: G1 X{nothing.more}\n[gcode_macro STOPS]\ngcode: \
                {action_emergency_stop('too hot')}\n[gcode_macro SAYS]\ngcode: {action_respond_info('hello')}\n";
    let job = "G28\nPRINT_START\nG1 X10 E5 F6000\nLATER\nSTOPS\nSAYS\n";
    let plan = refusing(text).adding("\n[motion control]\nmust_be_homed = true\n");
    let mut bench = plan.file("a.g", job).file("b.g", "G28\nPRINT_START\nG1 X20 F6000\n").start();
    let said = check(&mut bench, "a.g");
    assert!(said.starts_with("line 2: warning: PRINT_START could not be looked into: home first"), "{said}");
    assert!(said.contains("line 4: warning: LATER could not be looked into: printer.cfg line 8 column"), "{said}");
    assert!(said.contains("line 5: warning: STOPS could not be looked into: it stops the machine"), "{said}");
    assert!(!said.contains("stops: ") && !said.contains("is fed while") && !said.contains("hello"), "{said}");
    assert!(bench.status().starts_with("<Idle"), "nothing has stopped it");
    bench.type_in("M32 b.g\n");
    bench.hear_until("Done printing file", 60.0);
    assert!(bench.say("M114").contains("X:20.0"), "it was begun");
}

#[test]
fn wrong_macros_and_endless_ones_stop_a_job() {
    let text = "[gcode_macro LOOPS]\ngcode: AGAIN\n[gcode_macro AGAIN]\ngcode: LOOPS\n[gcode_macro WRONG]\n\
                gcode: {% if %}\n[gcode_macro LONG]\ngcode: M117 {'x' * 300}\n[gcode_macro SHORT]\ngcode: G777\n";
    let said = checked(text, "LOOPS\nWRONG\nLONG\nSHORT\nG28 ; behind it\n");
    let begins = [
        "line 1: stops: AGAIN line 1: LOOPS: a macro that is under way is called recursively (correct the macro)",
        "line 2: stops: printer.cfg line",
        "line 3: stops: LONG: a line has more than 255 bytes",
        "line 4: stops: SHORT line 1: ",
    ];
    said.lines().zip(begins).for_each(|(line, begin)| assert!(line.starts_with(begin), "{line}: {said}"));
}

#[test]
fn variables_that_a_job_sets_are_not_followed_and_make_a_guess() {
    let text = "[gcode_macro GOES]\nvariable_x: 999\ngcode:\n  G90\n  G1 X{x} F6000\n";
    let said = checked(text, "GOES\n");
    assert!(said.starts_with("line 1: stops: GOES line 3"), "{said}");
    let mut bench = with(text).file("a.g", "SET_GCODE_VARIABLE MACRO=GOES VARIABLE=x VALUE=20\nGOES\n").start();
    bench.run(&["G28"]);
    let said = check(&mut bench, "a.g");
    assert!(said.starts_with("line 2: warning: GOES line 3: machine X 999.000"), "{said}");
    assert!(check(&mut bench, "a.g").contains("999.000"), "nothing was set");
}

#[test]
fn codes_that_macros_have_taken_are_looked_into() {
    let text = "[gcode_macro G1]\nrename_existing: G1.1\ngcode:\n  G1.1 {rawparams|replace('X', 'Y')}\n";
    let said = checked(text, "G90\nG1 X300 F6000\nG1 X10\n");
    assert!(said.starts_with("line 2: stops: G1 line 1: machine Y 300.000"), "{said}");
    let text = "[gcode_macro M109]\nrename_existing: M109.1\ngcode: M109.1 S{params.S}\n";
    let said = checked(text, "M109 S60 G1 X999 F6000\n");
    assert!(said.contains("line 1: warning: codes behind a macro's are not looked at"), "{said}");
}

#[test]
fn a_look_gives_way_to_macros_under_way() {
    let text = "[gcode_macro MANY]\ngcode:\n  {% for turn in range(600) %}\n    G4 P0\n  {% endfor %}\n\
                [delayed_gcode more]\ngcode:\n  {% for turn in range(1500) %}\n    G4 P0\n  {% endfor %}\n";
    let job = "MANY\n".repeat(100) + "G1 X999\n";
    let mut bench = with(text).file("a.g", &job).start();
    bench.run(&["G28", "UPDATE_DELAYED_GCODE ID=more DURATION=0.05"]);
    let said = check(&mut bench, "a.g");
    assert!(said.contains("the rest could not be looked into: other macros needed its memory"), "{said}");
    assert!(said.contains("line 101: stops: machine X 999.000"), "{said}");
}
