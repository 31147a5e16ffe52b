//! Klipper's macros on the unmodified image: from the card to steps, in the memory that the board lends.

use sim::trace::StepEdge;
use units::{Actuator, Direction};

use crate::common::velvet::{Plan, SECOND, Velvet};

const CONFIG: &str = "\
[gcode_macro PRINT_START]
description: Begins a print
variable_times: 2
gcode:
    {% set way = params.WAY|default(3)|float %}
    G91
    {% for turn in range(times) %}
        STROKE X={way / 4} Y={turn}
    {% endfor %}
    G90
    SET_GCODE_VARIABLE MACRO=PRINT_START VARIABLE=times VALUE={times + 1}
[gcode_macro STROKE]
gcode:
    G1 X{params.X} Y{params.Y} F3000
[gcode_macro TELL]
gcode:
    RESPOND MSG=\"{printer.toolhead.homed_axes} {printer['gcode_macro PRINT_START'].times} {printer.configfile.settings.stepper_x.position_max}\"
[stepper_x]
position_max: 250
";

fn plan() -> Plan {
    Plan::new().set("[macros] file = printer.cfg").file("printer.cfg", CONFIG)
}

/// Returns motor and direction of each step that these lines make.
fn steps(velvet: &mut Velvet, lines: &[&str]) -> Vec<(Actuator, bool)> {
    velvet.world(|world| world.trace_mut().take());
    for line in lines {
        velvet.ask(line, SECOND);
    }
    velvet.ask("M400", 5 * SECOND);
    let edges = velvet.world(|world| world.trace_mut().take());
    edges
        .iter()
        .map(|StepEdge { actuator, direction, .. }| (*actuator, matches!(direction, Direction::Forward)))
        .collect()
}

/// Each motor's steps are those of the lines typed one by one; how they fall between each other hangs on when
/// a line comes.
#[test]
fn a_macro_makes_the_steps_of_its_lines() {
    let mut velvet = plan().start();
    let by_macro = steps(&mut velvet, &["PRINT_START WAY=8"]);
    let mut typed = plan().start();
    let by_lines = steps(&mut typed, &["G91", "G1 X2 Y0 F3000", "G1 X2 Y1 F3000", "G90"]);
    for motor in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma] {
        let of = |steps: &[(Actuator, bool)]| -> Vec<bool> {
            steps.iter().filter(|(made, _)| *made == motor).map(|(_, forward)| *forward).collect()
        };
        assert_eq!(of(&by_macro), of(&by_lines), "{motor:?}");
    }
    assert!(by_macro.len() > 300, "{} steps", by_macro.len());
    let said = velvet.ask("TELL", SECOND);
    assert!(said.contains("echo:  3 250.0"), "{said}");
    let said = velvet.ask("macros", SECOND);
    assert!(said.contains("PRINT_START - Begins a print"), "{said}");
}
