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
