//! Machines in the manner of Smoothieware v2's own samples, with figures of ours: what those samples set is
//! set here, and what they leave to defaults is left out. The checker says nothing of them that their owner
//! would call wrong, on either board.

use config::{ArmSolution, BoardId, Diagnostic, MachineConfig, Severity, Summary};
use units::{Actuator, Axis};

type Findings = heapless::Vec<Diagnostic, 64>;

const BOARDS: [BoardId; 2] = [BoardId::Prime2590, BoardId::Prime2660];

/// Limits of the axes, motors without a driver's name, and settings of both kinds of drivers.
const MOTION: &str = "
[system]
[motion control]
default_feed_rate = 3600
default_seek_rate = 3600
mm_per_arc_segment = 0.0
mm_max_arc_error = 0.02
arc_correction = 5
default_acceleration = 800.0
arm_solution = cartesian
x_axis_max_speed = 24000
y_axis_max_speed = 24000
z_axis_max_speed = 1500
must_be_homed = false
[planner]
junction_deviation = 0.04
minimum_planner_speed = 0
planner_queue_size = 48
[actuator]
alpha.steps_per_mm = 160
alpha.max_rate = 24000
alpha.microsteps = 32
alpha.reversed = false
beta.steps_per_mm = 160
beta.max_rate = 24000
beta.microsteps = 32
gamma.steps_per_mm = 640
gamma.max_rate = 1500
gamma.acceleration = 300
gamma.microsteps = 32
common.check_driver_errors = true
common.halt_on_driver_alarm = false
[current control]
alpha.current  = 1.4
beta.current   = 1.4
gamma.current  = 1.1
[kill button]
enable = false
pin = PJ6
toggle_enable = false
unkill_enable = true
[pwm1]
frequency=8000
[pwm2]
frequency=50
[voltage monitor]
[network]
enable = false
shell_enable = true
ftp_enable = true
webserver_enable = true
ntp_enable = true
hostname = workshop
ip_address = auto
timezone = 0
";

/// Three switches that are limits too; those of a delta are not.
fn endstops(direction: &str, limits: bool, rates: [u32; 2]) -> String {
    let [fast, slow] = rates;
    let of = |(name, axis, pin): (&str, char, &str)| {
        format!(
            "{name}.enable = true\n{name}.pin = {pin}^\n{name}.homing_direction = {direction}\n\
             {name}.homing_position = 0\n{name}.axis = {axis}\n{name}.max_travel = 400\n{name}.fast_rate = {fast}\n\
             {name}.slow_rate = {slow}\n{name}.retract = 4\n{name}.limit_enable = {limits}\n"
        )
    };
    let all: String = [("minx", 'X', "PD0"), ("miny", 'Y', "PI1"), ("minz", 'Z', "PI0")].into_iter().map(of).collect();
    format!("[endstops]\ncommon.debounce_ms = 0\n{all}")
}

/// Settings of both boards' drivers: each board reads its own.
fn drivers(kinds: &[&str]) -> String {
    let of = |kind: &&str| {
        let motor = |name: &str| format!("{name}.step_interpolation = false\n{name}.standstill_current = 0\n");
        let motors: String = ["alpha", "beta", "gamma", "delta"].map(motor).concat();
        format!("[{kind}]\n{motors}")
    };
    kinds.iter().map(of).collect()
}

/// Returns `MOTION` with the motor of an extruder: a section stands once.
fn motion_with_extruder() -> String {
    MOTION
        .replace(
            "common.check_driver",
            "delta.steps_per_mm = 690\ndelta.acceleration = 450\ndelta.max_rate = 2700.0\ndelta.microsteps = 32\n\
             common.check_driver",
        )
        .replace("[kill button]", "delta.current = 0.7\n[kill button]")
}

/// A hot end, a bed, fans, a power supply, and a servo that is not in use yet.
const HEAT: &str = "
[uart console]
enable = false
console = true
channel = 1
baudrate = 115200
bits = 8
stop_bits = 1
parity = none
[consoles]
second_usb_serial_enable = false
[switch]
drive.enable             = true
drive.input_pin          = PJ14
drive.output_on_command  = msc
drive.input_pin_behavior = momentary
part.enable = true
part.input_on_command = M106
part.input_off_command = M107
part.output_pin = PE1
part.output_type = sigmadeltapwm
cold.enable = true
cold.input_on_command = M106
cold.input_off_command = M107
cold.subcode = 1
cold.output_pin = PI11
cold.output_type = digital
cold.ignore_on_halt = true
cold.startup_state = true
psu.enable = true
psu.input_on_command = M80
psu.input_off_command = M81
psu.output_pin = PI4!
psu.output_type = digital
arm.enable = false
arm.output_pin = PWM2_1
arm.input_on_command = M280
arm.input_off_command = M281
arm.output_type = hwpwm
arm.startup_state = false
arm.startup_value = 6.5
arm.default_on_value = 3.5
[temperature switch]
nozzle.enable = true
nozzle.designator = T
nozzle.switch = cold
nozzle.threshold_temp = 55.0
nozzle.heatup_poll = 10
nozzle.cooldown_poll = 40
psu_off.enable = true
psu_off.designator = T
psu_off.switch = psu
psu_off.threshold_temp = 45.0
psu_off.heatup_poll = 20
psu_off.cooldown_poll = 20
psu_off.arm_mcode = 1100
psu_off.trigger = falling
psu_off.inverted = false
[extruder]
hotend.enable = true
hotend.tool_id = 0
hotend.retract_length = 0.8
hotend.retract_feedrate = 12
hotend.retract_recover_length = 0
hotend.retract_recover_feedrate = 9
hotend.retract_zlift_length = 0.4
hotend.retract_zlift_feedrate = 1000
hotend.filament_diameter = 1.75
second.enable = false
second.tool_id = 1
second.x_offset = 0
second.y_offset = 22.0
second.z_offset = 0
[temperature control]
hotend.enable = true
hotend.thermistor = EPCOS100K
hotend.runaway_cooling_timeout = 600
hotend.p_factor = 40
hotend.i_factor = 4.5
hotend.d_factor = 95
second.enable = false
second.thermistor = EPCOS100K
bed.enable = true
bed.beta = 4000
bed.designator = B
board.enable = true
board.beta = 4390
[laser]
enable = false
pwm_pin = PWM1_1
";

/// A probe that is there for a day, and three strategies that nothing uses yet.
const PROBE: &str = "
[zprobe]
enable = false
probe_pin = PB10^
slow_feedrate = 4
fast_feedrate = 90
probe_height = 4
max_travel = 150
leveling = three point
[three point leveling strategy]
point1 = 90.0,0.0
point2 = 180.0,190.0
point3 = 0.0,190.0
home_first = true
tolerance = 0.04
probe_offsets = 0,0,0
save_plane = false
[delta calibration strategy]
radius = 90
initial_height = 25
[delta grid leveling strategy]
radius = 60
size = 9
do_home = true
save = true
initial_height = 25
[cartesian grid leveling strategy]
x_size =          90
y_size =          60
grid_x_size =      5
grid_y_size =      5
do_home =          true
probe_offsets =    0,0,0
save =             false
initial_height =    15
dampening_start =  0.4
height_limit =       2
";

fn read(text: &str, board: BoardId) -> (MachineConfig, Summary, Vec<(Severity, String)>) {
    let mut findings = Findings::new();
    let (config, summary) = config::parse(text.as_bytes(), board, &mut findings);
    let told = findings.iter().map(|finding| (finding.severity, finding.to_string())).collect();
    (config, summary, told)
}

#[test]
fn a_printer_has_no_finding() {
    let general = "[general]\ngrbl_mode = false\nconfig-override = false\n";
    let drivers = drivers(&["tmc2590", "tmc2660"]);
    let motion = motion_with_extruder();
    let text = format!("{general}{motion}{drivers}{HEAT}{}{PROBE}", endstops("home_to_min", true, [25, 4]));
    for board in BOARDS {
        let (config, summary, told) = read(&text, board);
        assert_eq!((summary, told.as_slice()), (Summary::default(), &[][..]), "{board:?}");
        assert_eq!(config.motion.arm_solution, ArmSolution::Cartesian);
        assert_eq!(config.actuators().count(), 4);
        assert_eq!(config.extruders[0].actuator(), Some(Actuator::Delta));
        assert_eq!(config.temperature_switches.len(), 2);
        assert_eq!(config.temperature_switches[1].arm_mcode, Some(1_100));
        // Heaters without pins have the board's own, by name.
        for (heater, pin) in [("hotend", "PE0"), ("bed", "PE3")] {
            let heater = config.temperatures.iter().find(|one| one.name == heater).expect("a heater");
            assert_eq!(heater.heater_pin.expect("a pin").to_string(), pin);
        }
    }
}

#[test]
fn a_mill_has_no_finding() {
    let general = "[general]\ngrbl_mode = true\nconfig-override = false\n";
    let spindle = "[switch]\nspindle.enable = true\nspindle.input_on_command = M2\nspindle.input_off_command = M5\n\
                   spindle.output_pin = PI4!\nspindle.output_type = digital\n\
                   [temperature control]\nboard.enable = true\nboard.thermistor_pin = ADC1_0\nboard.designator = P\n\
                   board.beta = 4300\n[laser]\nenable = false\npwm_pin = PWM1_1\n";
    let drivers = drivers(&["tmc2590", "tmc2660"]);
    let text = format!("{general}{MOTION}{drivers}{spindle}{}{PROBE}", endstops("home_to_min", true, [20, 4]));
    for board in BOARDS {
        let (config, summary, told) = read(&text, board);
        assert_eq!((summary, told.as_slice()), (Summary::default(), &[][..]), "{board:?}");
        assert!(config.general.grbl_mode && !config.general.config_override);
        assert_eq!(config.switches[0].input_on_command.expect("a code").number, 2);
    }
}

/// A delta whose file describes one kind of drivers belongs to the board that has them.
#[test]
fn a_delta_is_at_home_on_the_board_of_its_drivers() {
    let general = "[general]\ngrbl_mode = false\nconfig-override = false\n";
    let motion = motion_with_extruder()
        .replace("arm_solution = cartesian", "arm_solution = linear_delta\ndelta_segments_per_second = 120")
        .replace("must_be_homed = false", "must_be_homed = true")
        .replace("z_axis_max_speed = 1500", "z_axis_max_speed = 9000")
        .replace("gamma.max_rate = 1500", "gamma.max_rate = 12000")
        .replace("gamma.steps_per_mm = 640", "gamma.steps_per_mm = 160");
    let arms = "[linear delta]\narm_length = 300\narm_radius = 150.5\n";
    let probe = PROBE
        .replace("enable = false", "enable = true")
        .replace("leveling = three point", "leveling = delta grid\ncalibration = delta");
    let switches = endstops("home_to_max", false, [150, 10])
        .replace("common.debounce_ms = 0", "common.debounce_ms = 0\ncommon.delta_homing = true");
    let text = format!("{general}{motion}{arms}{}{HEAT}{switches}{probe}", drivers(&["tmc2660"]));
    // The sockets of the board for X and Z: their numbers are the same.
    let lines = "the X and Z switches share interrupt line 0";
    let (config, summary, told) = read(&text, BoardId::Prime2660);
    assert!(summary.is_usable() && summary.is_complete(), "{told:#?}");
    let [(Severity::Warning, told)] = told.as_slice() else { panic!("{told:#?}") };
    assert!(told.contains(lines), "{told}");
    assert!(config.homing.delta && config.homing.move_to_origin);
    assert!(config.homing_endstop(Axis::Z).is_some() && config.motion.lines.segments_per_second == Some(120.0));
    let (_, summary, told) = read(&text, BoardId::Prime2590);
    assert!(!summary.is_usable(), "its drivers are others");
    let drivers = told.iter().filter(|(_, told)| told.contains("check with --board tmc2660")).count();
    assert_eq!((drivers, told.len()), (4, 5), "{told:#?}");
}

#[test]
fn a_lathe_starts_without_its_lathe() {
    let general = "[general]\ngrbl_mode = true\nconfig-override = false\n";
    let motion = MOTION
        .replace("[system]", "[system]\nstep_pulse_us = 3")
        .replace(
            "gamma.microsteps = 32",
            "gamma.driver = external\ngamma.step_pin = PJ6\ngamma.dir_pin = PJ9\ngamma.en_pin = nc",
        )
        .replace("[kill button]\nenable = false\npin = PJ6", "[kill button]\nenable = false\npin = PD14");
    let lathe = "[tm1638]\nenable = false\nclock_pin = PJ11\ndata_pin = PJ6\nstrobe_pin = PJ9\n\
                 [lathe]\nenable = true\nencoder_ppr = 1000\nindex_pin = PD15\n[els]\nenable = true\n";
    let text = format!(
        "{general}{motion}{}{lathe}{}{PROBE}",
        drivers(&["tmc2590", "tmc2660"]),
        endstops("home_to_min", true, [20, 4])
    );
    for board in BOARDS {
        let (config, summary, told) = read(&text, board);
        assert!(summary.is_usable(), "{told:#?}");
        let expected = [
            (Severity::Error, "[lathe] enable: not supported yet"),
            (Severity::Warning, "[els] enable: not supported yet"),
            (Severity::Warning, "gamma.current: an external driver's current cannot be set from here"),
        ];
        assert_eq!(told.len(), expected.len(), "{told:#?}");
        for (severity, part) in expected {
            assert!(told.iter().any(|(of, text)| *of == severity && text.contains(part)), "{part}: {told:#?}");
        }
        let off: Vec<&str> = config.off.iter().map(|part| part.section).collect();
        assert_eq!(off, ["lathe"]);
    }
}

/// Motors of external drivers alone, and nothing else.
#[test]
fn a_file_of_external_drivers_alone_starts() {
    let motor = |(name, step, dir, enable): (&str, &str, &str, &str)| {
        format!(
            "{name}.driver = external\n{name}.step_pin = {step}\n{name}.dir_pin = {dir}\n{name}.en_pin = {enable}\n"
        )
    };
    let motors: String = [("alpha", "PG0", "PG1", "PJ2"), ("beta", "PA4", "PJ3", "nc"), ("gamma", "PJ4", "PB1", "nc")]
        .map(motor)
        .concat();
    for board in BOARDS {
        let (config, summary, told) = read(&format!("[actuator]\n{motors}"), board);
        assert!(summary.is_usable() && summary.is_complete(), "{told:#?}");
        let [(Severity::Warning, told)] = told.as_slice() else { panic!("{told:#?}") };
        assert!(told.contains("gamma.max_rate: needs 1280000 steps/s, but step_frequency allows 200000; lowered"));
        assert_eq!(config.actuators().count(), 3);
    }
}

/// Buttons of the board work; those of a panel wait for it, and the lines of a keypad are told one by one.
#[test]
fn a_button_box_has_its_buttons() {
    let general = "[general]\ngrbl_mode = false\n";
    let switches = endstops("home_to_min", true, [25, 4]);
    let buttons = "[button box]\nup.enable = true\nup.pin = PJ2-\nup.press = $J -c Z1 S0.3\nup.release = $J STOP\n\
                   down.enable = true\ndown.pin = PJ4-\ndown.press = $J -c Z-1 S0.3\ndown.release = $J STOP\n\
                   panel.enable = true\npanel.pin = external\npanel.press = $J STOP\n\
                   keys.enable = true\nkeys.rows = 2\nkeys.cols = 2\nkeys.row1pin = PB1!\nkeys.col1pin = PG1^\n\
                   keys.map = 12AB\nkeys.1_press = echo one\nkeys.1_release = echo up\n";
    let text = format!("{general}{MOTION}{}{switches}{buttons}", drivers(&["tmc2590", "tmc2660"]));
    for board in BOARDS {
        let (config, summary, told) = read(&text, board);
        assert!(summary.is_usable() && told.iter().all(|(_, text)| !text.contains("did you mean")), "{told:#?}");
        // A keypad has keys in rows and columns, and no pin: of a button without one nothing is made.
        let (keys, others): (Vec<_>, Vec<_>) = told.iter().partition(|(_, text)| text.contains("keys."));
        let [(Severity::Warning, panel)] = others.as_slice() else { panic!("{told:#?}") };
        assert!(panel.contains("panels are not supported yet"), "{panel}");
        let errors = keys.iter().filter(|(severity, _)| *severity == Severity::Error);
        assert_eq!((keys.len(), errors.count()), (9, 2), "{told:#?}");
        let off: Vec<&str> = config.off.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(off, ["keys"]);
        let press = |name: &str| config.buttons.iter().find(|button| button.name == name).map(|one| one.press.as_str());
        assert_eq!((press("up"), press("down")), (Some("$J -c Z1 S0.3"), Some("$J -c Z-1 S0.3")));
    }
}
