//! Files as slicers write them, printed end to end: nothing pauses, and what was not carried out is said
//! once.
//!
//! The files are written in each slicer's style for the sample printer; the part is a square of two layers.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Beta, Delta, Gamma};

/// The sample printer, with a bed that heats at once: what is looked at is the language.
fn printer(text: &str) -> Bench {
    let plan = Plan::new(CARTESIAN).set("[extruder] hotend.pressure_advance = 0.02");
    plan.file("part.gcode", text).start()
}

/// Types a line, and listens until these words are said.
fn hears(bench: &mut Bench, line: &str, words: &str) -> String {
    let mut heard = bench.say(line);
    if !heard.contains(words) {
        heard.push_str(&bench.hear_until(words, 1_200.0));
    }
    heard
}

/// Prints a file to its end; returns everything that was said.
fn printed(text: &str) -> (Bench, String) {
    let mut bench = printer(text);
    bench.say("M23 part.gcode");
    let heard = hears(&mut bench, "M24", "Done printing file");
    assert!(!heard.contains("error") && !heard.contains("WARNING"), "{heard}");
    (bench, heard)
}

fn assert_said(heard: &str, line: &str) {
    assert!(heard.lines().any(|said| said == line), "`{line}` was not said, but: {heard}");
}

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < 0.0126, "{what}: {actual}, not {expected}");
}

/// Plays a file that stops; returns everything that was said.
fn stopped(text: &str) -> (Bench, String) {
    let mut bench = printer(text);
    bench.say("M23 part.gcode");
    let heard = hears(&mut bench, "M24", "error:paused");
    (bench, heard)
}

const PRUSA: &str = include_str!("data/slicers/prusaslicer.gcode");

#[test]
fn prusaslicer_for_marlin() {
    // Slicers write their own start code into one comment.
    let (bench, heard) = printed(&PRUSA.replace("LONG", &"M862.3 P\\n".repeat(200)));
    assert_said(&heard, "// NOTE the file is read as Marlin's, as it says");
    assert_said(&heard, "// NOTE not carried out: M73 4x, M862.3 1x, M862.1 1x");
    assert_near(bench.carriage(Delta), 1.6 * 0.95, "filament");
    assert_near(bench.carriage(Beta), 40.0, "y");
}

const ORCA: &str = include_str!("data/slicers/orcaslicer.gcode");

#[test]
fn orcaslicer_for_klipper() {
    let outline = "[50.5,50.5],".repeat(60);
    let (bench, heard) = printed(&ORCA.replace("POLYGON=[", &format!("POLYGON=[{outline}")));
    assert_said(&heard, "// NOTE the file is read as Klipper's, as it says");
    assert_said(&heard, "echo: all done, really");
    assert_said(&heard, "// NOTE not carried out: M73 2x, SET_PRINT_STATS_INFO 3x, TIMELAPSE_* 2x, M106 1x");
    assert_near(bench.carriage(Gamma), 0.2 + 0.05 + 1.0, "z, shifted and lifted");
    assert_near(bench.carriage(Delta), 1.4 - 0.5, "filament: E is a distance while G91 holds");
    assert!(!bench.heats());
}

const CURA: &str = include_str!("data/slicers/cura.gcode");

#[test]
fn cura_for_marlin() {
    let (bench, heard) = printed(CURA);
    assert_said(&heard, "// NOTE the file is read as Marlin's, as it says");
    assert_said(&heard, "// NOTE not carried out: M300 1x");
    // G91 is Marlin's for the extruder too: it pulls back 4 mm, not to -2.
    assert_near(bench.carriage(Delta), 1.6 - 4.0, "filament");
    assert_near(bench.carriage(Gamma), 10.4, "z");
    assert_near(bench.carriage(Beta), 100.0, "y");
}

const SIMPLIFY3D: &str = include_str!("data/slicers/simplify3d.gcode");

#[test]
fn simplify3d() {
    let (bench, heard) = printed(SIMPLIFY3D);
    assert!(!heard.contains("is read as"), "it does not say for whom it is: {heard}");
    assert_said(&heard, "// NOTE not carried out: M73 1x");
    assert_near(bench.carriage(Delta), 0.6, "filament");
    assert_near(bench.carriage(Alpha), 0.0, "x");
}

const IDEAMAKER: &str = include_str!("data/slicers/ideamaker.gcode");

#[test]
fn ideamaker() {
    let (bench, heard) = printed(IDEAMAKER);
    assert_said(&heard, "// NOTE not carried out: M1001 1x");
    assert_near(bench.carriage(Delta), 4.6, "filament");
}

const SLIC3R: &str = include_str!("data/slicers/slic3r.gcode");

#[test]
fn slic3r_for_reprapfirmware() {
    let (mut bench, heard) = printed(SLIC3R);
    assert_said(&heard, "// NOTE the file is read as RepRapFirmware's, as it says");
    assert!(!heard.contains("not carried out"), "{heard}");
    let speeds = bench.say("M203");
    assert!(speeds.contains("X:200.000000") && speeds.contains("Z:10.000000"), "mm a minute: {speeds}");
    assert_near(bench.carriage(Delta), 3.2 - 2.0, "filament");
    assert_near(bench.carriage(Gamma), 1.35, "z");
}

#[test]
fn a_macro_that_nobody_knows_pauses_by_name() {
    for (line, name) in [("PRINT_START BED=60 EXTRUDER=210", "PRINT_START"), ("start_print", "start_print")] {
        let (mut bench, heard) = stopped(&format!("G28\n{line}\nG1 X10 F600\n"));
        assert!(heard.contains(name), "{heard}");
        assert!(heard.contains("line 2 of /sd/part.gcode was not carried out: M24 goes on"), "{heard}");
        bench.hear(1.0);
        assert_near(bench.carriage(Alpha), 0.0, "x");
        hears(&mut bench, "M24", "Done printing file");
        assert_near(bench.carriage(Alpha), 10.0, "x");
    }
}

#[test]
fn what_would_change_the_part_pauses_and_says_why() {
    for (line, why) in [
        ("G12 P1 S2", "G12 is not known here, and what follows counts on it"),
        ("M4 S100", "M4 is for a part that this machine has not"),
        ("EXCLUDE_OBJECT NAME=a", "there is no object of this name: see EXCLUDE_OBJECT_DEFINE"),
        ("M486 P1", "there is no object of this number: see M486"),
        ("SET_VELOCITY_LIMIT ACCEL=quick", "SET_VELOCITY_LIMIT needs a number for ACCEL="),
        ("X1 Y1 M9999 G12", "G12 is not known here"),
    ] {
        let (_, heard) = stopped(&format!("G28\n{line}\n"));
        assert!(heard.contains(why), "{line}: {heard}");
    }
}

/// A mill has no hot end: a printer's file would rub cold filament on the bed.
#[test]
fn a_temperature_that_nothing_can_have_pauses() {
    let plan = Plan::new(include_str!("../../config/samples/minimal.ini"));
    let mut bench = plan.file("part.gcode", "M104 S0\nM140 S60\nM106 S9\nM104 S200\n").start();
    let heard = hears(&mut bench, "M32 part.gcode", "error:paused");
    assert!(heard.contains("M104 is for a part that this machine has not") && heard.contains("line 4"), "{heard}");
    assert!(bench.say("abort").contains("// NOTE not carried out: M104 1x, M140 1x, M106 1x"));
}

#[test]
fn a_console_is_answered_as_before() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("M9999"), "ok - M9999 ignored\n");
    assert_eq!(bench.say("G12"), "ok - G12 ignored\n");
    assert_eq!(bench.say("M73 P1"), "ok\n");
    assert_eq!(bench.say("SET_VELOCITY_LIMIT ACCEL=1000"), "ok\n");
    assert_eq!(bench.say("set_velocity_limit ACCEL=1000"), "ok\n");
    assert_eq!(bench.say("TIMELAPSE_TAKE_FRAME"), "ok\n");
    assert!(bench.say("NO_SUCH_MACRO").starts_with("error:NO_SUCH_MACRO is not known here"));
    assert!(bench.say("help SET_PRESSURE_ADVANCE").starts_with("SET_PRESSURE_ADVANCE ADVANCE"));
}

#[test]
fn a_dialect_can_be_forced() {
    let text = ";FLAVOR:RepRap\nM203 X600\n";
    for (command, config, speed) in [
        ("play part.gcode", "auto", "X:10.000000"),
        ("play part.gcode -f marlin", "auto", "X:600.000000"),
        ("play part.gcode", "klipper", "X:600.000000"),
        ("play part.gcode -f rrf -v", "klipper", "X:10.000000"),
    ] {
        let plan = Plan::new(CARTESIAN).set(&format!("[player] dialect = {config}"));
        let mut bench = plan.file("part.gcode", text).start();
        bench.say(command);
        bench.hear(0.5);
        let speeds = bench.say("M203");
        assert!(speeds.contains(speed), "{command}, {config}: {speeds}");
    }
    let mut bench = Plan::new(CARTESIAN).file("part.gcode", text).start();
    assert_eq!(
        bench.say("play part.gcode -f polish"),
        "error:-f takes smoothie, marlin, reprapfirmware, klipper or grbl\n"
    );
}

#[test]
fn input_shaping_and_jerk_can_be_set_by_code() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("M593"), "M593 X F0.0\nM593 Y F0.0\nM593 Z F0.0\nok\n");
    bench.run(&["M593 X F40 D0.1", "SET_INPUT_SHAPER SHAPER_FREQ_Y=50 SHAPER_TYPE=mzv", "M566 X600 Y480", "M205 V5"]);
    assert_eq!(bench.say("M593"), "M593 X F40.0\nM593 Y F50.0\nM593 Z F0.0\nok\n");
    assert!(bench.say("M593 P\"round\" F5").starts_with("error:M593: the kinds"));
    bench.run(&["M593 F0"]);
    assert_eq!(bench.say("M593"), "M593 X F0.0\nM593 Y F0.0\nM593 Z F0.0\nok\n");
}

#[test]
fn a_wait_for_a_temperature_has_bounds() {
    let mut bench = Plan::new(CARTESIAN).start();
    bench.say("M104 S120");
    assert!(bench.say("TEMPERATURE_WAIT SENSOR=extruder MINIMUM=60 MAXIMUM=200").ends_with("ok\n"));
    assert!((60.0..90.0).contains(&bench.celsius("hotend")), "{}", bench.celsius("hotend"));
    assert!(bench.say("M116").ends_with("ok\n"));
    assert!(bench.celsius("hotend") > 117.0, "{}", bench.celsius("hotend"));
    bench.say("TURN_OFF_HEATERS");
    assert!(bench.say("TEMPERATURE_WAIT SENSOR=hotend MAXIMUM=80").ends_with("ok\n"));
    assert!(bench.celsius("hotend") < 83.0, "{}", bench.celsius("hotend"));
    let refused = "error:M116: that heater is not set to become so warm\n";
    assert_eq!(bench.say("TEMPERATURE_WAIT SENSOR=heater_bed MINIMUM=60"), refused);
    assert_eq!(bench.say("M116 P9"), "error:M116: no heater has that id\n");
}

/// M118 reaches whoever listens, on whichever console.
#[test]
fn a_text_is_said_on_every_console() {
    let mut bench = Plan::new(CARTESIAN).start();
    assert_eq!(bench.say("M118 E1 layer 2"), "echo:layer 2\nok\n");
    assert_eq!(bench.say("M118 layer 2"), "layer 2\nok\n");
}
