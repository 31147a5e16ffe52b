use gcode::Code;

use super::*;
use std::string::{String as Text, ToString};

struct Machine;

impl Names for Machine {
    fn switch(&self, name: &str) -> Option<NamedSwitch> {
        Some(match name {
            "fan" => NamedSwitch { on: Code::m(106), number: None, off: None, full: 255.0 },
            "lamp" => NamedSwitch { on: Code::m(8), number: None, off: Some(Code::m(9)), full: 255.0 },
            "arm" => NamedSwitch { on: Code::m(280), number: None, off: None, full: 100.0 },
            "valve" => NamedSwitch { on: Code::m(42), number: Some(3), off: None, full: 255.0 },
            _ => return None,
        })
    }

    fn heater(&self, name: &str) -> Option<(Code, u8)> {
        (0..2)
            .filter_map(|place| self.heater_at(place))
            .nth(["extruder", "heater_bed"].iter().position(|n| *n == name)?)
    }

    fn strip(&self, name: &str) -> Option<u8> {
        ["case", "nozzle"].iter().position(|known| *known == name).map(|place| place as u8)
    }

    fn has_strips(&self) -> bool {
        true
    }

    fn heater_at(&self, place: usize) -> Option<(Code, u8)> {
        [(Code::m(104), 0), (Code::m(140), 254)].get(place).copied()
    }

    fn motor(&self, name: &str) -> Option<char> {
        ["stepper_x", "extruder"].iter().position(|known| *known == name).map(|place| ['X', 'A'][place])
    }
}

fn becomes(line: &str) -> Text {
    let mut codes = CodeLine::new();
    match translate(&Extended::new(line), &Machine, &mut codes) {
        Ok(Asked::Codes) => codes.trim().into(),
        Ok(Asked::Tower) => "tower".into(),
        Ok(Asked::Macros) => "macros".into(),
        Ok(Asked::Console(command)) => command.into(),
        Ok(Asked::PassedOver(name)) => std::format!("({name})"),
        Err(fault) => fault.to_string(),
    }
}

#[test]
fn commands_become_codes() {
    for (line, codes) in [
        ("SET_VELOCITY_LIMIT ACCEL=3000 ACCEL_TO_DECEL=1500", "M204 S3000 M205 C0.5"),
        ("set_velocity_limit VELOCITY=200 SQUARE_CORNER_VELOCITY=5", "M203 P200 M205 V5"),
        ("SET_VELOCITY_LIMIT", ""),
        ("SET_PRESSURE_ADVANCE ADVANCE=0.05 EXTRUDER=extruder", "M900 K0.05 P0"),
        ("SET_PRESSURE_ADVANCE EXTRUDER=extruder1 SMOOTH_TIME=0.02", "M900 W0.02 P1"),
        ("SET_GCODE_OFFSET Z=0.1 Z_ADJUST=5 X_ADJUST=-0.2", "M290 R0 Q0 Z0.1 M290 Q0 X-0.2 Z5"),
        ("SET_GCODE_OFFSET Z_ADJUST=-0.05 MOVE=1", "M290 Z-0.05"),
        ("SET_FAN_SPEED FAN=fan SPEED=0.5", "M106 S128"),
        ("SET_PIN PIN=lamp VALUE=1", "M8 S255"),
        ("SET_PIN PIN=lamp VALUE=0", "M9"),
        ("SET_PIN PIN=arm VALUE=0.075", "M280 S7.5"),
        ("SET_PIN PIN=valve VALUE=0.5", "M42 P3 S128"),
        ("SET_PIN PIN=valve VALUE=0", "M42 P3 S0"),
        ("SET_SERVO SERVO=valve ANGLE=12.5", "M42 P3 S12.5"),
        ("SET_SERVO SERVO=arm ANGLE=12.5", "M280 S12.5"),
        ("SET_SERVO SERVO=arm WIDTH=0.0015", "M280 S1500"),
        ("SET_HEATER_TEMPERATURE HEATER=heater_bed TARGET=60", "M140 S60 T254"),
        ("TURN_OFF_HEATERS", "M104 S0 T0 M140 S0 T254"),
        ("RESPOND TYPE=command MSG=\"a;b\"", "M118 // a,b"),
        ("RESPOND MSG=hello", "M118 echo: hello"),
        ("RESPOND PREFIX=> TYPE=error MSG=hello", "M118 > hello"),
        ("TEMPERATURE_WAIT SENSOR=heater_bed MINIMUM=59 MAXIMUM=61", "M116 P254 A59 B61"),
        ("EXCLUDE_OBJECT_START NAME=cube_1", "M486 Bcube_1"),
        ("EXCLUDE_OBJECT NAME=cube_1", "M486 Xcube_1"),
        ("EXCLUDE_OBJECT NAME=cube_1 RESET=1", "M486 Ycube_1"),
        ("EXCLUDE_OBJECT CURRENT=1", "M486 C"),
        ("EXCLUDE_OBJECT RESET=1", "M486 R"),
        ("EXCLUDE_OBJECT", "M486"),
        ("SET_INPUT_SHAPER SHAPER_FREQ_X=40 SHAPER_TYPE=mzv", "M593 X F40 P\"mzv\""),
        ("TIMELAPSE_TAKE_FRAME", "(TIMELAPSE_*)"),
        ("ACTIVATE_EXTRUDER EXTRUDER=extruder2", "T2"),
        ("CANCEL_PRINT", "abort"),
        ("PROBE_CALIBRATE", "M851.1 P0"),
        ("SET_STEPPER_ENABLE STEPPER=stepper_x ENABLE=0", "M18 X"),
        ("SET_RETRACTION RETRACT_LENGTH=0.8 RETRACT_SPEED=30 UNRETRACT_SPEED=20", "M207 S0.8 F1800 M208 F1200"),
        ("SDCARD_PRINT_FILE FILENAME=\"a b.g\"", "M32 a b.g"),
        ("SAVE_VARIABLE VARIABLE=a VALUE=1", "macros"),
        ("ENDSTOP_PHASE_CALIBRATE", "M875"),
        ("ENDSTOP_PHASE_CALIBRATE AXIS=z", "M875.1 Z"),
        ("ENDSTOP_PHASE_CALIBRATE STEPPER=stepper_b", "M875.1 Y"),
        ("TESTZ Z=-0.1", "M851.2 Z-0.1"),
        ("TESTZ Z=+", "M851.2 S1"),
        ("testz z=--", "M851.2 S-2"),
        ("ADJUSTED", "M851.5"),
        ("DELTA_CALIBRATE", "G32 S6"),
        ("SET_SKEW XY=140.4,142.8,99.8 YZ=141,141.2,100", "M852 P0 A140.4 B142.8 D99.8 M852 P2 A141 B141.2 D100"),
        ("SET_SKEW CLEAR=1", "M852 I0 J0 K0"),
        ("CALC_MEASURED_SKEW AC=140.4 BD=142.8 AD=99.8", "M852.1 A140.4 B142.8 D99.8"),
        ("SET_TMC_CURRENT STEPPER=stepper_x CURRENT=0.8 HOLDCURRENT=0.5", "M906 X1131"),
        ("SET_TMC_CURRENT STEPPER=extruder", "M911 A"),
        ("DUMP_TMC STEPPER=stepper_x", "M911 X"),
        ("PID_CALIBRATE HEATER=heater_bed TARGET=60 WRITE_FILE=1", "M303 P254 S60"),
        ("GET_POSITION", "M114.3 M114.2 M114"),
        ("PROBE PROBE_SPEED=5", "G30 P1 F300"),
        ("SET_KINEMATIC_POSITION", "G28.3"),
        ("SET_KINEMATIC_POSITION X=10 Z=-0.5", "G28.3 X10 Z-0.5"),
        ("SET_KINEMATIC_POSITION CLEAR_HOMED=XZ", "G28.5 X Z"),
        ("SET_KINEMATIC_POSITION Z=0 CLEAR_HOMED=y", "G28.3 Z0 G28.5 Y"),
        ("SET_STEPPER_ENABLE STEPPER=extruder ENABLE=0", "M18 A"),
        ("SET_STEPPER_ENABLE STEPPER=extruder ENABLE=1", "M17"),
        ("SET_RETRACTION RETRACT_LENGTH=0.8 RETRACT_SPEED=35", "M207 S0.8 F2100"),
        ("SET_RETRACTION UNRETRACT_EXTRA_LENGTH=0.05 RETRACT_LENGTH=1", "M207 S1 M208 S0.05"),
        ("SET_FILAMENT_SENSOR SENSOR=runout ENABLE=0", "M412 S0"),
        ("SDCARD_PRINT_FILE FILENAME=parts/clip.gcode", "M32 parts/clip.gcode"),
        ("SDCARD_RESET_FILE", "abort"),
        ("SAVE_CONFIG", "M500"),
        ("FIRMWARE_RESTART", "reset"),
        ("BED_TILT_CALIBRATE", "G32"),
    ] {
        assert_eq!(becomes(line), codes, "{line}");
    }
}

#[test]
fn what_cannot_be_carried_out_says_why() {
    for (line, why) in [
        ("PRINT_START BED=60", "is not known here"),
        ("SET_VELOCITY_LIMIT ACCEL=fast", "needs a number for ACCEL="),
        ("ENDSTOP_PHASE_CALIBRATE AXIS=extruder", "letter of an axis"),
        ("SET_FAN_SPEED FAN=other SPEED=1", "names no switch"),
        ("SET_HEATER_TEMPERATURE HEATER=chamber TARGET=60", "names no heater"),
        ("TEMPERATURE_WAIT SENSOR=extruder", "needs MINIMUM="),
        ("TESTZ", "needs Z="),
        ("TESTZ Z=up", "needs a number for Z="),
        ("SET_SKEW XY=140,141", "needs three lengths for XY="),
        ("SET_TMC_CURRENT STEPPER=stepper_q CURRENT=1", "names no motor"),
        ("SET_TMC_CURRENT CURRENT=1", "needs STEPPER="),
        ("SET_STEPPER_ENABLE STEPPER=extruder", "needs ENABLE="),
        ("PID_CALIBRATE HEATER=chamber TARGET=60", "names no heater"),
        ("SET_KINEMATIC_POSITION CLEAR_HOMED=", "letters of X, Y and Z"),
        ("TEST_RESONANCES AXIS=X", "no accelerometer"),
        ("LOAD_CELL_TARE", "no chip"),
    ] {
        assert!(becomes(line).contains(why), "{line}: {}", becomes(line));
    }
}

#[test]
fn every_row_says_what_it_does_and_is_found() {
    for row in all() {
        let found = find(row.name.trim_end_matches('*')).map(|found| found.name);
        assert_eq!(found, Some(row.name));
        assert!(row.help.len() > 8 && row.help.len() <= 90 && !row.help.ends_with('.'), "{}", row.name);
    }
}
