//! Inputs: switches, probe, buttons, straps, sensors; and the lamps.

use board_facts::wiring::{END_STOPS, LEDS, PROBE, THERMISTORS};
use rigless::soc::stm32h743::peripherals::adc::Channel;
use sim::models::tmc26x::Chip;
use sim::world::Fault;

use crate::common::machine::{changes, drive, everything, pin, watch};
use crate::common::velvet::{Plan, SECOND, Velvet};

/// Returns the state of this pin in the answer to M119: `PD0^:1`.
#[track_caller]
fn reported(velvet: &mut Velvet, pin: &str, modifiers: &str) -> bool {
    velvet.type_in("M119");
    let said = velvet.hear_until("ok\n", SECOND);
    let name = format!("{pin}{modifiers}:");
    let at = said.find(&name).unwrap_or_else(|| panic!("no {name} in {said}")) + name.len();
    said[at..].starts_with('1')
}

#[test]
fn a_plain_end_stop_is_hit_while_its_pin_is_high() {
    let mut velvet = everything().start();
    velvet.hear(100);
    for (name, pin) in END_STOPS {
        for high in [true, false, true, false] {
            drive(&mut velvet, pin, high);
            velvet.hear(5);
            assert_eq!(reported(&mut velvet, pin, "^"), high, "{name}");
        }
    }
}

#[test]
fn an_inverted_end_stop_is_hit_while_its_pin_is_low() {
    let mut velvet = everything().set("[endstops] minx.pin = PD0!^").start();
    velvet.hear(100);
    for high in [true, false, true] {
        drive(&mut velvet, "PD0", high);
        velvet.hear(5);
        assert_eq!(reported(&mut velvet, "PD0", "!^"), !high);
    }
}

#[test]
fn a_plain_probe_touches_while_its_pin_is_high() {
    let mut velvet = everything().start();
    velvet.hear(100);
    for high in [true, false, true] {
        drive(&mut velvet, PROBE, high);
        velvet.hear(5);
        assert_eq!(reported(&mut velvet, PROBE, "^"), high);
    }
}

#[test]
fn the_kill_button_is_pressed_while_its_pin_is_low() {
    let mut velvet = everything().start();
    drive(&mut velvet, "PJ6", true);
    velvet.hear(SECOND);
    assert!(!velvet.said().contains("Kill button"), "{}", velvet.said());
    drive(&mut velvet, "PJ6", false);
    velvet.hear_until("ALARM: Kill button pressed", SECOND);
}

/// LED1 blinks while the machine is up and idle; the other LEDs stay dark.
#[test]
fn a_high_led_pin_is_what_shows_life() {
    let mut velvet = everything().start();
    watch(&mut velvet, &LEDS);
    velvet.hear(3 * SECOND);
    let all = changes(&mut velvet);
    let lit = |name: &'static str| all.iter().filter(|change| change.pin == pin(name) && change.high).count();
    assert!(lit(LEDS[0]) >= 1, "{all:?}");
    assert!(LEDS[1..].iter().all(|name| lit(name) == 0), "{all:?}");
}

/// LED 3 is lit while a heater is on or hot, LED 4 while a file is played.
#[test]
fn the_third_led_says_hot_and_the_fourth_that_a_file_is_played() {
    let mut velvet = Plan::new().file("job.g", "G4 S2\n").start();
    velvet.hear(300);
    let lit = |velvet: &mut Velvet| [LEDS[2], LEDS[3]].map(|name| velvet.level(name));
    assert_eq!(lit(&mut velvet), [false, false]);
    velvet.ask("M104 S60", SECOND);
    velvet.hear(300);
    assert_eq!(lit(&mut velvet), [true, false], "a heater is on");
    velvet.type_in("play /sd/job.g");
    velvet.hear_until("Playing", SECOND);
    velvet.hear(300);
    assert_eq!(lit(&mut velvet), [true, true]);
    velvet.hear(23 * SECOND);
    assert_eq!(lit(&mut velvet), [true, false]);
    velvet.ask("M104 S0", SECOND);
    velvet.hear(300);
    assert_eq!(lit(&mut velvet), [true, false], "it is still hot");
}

/// Output `aux_play_led` follows LED 2: dark at rest, on during motion, blinking in a halt.
#[test]
fn a_second_lamp_follows_the_second_led() {
    let mut velvet = Plan::new().set("[system] aux_play_led = PJ9!").start();
    let dark_and_lit = |velvet: &mut Velvet| [LEDS[1], "PJ9"].map(|name| velvet.level(name));
    assert_eq!(dark_and_lit(&mut velvet), [false, true], "at rest; ! lights it with a low pin");
    velvet.ask("G91", SECOND);
    velvet.type_in("G1 X10 F600");
    velvet.hear(500);
    assert_eq!(dark_and_lit(&mut velvet), [true, false], "moving");
    velvet.ask("M400", 2 * SECOND);
    velvet.hear(300);
    watch(&mut velvet, &["PJ9"]);
    velvet.ask("M112", SECOND);
    velvet.hear(2 * SECOND);
    assert!(changes(&mut velvet).len() >= 6, "it blinks in a halt");
}

#[test]
fn the_straps_say_which_drivers_there_are() {
    for (chip, id) in [(Chip::Tmc2590, "board id 0"), (Chip::Tmc2660, "board id 1")] {
        let velvet = Plan::new().with_drivers(chip).start();
        assert!(velvet.said().contains(id), "{}", velvet.said());
    }
}

/// 100 kOhm under 4.7 kOhm is a 104NT-4 of 25 C; the other connectors stay open.
#[test]
fn each_thermistor_is_read_at_its_own_input() {
    const AT_25_C_MV: u32 = (3_300.0 * 100_000.0 / 104_700.0 + 0.5) as u32;
    let sensors = [("hotend", 1, "T:"), ("hotend2", 2, "T2:"), ("bed", 3, "B:")];
    // The simulated machine has no sensors on these connectors, so only the test sets their voltages.
    let plan = || {
        let bare = ["hotend", "bed", "board"]
            .iter()
            .fold(Plan::new(), |plan, name| plan.set(&format!("[temperature control] {name}.enable = false")));
        let lines = [
            "hotend.enable = true",
            "hotend.thermistor = Semitec-104NT4",
            "bed.enable = true",
            "bed.thermistor = Semitec-104NT4",
            "hotend2.enable = true",
            "hotend2.tool_id = 1",
            "hotend2.designator = T2",
            "hotend2.thermistor_pin = ADC1_2",
            "hotend2.thermistor = Semitec-104NT4",
            "hotend2.heater_pin = PB8",
        ];
        lines.iter().fold(bare.built(), |plan, line| plan.set(&format!("[temperature control] {line}")))
    };
    for (name, index, label) in sensors {
        let channel = THERMISTORS[index].channel;
        let mut velvet = plan().start();
        let set = move |stopped: &mut virtual_prime::vm::Stopped<'_>| {
            let channel = Channel::new(channel).expect("a channel of the converter");
            stopped.session.board_mut().mcu.part.adc[0].set_input(channel, AT_25_C_MV);
        };
        velvet.bench.vm.with(set).expect("the run goes on");
        velvet.hear(SECOND);
        velvet.type_in("M105");
        let said = velvet.hear_until("\n", SECOND);
        for (_, _, other) in sensors {
            let at = said.find(other).unwrap_or_else(|| panic!("no {other} in {said}")) + other.len();
            let word = said[at..].split_whitespace().next().unwrap_or_default();
            let celsius = word.split('/').next().and_then(|text| text.parse::<f64>().ok());
            if other == label {
                assert!(celsius.is_some_and(|celsius| (celsius - 25.0).abs() < 0.2), "{name}: {said}");
            } else {
                assert!(celsius.is_none_or(|celsius| !(0.0..300.0).contains(&celsius)), "{name}: {said}");
            }
        }
    }
}

#[test]
fn the_supplies_are_read_at_their_own_inputs() {
    let mut velvet = Plan::new().start();
    velvet.hear(SECOND);
    let volts = |velvet: &mut Velvet, name: &str| {
        velvet.type_in(&format!("get volts {name}"));
        let said = velvet.hear_until(" v\n", SECOND);
        let text = said.rsplit(&format!("{name}: ")).next().and_then(|rest| rest.split(' ').next().map(str::to_owned));
        text.and_then(|text| text.parse::<f64>().ok()).unwrap_or_else(|| panic!("no volts in {said}"))
    };
    for (motor, fets) in [(24.0, 24.0), (18.0, 24.0), (18.0, 12.0)] {
        velvet.inject(&Fault::MotorSupply(motor));
        velvet.inject(&Fault::FetSupply(fets));
        velvet.hear(2 * SECOND);
        assert!((volts(&mut velvet, "vmotor") - motor).abs() < 0.1);
        assert!((volts(&mut velvet, "vfet") - fets).abs() < 0.1);
    }
    // The pin is checked before the load switch, which a halt opens.
    velvet.type_in("M112");
    velvet.hear(3 * SECOND);
    assert!((volts(&mut velvet, "vfet") - 12.0).abs() < 0.1);
}
