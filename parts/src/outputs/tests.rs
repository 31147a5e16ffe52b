//! Tests of outputs, a door and a button.

use super::*;

const FAN: SwitchId = SwitchId(0);
const SPINDLE: SwitchId = SwitchId(1);
const POWER: SwitchId = SwitchId(2);
const BUTTON: SwitchId = SwitchId(3);

fn machine() -> MachineConfig {
    let switch = |name: &str, output_kind| SwitchConfig {
        name: name.try_into().unwrap(),
        output_kind,
        max_pwm: Duty(200),
        ..SwitchConfig::default()
    };
    let mut config = MachineConfig::default();
    let spindle =
        SwitchConfig { startup_value: 5.0, default_on_value: 60.0, ..switch("spindle", OutputKind::HardwarePwm) };
    let power = SwitchConfig { startup_state: true, ..switch("power", OutputKind::Digital) };
    let button = SwitchConfig {
        input_pin: Some(config::Pin::new('A', 0)),
        output_on_command: "M25".try_into().unwrap(),
        output_off_command: "M24".try_into().unwrap(),
        ..switch("button", OutputKind::Digital)
    };
    for switch in [switch("fan", OutputKind::SigmaDelta), spindle, power, button] {
        assert!(config.switches.push(switch).is_ok());
    }
    config
}

fn pressed(down: bool) -> InputLevels {
    if down { InputLevels::default().with(Input::Switch(BUTTON.0)) } else { InputLevels::default() }
}

#[test]
fn s_is_a_share_of_the_ceiling_or_percent_and_nothing_changes_twice() {
    let config = machine();
    let mut outputs = Outputs::new(&config.switches);
    assert_eq!(outputs.turn(&config, FAN, true, Some(127.5)), Some(Output::Switch(0, Duty(100))));
    assert_eq!(outputs.turn(&config, FAN, true, Some(127.5)), None);
    assert_eq!(outputs.turn(&config, FAN, true, Some(1_000.0)), Some(Output::Switch(0, Duty(200))));
    assert_eq!(outputs.turn(&config, FAN, true, Some(0.0)), Some(Output::Switch(0, Duty::OFF)));
    assert!(!outputs.is_on(FAN));
    assert_eq!(outputs.turn(&config, SPINDLE, true, Some(50.0)), Some(Output::Pwm(1, 0.5)));
    assert_eq!(outputs.turn(&config, SPINDLE, true, None), Some(Output::Pwm(1, 0.6)));
    assert!(outputs.is_on_by_name(&config, "spindle") && !outputs.is_on_by_name(&config, "pump"));
    assert_eq!(outputs.turn(&config, SPINDLE, false, Some(50.0)), Some(Output::Pwm(1, 0.05)));
    assert_eq!(outputs.turn(&config, POWER, true, Some(3.0)), Some(Output::Switch(2, Duty::FULL)));
    assert_eq!(outputs.turn(&config, POWER, true, Some(0.0)), Some(Output::Switch(2, Duty::OFF)));
    assert_eq!(outputs.turn(&config, BUTTON, true, None), None);
}

#[test]
fn s_of_a_spindle_is_a_share_of_max_rpm_and_never_less_than_min_rpm() {
    for (kind, full) in [(OutputKind::HardwarePwm, 100.0), (OutputKind::SigmaDelta, 200.0)] {
        let mut config = machine();
        let on = gcode::Code::m(3);
        let settings = &mut config.switches[SPINDLE.index()];
        (settings.output_kind, settings.input_on_command) = (kind, Some(on));
        (settings.max_rpm, settings.min_rpm) = (24_000.0, 6_000.0);
        let mut outputs = Outputs::new(&config.switches);
        let speeds = [(12_000.0, 0.5), (3_000.0, 0.25), (0.0, 0.0), (6_000.0, 0.25), (30_000.0, 1.0), (24_000.0, 1.0)];
        for (s, share) in speeds {
            outputs.turn(&config, SPINDLE, true, Some(s));
            assert_eq!(outputs.status[SPINDLE.index()].value, share * full, "{kind:?} {s}");
            assert_eq!(outputs.spindle_speed(&config, s), share * 24_000.0);
        }
        let beyond = |s| beyond(&config, SPINDLE, Some(s)).is_some();
        assert_eq!([0.0, 5_999.0, 6_000.0, 24_000.0, 24_001.0].map(beyond), [false, true, false, false, true]);
    }
}

#[test]
fn which_way_a_spindle_turns_is_no_spindle() {
    let mut config = machine();
    let code = |number| Some(gcode::Code::m(number));
    let direction = &mut config.switches[POWER.index()];
    (direction.input_on_command, direction.input_off_command) = (code(4), code(3));
    let spindle = &mut config.switches[SPINDLE.index()];
    (spindle.input_on_command, spindle.input_reverse_command, spindle.input_off_command) = (code(3), code(4), code(5));
    let mut outputs = Outputs::new(&config.switches);
    let (stopped, right, left) =
        (program::Spindle::Stopped, program::Spindle::Clockwise, program::Spindle::CounterClockwise);
    outputs.turn(&config, POWER, true, None);
    assert_eq!(outputs.spindle(&config, left), stopped);
    outputs.turn(&config, SPINDLE, true, Some(30.0));
    assert_eq!([left, right, stopped].map(|told| outputs.spindle(&config, told)), [left, right, right]);
    // An open door stops the spindle, and keeps its direction.
    assert_eq!(outputs.door_opens(&config).as_slice(), [Output::Pwm(SPINDLE.0, 0.05)]);
}

#[test]
fn a_change_that_was_dropped_with_its_path_can_be_asked_for_again() {
    let config = machine();
    let mut outputs = Outputs::new(&config.switches);
    let on = outputs.turn(&config, POWER, true, None);
    outputs.changes_were_dropped();
    assert_eq!(outputs.turn(&config, POWER, true, None), on);
    assert_eq!(outputs.turn(&config, POWER, true, None), None);
}

#[test]
fn a_halt_leaves_no_timer_running_and_what_ignores_it_alone() {
    let mut config = machine();
    config.switches[POWER.index()].ignore_on_halt = true;
    config.switches[SPINDLE.index()].halt_set_to = true;
    let mut outputs = Outputs::new(&config.switches);
    assert_eq!(outputs.start(&config, InputLevels::default()).len(), 3);
    outputs.turn(&config, SPINDLE, true, None);
    let changes = outputs.halt(&config);
    assert_eq!(changes.as_slice(), [Output::Switch(0, Duty::OFF), Output::Pwm(1, 0.05)]);
    assert!(outputs.is_on(POWER) && !outputs.is_on(SPINDLE));
    // The changes that rode on the path were dropped, so the next word counts.
    assert!(outputs.turn(&config, POWER, true, None).is_some());
}

#[test]
fn an_open_door_stops_timers_spindle_and_coolant_and_a_closed_one_lets_them_go_on() {
    let mut config = machine();
    config.switches[POWER.index()].input_on_command = Some(gcode::Code::m(8));
    let mut outputs = Outputs::new(&config.switches);
    outputs.turn(&config, FAN, true, Some(255.0));
    outputs.turn(&config, SPINDLE, true, Some(50.0));
    outputs.turn(&config, POWER, true, None);
    assert_eq!(outputs.door_opens(&config).as_slice(), [Output::Pwm(1, 0.05), Output::Switch(2, Duty::OFF)]);
    assert_eq!(outputs.door_closes(&config).as_slice(), [Output::Pwm(1, 0.5), Output::Switch(2, Duty::FULL)]);
    outputs.turn(&config, POWER, false, None);
    assert_eq!(outputs.door_closes(&config)[1], Output::Switch(2, Duty::OFF));
}

#[test]
fn a_button_gives_the_command_of_each_change_once() {
    let config = machine();
    let mut outputs = Outputs::new(&config.switches);
    outputs.start(&config, pressed(false));
    outputs.look(pressed(true), &config, Micros::from_millis(20));
    assert_eq!(outputs.take_command(&config).as_deref(), Some("M25"));
    assert_eq!(outputs.take_command(&config), None);
    outputs.look(pressed(false), &config, Micros::from_millis(39));
    assert_eq!(outputs.take_command(&config), None, "looked at too early");
    outputs.look(pressed(false), &config, Micros::from_millis(40));
    assert_eq!(outputs.take_command(&config).as_deref(), Some("M24"));
}

#[test]
fn a_toggle_changes_with_each_press() {
    let mut config = machine();
    config.switches[BUTTON.index()].input_behaviour = InputBehaviour::Toggle;
    let mut outputs = Outputs::new(&config.switches);
    let mut commands = Vec::<Command, 8>::new();
    for (turn, down) in (1..).zip([true, false, true, false]) {
        outputs.look(pressed(down), &config, Micros::from_millis(20 * turn));
        commands.extend(outputs.take_command(&config));
    }
    assert_eq!(commands.as_slice(), ["M25", "M24"]);
}

#[test]
fn an_output_is_listed_with_its_pin_its_level_and_its_codes() {
    let mut config = machine();
    config.switches[0].output_pin = Some(config::OutputPin::Digital(config::Pin::new('E', 1)));
    config.switches[0].input_on_command = Some(gcode::Code::m(106));
    let outputs = Outputs::new(&config.switches);
    let said = base::bench::Desk::new().hears(|reply| outputs.list(&config, reply));
    let mut lines = said.lines();
    assert_eq!(
        (lines.next(), lines.next()),
        (Some("fan:"), Some(" OUTPUT:PE1:0,sigmadeltapwm,INPUT_ON_COMMAND:M106,"))
    );
    assert!(said.contains("power:\n OUTPUT:nc,\n"), "{said}");
    assert!(said.contains("OUTPUT_ON_COMMAND:M25,OUTPUT_OFF_COMMAND:M24,"), "{said}");
    let mut outputs = outputs;
    outputs.set(&config, POWER, true, 255.0);
    let said = base::bench::Desk::new().hears(|reply| outputs.report(&config, "power", reply));
    assert_eq!(said, "switch power is 1\n");
}
