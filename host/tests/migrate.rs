//! `velvet migrate` of a printer.cfg as a person uses it.

mod common;

use common::{folder, said, text, velvet};
use serde_json::Value;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const PRINTER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/klipper/printer.cfg");

/// Migrates a file into a folder of this name; returns the exit code, what was said, the folder.
fn migrate(file: &str, name: &str) -> (Option<i32>, String, PathBuf) {
    let out = folder(name);
    let run = velvet(&["migrate", file, "--out", text(&out)]);
    (run.status.code(), said(&run), out)
}

fn report(out: &Path) -> Value {
    serde_json::from_slice(&std::fs::read(out.join("report.json")).expect("a report")).expect("JSON")
}

/// Settings of the new file, by `[section] key`.
fn settings(out: &Path) -> BTreeMap<String, String> {
    let mut section = String::new();
    let mut all = BTreeMap::new();
    for line in std::fs::read_to_string(out.join("config.ini")).expect("a new file").lines() {
        let line = line.split('#').next().unwrap_or("").trim();
        if line.starts_with('[') {
            line.clone_into(&mut section);
        } else if let Some((key, value)) = line.split_once(" = ") {
            all.insert(format!("{section} {key}"), value.trim().to_owned());
        }
    }
    all
}

/// Verdicts by section and option: class, reason.
fn verdicts(report: &Value) -> BTreeMap<(String, String), (String, String)> {
    let words = |value: &Value| value.as_str().unwrap_or("").to_owned();
    let mut all = BTreeMap::new();
    for section in report["account"].as_array().expect("sections") {
        for option in section["options"].as_array().expect("options") {
            let kind = if option["kept"] == true { "kept".to_owned() } else { words(&option["class"]) };
            let place = (words(&section["section"]), words(&option["option"]));
            assert!(all.insert(place, (kind, words(&option["reason"]))).is_none(), "each option once");
        }
    }
    all
}

#[test]
fn a_printer_starts_with_what_comes_out() {
    let (code, said, out) = migrate(PRINTER, "printer");
    assert_eq!(code, Some(0), "{said}");
    let checked = velvet(&["check", text(&out.join("config.ini"))]);
    assert!(checked.status.success(), "{}", common::said(&checked));
    let new = settings(&out);
    for (setting, value) in [
        ("[motion control] arm_solution", "corexy"),
        ("[motion control] max_speed", "18000"),
        ("[motion control] z_axis_max_speed", "900"),
        ("[motion control] default_acceleration", "5000"),
        ("[planner] minimum_cruise_ratio", "0.5"),
        ("[planner] square_corner_velocity", "5"),
        ("[actuator] alpha.steps_per_mm", "160"),
        ("[actuator] alpha.dir_pin", "PD4"),
        ("[actuator] beta.dir_pin", "PG2!"),
        ("[actuator] gamma.steps_per_mm", "2400"),
        ("[actuator] gamma.acceleration", "350"),
        ("[actuator] epsilon.slaved_to", "gamma"),
        ("[actuator] epsilon.en_pin", "PJ2!"),
        ("[current control] alpha.current", "1.131"),
        ("[tmc2590] alpha.standstill_current", "566"),
        ("[endstops] maxx.pin", "PI3^!"),
        ("[endstops] maxx.homing_direction", "home_to_max"),
        ("[endstops] miny.pin", "PI1^"),
        ("[endstops] miny.slow_rate", "2.5"),
        ("[endstops] minz.homing_position", "0.3"),
        ("[soft endstop] z_min", "-2"),
        ("[soft endstop] x_min", "0"),
        ("[temperature control] hotend.beta", "4267"),
        ("[temperature control] hotend.p_factor", "21.5"),
        ("[temperature control] bed.rt_curve", "25,100000,150,1770,250,230"),
        ("[temperature control] bed.thermistor_pin", "ADC1_3"),
        ("[temperature control] bed.bang_bang", "true"),
        ("[temperature control] bed.max_pwm", "153"),
        ("[extruder] hotend.pressure_advance", "0.045"),
        ("[extruder] hotend.min_extrude_temp", "170"),
        ("[switch] fan.output_pin", "PE1"),
        ("[fan] fan.off_below", "20"),
        ("[fan] hotend.sensors", "hotend"),
        ("[switch] lamp.startup_value", "128"),
        ("[zprobe] probe_offsets", "0,25,1.5"),
        ("[cartesian grid leveling strategy] grid_y_size", "4"),
        ("[input shaper] shaper_freq_x", "58.2"),
        ("[input shaper] shaper_freq_y", "41.5"),
    ] {
        assert_eq!(new.get(setting).map(String::as_str), Some(value), "{setting}");
    }
    let steps: f64 = new["[actuator] delta.steps_per_mm"].parse().expect("a number");
    assert!((steps / (400.0 * 16.0 * 50.0 / 17.0 / 22.6789511) - 1.0).abs() < 1e-12, "{steps}");
    assert!(said.contains("delta.current"), "a current that nobody knows is asked for: {said}");
}

#[test]
fn each_option_has_one_verdict_with_a_reason() {
    let (_, _, out) = migrate(PRINTER, "account");
    let report = report(&out);
    let all = verdicts(&report);
    for (section, option, kind, says) in [
        ("mcu", "serial", "needless", "no line between"),
        ("mcu second", "serial", "needless", "hangs on the Prime"),
        ("board_pins", "aliases", "needless", "by their role"),
        ("stepper_x", "enable_pin", "needless", "over SPI"),
        ("stepper_z1", "enable_pin", "converted", ""),
        ("tmc2209 stepper_x", "uart_pin", "needless", "wired"),
        ("tmc2209 stepper_x", "stealthchop_threshold", "converted", "anyway"),
        ("extruder", "gear_ratio", "converted", "full steps"),
        ("thermistor my thermistor", "beta", "converted", "name it"),
        ("gcode_macro PRINT_START", "gcode", "kept", "printer.cfg"),
        ("gcode_macro PAUSE_HERE", "gcode", "kept", "printer.cfg"),
        ("force_move", "enable_force_move", "kept", "printer.cfg"),
        ("gcode_shell_command backup", "command", "refused", "third-party"),
        ("heater_bed", "smooth_time", "refused", "smoothed"),
        ("fan", "off_below", "converted", ""),
    ] {
        let (class, reason) = &all[&(section.to_owned(), option.to_owned())];
        assert!(class == kind && reason.contains(says), "[{section}] {option}: {class}: {reason}");
    }
    let counted = ["converted", "needless", "refused"].map(|name| report["options"][name].as_u64().unwrap_or(0));
    assert_eq!(counted.iter().sum::<u64>(), all.len() as u64);
    let kept = all.values().filter(|(class, _)| class == "kept").count();
    assert_eq!(report["options"]["kept"].as_u64(), Some(kept as u64));
    let empty = report["account"].as_array().expect("sections").iter().find(|row| row["section"] == "exclude_object");
    assert_eq!(empty.expect("sections without options count too")["class"], "needless");
}

#[test]
fn what_was_overruled_is_told() {
    let (_, said, out) = migrate(PRINTER, "overruled");
    assert!(said.contains("[extruder] pressure_advance = 0.06 of SAVE_CONFIG is not used"), "{said}");
    let report = report(&out);
    let fan = report["account"].as_array().expect("sections").iter().find(|row| row["section"] == "fan");
    let off = fan.and_then(|fan| fan["options"].as_array()?.iter().find(|row| row["option"] == "off_below"));
    let printer = std::fs::read_to_string(PRINTER).expect("ours");
    let line = 1 + printer.lines().position(|line| line == "off_below: 0.1").expect("the first of two");
    assert_eq!(off.expect("the option")["earlier"][0], format!("printer.cfg:{line}: 0.1"));
}

#[test]
fn the_owners_comments_and_the_file_itself_stay() {
    let (_, _, out) = migrate(PRINTER, "comments");
    let new = std::fs::read_to_string(out.join("config.ini")).expect("a new file");
    assert!(new.contains("# as fast as the belts like"), "{new}");
    assert!(new.contains("# measured with 100 mm of filament\ndelta.steps_per_mm"), "{new}");
    assert!(new.contains("# measured in March"), "{new}");
    assert!(new.contains("# the belt is new\nalpha."), "{new}");
    assert!(!new.contains("position_min: -5"), "a setting that is switched off is no comment: {new}");
    for part in ["printer.cfg", "parts/a.cfg", "parts/b.cfg"] {
        let original = Path::new(PRINTER).parent().expect("a folder").join(part);
        assert_eq!(std::fs::read(out.join(part)).expect("a copy"), std::fs::read(original).expect("ours"), "{part}");
    }
    let page = std::fs::read_to_string(out.join("report.html")).expect("a page");
    assert!(page.contains("PRINT_START") && !page.contains("{{"), "the page has its data");
}

#[test]
fn a_file_that_includes_others_beside_its_folder_is_copied_with_them() {
    let base = folder("beside");
    std::fs::create_dir_all(base.join("in/config")).expect("a folder");
    std::fs::write(base.join("in/config/printer.cfg"), "[include ../shared.cfg]\n[mcu]\nserial: x\n").expect("written");
    std::fs::write(base.join("in/shared.cfg"), "[respond]\n").expect("written");
    let out = base.join("out");
    velvet(&["migrate", text(&base.join("in/config/printer.cfg")), "--out", text(&out)]);
    assert!(out.join("config/printer.cfg").exists() && out.join("shared.cfg").exists());
}

#[test]
fn what_cannot_be_read_is_an_error_with_its_place() {
    let base = folder("unreadable");
    let write = |name: &str, content: &[u8]| {
        let path = base.join(name);
        std::fs::write(&path, content).expect("written");
        path
    };
    write("loop.cfg", b"[include round.cfg]\n[mcu]\nserial: x\n");
    write("round.cfg", b"[include loop.cfg]\n");
    let long = format!("[mcu]\nserial: {}\n{}\n", "x".repeat(10_000_000), "y".repeat(10_000_000));
    for (path, says) in [
        (base.join("none.cfg"), "cannot read"),
        (write("empty.cfg", b""), "no [section]"),
        (write("binary.cfg", b"[mcu]\n\0\x01"), "no text"),
        (write("bare.cfg", b"serial: x\n"), "bare.cfg:1: 'serial: x' stands in no [section]"),
        (write("word.cfg", b"[mcu]\nserial\n"), "word.cfg:2: 'serial' is no setting"),
        (write("missing.cfg", b"[mcu]\nserial: x\n[include gone.cfg]\n"), "missing.cfg:3: [include gone.cfg]"),
        (base.join("loop.cfg"), "includes itself, over loop.cfg, round.cfg"),
        (write("default.cfg", b"[DEFAULT]\na: 1\n"), "[DEFAULT]"),
        (write("long.cfg", long.as_bytes()), "long.cfg:3: 'yyyy"),
    ] {
        let run = velvet(&["migrate", text(&path), "--out", text(&base.join("out"))]);
        let told = said(&run);
        assert!(run.status.code() == Some(2) && told.contains(says), "{}: {:.500}", path.display(), told);
        assert!(told.len() < 1000, "short enough to read");
    }
    let file = write("file", b"");
    let run = velvet(&["migrate", PRINTER, "--out", text(&file)]);
    assert!(run.status.code() == Some(2) && said(&run).contains("names a folder"), "{}", said(&run));
}

/// An option of any value, number or nonsense, has its verdict, and nothing panics.
#[test]
fn nonsense_in_any_option_is_accounted_for() {
    let printer = std::fs::read_to_string(PRINTER).expect("ours");
    let lines: Vec<&str> = printer.lines().collect();
    let base = folder("nonsense");
    for nonsense in ["", "nan", "-1", "0", "1e300", "yes", "!", "a, b, c", "{params.X}", "1:0"] {
        let bent: Vec<String> = (lines.iter())
            .map(|line| match line.split_once(": ").filter(|_| !line.starts_with(['#', ' ', '['])) {
                Some((name, _)) if name != "kinematics" => format!("{name}: {nonsense}"),
                _ => (*line).to_owned(),
            })
            .collect();
        let file = base.join("printer.cfg");
        std::fs::write(&file, bent.join("\n").replace("[include parts/*.cfg]", "")).expect("written");
        let out = base.join("out");
        let run = velvet(&["migrate", text(&file), "--out", text(&out)]);
        assert!(matches!(run.status.code(), Some(0 | 1)), "{nonsense}: {}", said(&run));
        let report = report(&out);
        assert_eq!(report["options"]["all"].as_u64(), Some(verdicts(&report).len() as u64), "{nonsense}");
    }
}

#[test]
fn currents_keep_within_the_drivers_that_the_board_has() {
    let base = folder("drivers");
    let printer = std::fs::read_to_string(PRINTER).expect("ours").replace("[include parts/*.cfg]", "");
    let own = "\n[tmc2660 stepper_y]\ncs_pin: PB0\nrun_current: 2.4\nsense_resistor: 0.051\nidle_current_percent: 50\n\
               driver_SEMIN: 2\ndriver_SEMAX: 4\ndriver_SEUP: 1\ndriver_SEIMIN: 1\ndriver_SGT: 5\ndriver_TOFF: 4\n";
    let (head, saved) = printer.split_once("#*# <---").expect("the block");
    let file = base.join("printer.cfg");
    std::fs::write(&file, format!("{head}{own}#*# <---{saved}")).expect("written");
    for (drivers, amps, idle) in [("tmc2590", "3.394", "1697"), ("tmc2660", "2.8", "1400")] {
        let out = base.join(drivers);
        let run = velvet(&["migrate", text(&file), "--drivers", drivers, "--out", text(&out)]);
        assert_eq!(run.status.code(), Some(0), "{}", said(&run));
        let new = settings(&out);
        let setting = |name: &str| new.get(name).map(String::as_str);
        assert_eq!(setting("[current control] beta.current"), Some(amps), "{drivers}");
        assert_eq!(setting(&format!("[{drivers}] beta.standstill_current")), Some(idle), "{drivers}");
        assert_eq!(setting(&format!("[{drivers}] beta.coolstep_lower")), Some("64"));
        assert_eq!(setting(&format!("[{drivers}] beta.coolstep_upper")), Some("224"));
        assert_eq!(setting(&format!("[{drivers}] beta.coolstep_up")), Some("2"));
        assert_eq!(setting(&format!("[{drivers}] beta.coolstep_least")), Some("quarter"));
        assert_eq!(setting(&format!("[{drivers}] beta.stall_threshold")), Some("5"));
        assert_eq!(setting("[actuator] beta.driver"), Some(drivers));
        assert_eq!(said(&run).contains("2.4 A rms are 3.394 A at the peak"), drivers == "tmc2660", "{}", said(&run));
    }
}

#[test]
fn an_edited_file_is_not_lost_when_the_printer_is_migrated_again() {
    let (_, _, out) = migrate(PRINTER, "again");
    std::fs::write(out.join("config.ini"), "# mine\n").expect("edited");
    velvet(&["migrate", PRINTER, "--out", text(&out)]);
    assert_eq!(std::fs::read_to_string(out.join("previous-config.ini")).expect("kept"), "# mine\n");
}

#[test]
fn z_that_homes_by_the_probe_homes_by_a_line() {
    let base = folder("by_probe");
    let printer = std::fs::read_to_string(PRINTER).expect("ours").replace("[include parts/*.cfg]", "");
    let printer = printer.replace("endstop_pin: PG10\nposition_endstop: 0.3", "endstop_pin: probe:z_virtual_endstop");
    let bltouch = "[safe_z_home]\nhome_xy_position: 150, 140\nspeed: 80\nz_hop: 10\n\n[bltouch]\ncontrol_pin: PB6\nsensor_pin: ^PB7\n";
    let printer = printer.replace("[probe]\npin: PB7\n", bltouch);
    let file = base.join("printer.cfg");
    std::fs::write(&file, printer).expect("written");
    let run = velvet(&["migrate", text(&file), "--out", text(&base.join("out"))]);
    assert_eq!(run.status.code(), Some(0), "{}", said(&run));
    let new = settings(&base.join("out"));
    let line = "G91_G0_Z10_F900_G90_G28_X_Y_G53_G0_X150_Y140_F4800_G30_L_G28.3_P1_G0_Z10_M402";
    assert_eq!(new["[endstops] common.home_gcode"], line);
    assert_eq!(new["[zprobe] deploy_gcode"], "M280 S650 G4 P680");
    let job = base.join("job.gcode");
    std::fs::write(&job, "G28\nG28.6\nG1 Z5 F600\nM400\n").expect("written");
    let config = base.join("out/config.ini");
    let ran = velvet(&["run", "--config", text(&config), "--gcode", text(&job), "--out", text(&base.join("run"))]);
    assert!(ran.status.success(), "{}", said(&ran));
}

#[test]
fn a_template_stands_for_g28_and_z_homes_by_the_probe_within_it() {
    let base = folder("override");
    let printer = std::fs::read_to_string(PRINTER).expect("ours").replace("[include parts/*.cfg]", "");
    let printer = printer.replace("endstop_pin: PG10\nposition_endstop: 0.3", "endstop_pin: probe:z_virtual_endstop");
    let homing = "[homing_override]\naxes: xyz\nset_position_z: 0\ngcode:\n  G90\n  G0 Z10 F600\n  G28 X Y\n  G0 X150 Y140 F3000\n  G28 Z\n\n";
    let file = base.join("printer.cfg");
    std::fs::write(&file, printer.replace("[probe]\npin: PB7\n", &format!("{homing}[probe]\npin: PB7\n")))
        .expect("written");
    let run = velvet(&["migrate", text(&file), "--out", text(&base.join("out"))]);
    assert_eq!(run.status.code(), Some(0), "{}", said(&run));
    let new = settings(&base.join("out"));
    assert_eq!(new["[endstops] common.home_z_gcode"], "G30_L_G28.3_P1_G0_Z5");
    assert!(!new.contains_key("[endstops] common.home_gcode"));
    let verdicts = verdicts(&report(&base.join("out")));
    for option in ["axes", "set_position_z", "gcode"] {
        assert_eq!(verdicts[&("homing_override".to_owned(), option.to_owned())].0, "kept");
    }
}

#[test]
fn templates_that_klipper_carries_out_by_itself_are_named_in_the_new_file() {
    let base = folder("templates");
    let printer = std::fs::read_to_string(PRINTER).expect("ours").replace("[include parts/*.cfg]", "");
    let own = "[gcode_button stop]\npin: PB1\npress_gcode:\n  M117 a\n  M118 b\nrelease_gcode: M118 c\n\n\
               [filament_switch_sensor eye]\nswitch_pin: PB2\npause_on_runout: False\nrunout_gcode: M118 {1 + 1}\n\
               insert_gcode:\n\n[probe]\npin: PB7\nactivate_gcode:\n  SET_PIN PIN=a VALUE=1\n  G4 P1\n";
    let file = base.join("printer.cfg");
    std::fs::write(&file, printer.replace("[probe]\npin: PB7\n", own)).expect("written");
    let run = velvet(&["migrate", text(&file), "--out", text(&base.join("out"))]);
    assert_eq!(run.status.code(), Some(0), "{}", said(&run));
    let new = settings(&base.join("out"));
    for (key, value) in [
        ("[button box] stop.press", "RUN_TEMPLATE SECTION=\"gcode_button stop\" OPTION=press_gcode"),
        ("[button box] stop.release", "M118 c"),
        ("[filament detector] suspends", "false"),
        ("[filament detector] runout_gcode", "RUN_TEMPLATE SECTION=\"filament_switch_sensor eye\" OPTION=runout_gcode"),
        ("[zprobe] deploy_gcode", "RUN_TEMPLATE SECTION=\"probe\" OPTION=activate_gcode"),
        ("[zprobe] stow_gcode", "G4 P0"),
    ] {
        assert_eq!(new.get(key).map(String::as_str), Some(value), "{key}");
    }
    assert!(!new.contains_key("[filament detector] insert_gcode"));
}

#[test]
fn carriages_and_what_motors_move_become_axes_and_factors() {
    let base = folder("generic");
    let carriage = |axis: &str, pin: &str| {
        format!("[carriage c{axis}]\naxis: {axis}\nendstop_pin: ^{pin}\nposition_endstop: 0\nposition_max: 200\n")
    };
    let motor = |name: &str, sum: &str| {
        format!("[stepper {name}]\ncarriages: {sum}\nstep_pin: A\ndir_pin: B\nmicrosteps: 16\nrotation_distance: 40\n")
    };
    let printer = "[printer]\nkinematics: generic_cartesian\nmax_velocity: 200\nmax_accel: 2000\n".to_owned()
        + &carriage("x", "PA1")
        + &carriage("y", "PA2")
        + &carriage("z", "PA3")
        + &motor("one", "cx + cy")
        + &motor("two", "cx - 0.5*cy")
        + &motor("three", "cz")
        + &motor("four", "cz")
        + &motor("five", "nothing");
    let file = base.join("printer.cfg");
    std::fs::write(&file, printer).expect("written");
    let run = velvet(&["migrate", text(&file), "--out", text(&base.join("out"))]);
    assert_eq!(run.status.code(), Some(0), "{}", said(&run));
    let new = settings(&base.join("out"));
    for (setting, value) in [
        ("[motion control] arm_solution", "generic_cartesian"),
        ("[generic cartesian] alpha", "1,1,0"),
        ("[generic cartesian] beta", "1,-0.5,0"),
        ("[generic cartesian] gamma", "0,0,1"),
        ("[actuator] delta.slaved_to", "gamma"),
        ("[endstops] miny.pin", "PI1^"),
        ("[soft endstop] z_max", "200"),
    ] {
        assert_eq!(new.get(setting).map(String::as_str), Some(value), "{setting}");
    }
    let all = verdicts(&report(&base.join("out")));
    assert_eq!(all[&("stepper five".to_owned(), "carriages".to_owned())].0, "refused");
}
