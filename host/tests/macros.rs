//! Klipper's macros on the command line: files checked, a macro rendered.

mod common;

use std::fs;
use std::path::Path;

use common::{folder, said, text, velvet};

const PRINTER: &str = "\
[include macros/*.cfg]
[printer]
kinematics: corexy # of the machine
[gcode_macro PARK]
variable_height: 10
gcode:
  {% set z = params.Z|default(height)|float %}
  {% if printer.toolhead.position.z < z %}
    G1 Z{z} F{printer['gcode_macro SPEEDS'].fast} ; up
  {% endif %}

  ; left out
  G1 X0
";

fn printer(name: &str, macros: &str) -> std::path::PathBuf {
    let folder = folder(name);
    fs::create_dir(folder.join("macros")).expect("a folder");
    fs::write(folder.join("macros/speeds.cfg"), macros).expect("written");
    let file = folder.join("printer.cfg");
    fs::write(&file, PRINTER).expect("written");
    file
}

fn state(file: &Path, text: &str) -> String {
    let path = file.with_file_name("state.json");
    fs::write(&path, text).expect("written");
    common::text(&path).to_owned()
}

#[test]
fn all_macros_of_all_included_files_are_read() {
    let file = printer("macros-good", "[gcode_macro SPEEDS]\nvariable_fast: 600\ngcode:\n  G28\n");
    let checked = velvet(&["macro", "check", text(&file)]);
    assert_eq!((checked.status.code(), said(&checked).as_str()), (Some(0), "2 macros and templates, all are taken\n"));
}

#[test]
fn what_is_not_taken_is_named_with_its_place_in_the_file() {
    let bad = "[gcode_macro A]\ngcode:\n    G28\n    G1 X{5|nonsense}\n[probe]\nactivate_gcode: {% raw %}\n\
               [gcode_macro B]\nvariable_x: word\ngcode: G28\n";
    let file = printer("macros-bad", bad);
    let checked = velvet(&["macro", "check", text(&file)]);
    let said = said(&checked);
    assert_eq!(checked.status.code(), Some(1), "{said}");
    for finding in [
        "speeds.cfg:4:20: [gcode_macro A] gcode: nonsense: there is no filter of this name",
        "speeds.cfg:6:20: [probe] activate_gcode: raw: this tag",
        "speeds.cfg:8:13: [gcode_macro B] variable_x: word: this is no value",
        "4 macros and templates, 3 values are not taken",
    ] {
        assert!(said.contains(finding), "{finding}\n{said}");
    }
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let file = folder("macros-unreadable").join("printer.cfg");
    for (content, finding) in [
        ("[include none.cfg]\n", "none.cfg"),
        ("[include printer.cfg]\n", "files include each other"),
        ("[printer]\nsome words\n", "printer.cfg:2: this is no section and no option"),
    ] {
        fs::write(&file, content).expect("written");
        let checked = velvet(&["macro", "check", text(&file)]);
        assert_eq!(checked.status.code(), Some(2), "{content}");
        assert!(said(&checked).contains(finding), "{}", said(&checked));
    }
}

#[test]
fn a_macro_is_rendered_with_parameters_variables_and_state() {
    let file = printer("macros-render", "[gcode_macro SPEEDS]\nvariable_fast: 600\ngcode:\n  G28\n");
    let state = state(&file, r#"{"toolhead": {"position": [0, 0, 5.5, 0]}}"#);
    let lines = |arguments: &[&str]| {
        let all: Vec<&str> = ["macro", "render", text(&file)].iter().chain(arguments).copied().collect();
        let output = velvet(&all);
        assert!(output.status.success(), "{}", said(&output));
        let output = String::from_utf8(output.stdout).expect("text");
        output.lines().map(str::trim).filter(|line| !line.is_empty()).collect::<Vec<_>>().join("|")
    };
    assert_eq!(lines(&["park", "--state", &state]), "G1 Z10.0 F600|G1 X0");
    assert_eq!(lines(&["PARK", "z=7", "--state", &state]), "G1 Z7.0 F600|G1 X0");
    assert_eq!(lines(&["PARK", "Z=5", "--state", &state]), "G1 X0");
}

#[test]
fn an_error_of_a_macro_names_its_line() {
    let file = printer("macros-error", "");
    let output = velvet(&["macro", "render", text(&file), "PARK"]);
    assert_eq!(output.status.code(), Some(1));
    assert!(said(&output).contains("printer.cfg:8:3: [gcode_macro PARK] gcode: toolhead: this is not there"));
    let unknown = velvet(&["macro", "render", text(&file), "NONE"]);
    assert_eq!(unknown.status.code(), Some(2));
    assert!(said(&unknown).contains("there are: PARK"), "{}", said(&unknown));
}

/// Returns the configuration of the sample printer with these macros, and a job, in a folder.
fn machine(name: &str, macros: &str, job: &str) -> [std::path::PathBuf; 2] {
    let folder = folder(name);
    let config = fs::read_to_string("../config/samples/cartesian.ini").expect("the sample");
    let files = [("config.ini", config + "\n[macros]\nfile = printer.cfg\n"), ("printer.cfg", macros.to_owned())];
    files.into_iter().for_each(|(name, text)| fs::write(folder.join(name), text).expect("written"));
    fs::write(folder.join("job.g"), job).expect("written");
    [folder.join("config.ini"), folder.join("job.g")]
}

#[test]
fn a_job_is_looked_through_with_its_macros() {
    let macros = "[stepper_x]\nposition_max: 300\n[gcode_macro PRINT_START]\nvariable_z: 5\ngcode:\n  \
                  {% if printer.toolhead.homed_axes == '' %}\n    G28\n  {% endif %}\n  M104 S{params.T}\n  G90\n  \
                  G1 Z{z} F600\n  ASIDE BY=10\n[gcode_macro ASIDE]\ngcode:\n  SAVE_GCODE_STATE NAME=a\n  G91\n  \
                  G1 X{params.BY} F6000\n  RESTORE_GCODE_STATE NAME=a\n[gcode_macro FAR]\ngcode: G1 \
                  X{printer.configfile.settings.stepper_x.position_max}\n[gcode_macro M109]\nrename_existing: M109.1\n\
                  gcode: M109.1 S{params.S}\n[gcode_macro LATER]\ngcode: {action_raise_error('not now')}\n\
                  [gcode_macro LOOPS]\ngcode: LOOPS\n[gcode_macro WRONG]\ngcode: {% if %}\n";
    let good = "PRINT_START T=200\nM109 S200\nM109.1 S200\nG1 X20 E1\nLATER\n";
    let [config, job] = machine("looked_through", macros, good);
    let out = velvet(&["preflight", text(&config), text(&job)]);
    assert!(out.status.success(), "{}", said(&out));
    assert!(said(&out).contains("line 5: warning: LATER could not be looked into: not now"), "{}", said(&out));
    assert!(said(&out).contains("2 waits: hotend 2x, up to 200 C"), "{}", said(&out));
    let [config, job] = machine("looked_through", macros, "G28\nASIDE BY=999\nFAR\nLOOPS\nWRONG\nPARK\n");
    let out = velvet(&["preflight", text(&config), text(&job)]);
    assert_eq!(out.status.code(), Some(1), "{}", said(&out));
    let begins = [
        "line 2: stops: ASIDE line 4: machine X 999.000 is out of travel",
        "line 3: stops: FAR line 1: machine X 300.000 is out of travel",
        "line 4: stops: LOOPS line 1: LOOPS: a macro that is under way is called recursively",
        "line 5: stops: printer.cfg:",
        "line 6: stops: PARK is not known here",
    ];
    let told = said(&out);
    told.lines().zip(begins).for_each(|(line, begin)| assert!(line.starts_with(begin), "{line}: {told}"));
    assert!(told.contains(" [gcode_macro WRONG] gcode: "), "{told}");
    fs::remove_file(config.with_file_name("printer.cfg")).expect("removed");
    let out = velvet(&["preflight", text(&config), text(&job)]);
    assert!(out.status.code() == Some(2) && said(&out).contains("cannot read"), "{}", said(&out));
}
