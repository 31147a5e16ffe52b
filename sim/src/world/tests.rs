//! Properties of the machine that hold after any inputs.

use proptest::prelude::*;
use units::{Actuator, Direction};

use super::*;

const MS: u64 = 1_000_000;
/// CHOPCONF with TOFF = 5, and DRVCTRL for 16 microsteps by both edges.
const CHOPPER_ON: u32 = 0x9_0135;
const DOUBLE_EDGE_16: u32 = 0x0_0104;

/// Returns a machine whose on-board drivers are set up and energised.
fn energised() -> World {
    let mut world = World::new(WorldConfig::default());
    for driver in 0..ON_BOARD_DRIVERS {
        world.driver_spi(0, driver, CHOPPER_ON);
        world.driver_spi(0, driver, DOUBLE_EDGE_16);
    }
    world.motors_disable_pin(0, false);
    world
}

/// Switches everything on: buffer, supply, the hot end's heater.
fn heating() -> World {
    let mut world = World::new(WorldConfig::default());
    world.fet_buffer_pin(0, false);
    world.fet_power_pin(0, true);
    world.heater_pin(0, 0, true);
    world
}

#[test]
fn a_motor_without_current_does_not_move_but_its_edges_are_recorded() {
    let mut world = energised();
    world.motors_disable_pin(0, true);
    world.turn(0, Actuator::Alpha, Direction::Backward);
    (1..=100).for_each(|n| world.step(n * 1_000, Actuator::Alpha));
    assert_eq!(world.carriage_mm(Actuator::Alpha), Some(30.0));
    assert_eq!(world.trace().tally(Actuator::Alpha).net_steps, -100);
}

#[test]
fn the_carriage_moves_by_the_microsteps_the_driver_is_set_to() {
    for (mres, microsteps) in [(0, 256.0), (4, 16.0), (8, 1.0)] {
        let mut world = energised();
        world.driver_spi(0, 0, 0x100 | mres);
        world.turn(0, Actuator::Alpha, Direction::Forward);
        (1..=10).for_each(|n| world.step(n * 1_000, Actuator::Alpha));
        let moved = world.carriage_mm(Actuator::Alpha).expect("a motor") - 30.0;
        assert!((moved - 10.0 * 0.2 / microsteps).abs() < 1e-12, "MRES {mres}: {moved} mm");
    }
}

#[test]
fn losing_the_motor_supply_loses_the_registers() {
    let mut world = energised();
    world.inject(&Fault::MotorSupply(0.0)).expect("every machine has one");
    assert_eq!(world.driver_spi(MS, 0, DOUBLE_EDGE_16), 0xF_FFFF, "a chip without supply does not answer");
    world.inject(&Fault::Repaired).expect("always possible");
    assert_ne!(world.driver_spi(2 * MS, 0, 0), 0xF_FFFF);
    assert!(!world.driver(0).drives() && world.driver(0).microsteps() == 256, "registers are as at power-on");
}

/// The rotor stays in its pole: at power up it goes to where counter zero holds it, two full steps at most.
#[test]
fn a_rotor_goes_to_the_nearest_place_of_counter_zero_at_power_up() {
    for (steps, way_mm) in [(0, 0.0), (16, -0.2), (31, -0.3875), (33, 0.3875), (64, 0.0), (1_000, 0.3)] {
        let mut world = energised();
        world.turn(0, Actuator::Alpha, Direction::Forward);
        (1..=steps).for_each(|n| world.step(n * 1_000, Actuator::Alpha));
        let here = world.carriage_mm(Actuator::Alpha).expect("a motor");
        let there = world.carriage_after_power_up_mm(Actuator::Alpha).expect("a motor");
        assert!((there - here - way_mm).abs() < 1e-9, "{steps} steps: {} mm", there - here);
        let cycles = (there - 30.0) / 0.8;
        assert!((cycles - cycles.round()).abs() < 1e-9, "whole cycles from where counter zero held it: {cycles}");
    }
}

#[test]
fn a_noisy_switch_closes_at_another_place_each_time() {
    let mut world = energised();
    world.make_switch_noisy("minx", 0.05).expect("a switch");
    assert!(world.make_switch_noisy("max", 0.05).is_err());
    let mut at_ns = 0;
    let mut closings: Vec<f64> = Vec::new();
    for _ in 0..5 {
        for (direction, closed) in [(Direction::Backward, true), (Direction::Forward, false)] {
            world.turn(at_ns, Actuator::Alpha, direction);
            while world.switch_high(0) != closed {
                at_ns += 1_000;
                world.step(at_ns, Actuator::Alpha);
            }
            if closed {
                closings.push(world.carriage_mm(Actuator::Alpha).expect("a motor"));
            }
        }
    }
    // The noise applies to the time behind an opening.
    assert!(closings[0].abs() < 1e-9 && closings[1..].windows(2).any(|two| two[0] != two[1]), "{closings:?}");
    assert!(closings.iter().all(|place| place.abs() < 0.3), "{closings:?}");
    world.move_switch("minx", 1.5).expect("a switch");
}

#[test]
fn the_driver_shows_its_faults_in_its_status() {
    let status = |fault: Fault| {
        let mut world = energised();
        world.inject(&fault).expect("alpha has a driver");
        world.turn(0, Actuator::Alpha, Direction::Forward);
        world.step(1_000, Actuator::Alpha);
        (world.driver_spi(2_000, 0, DOUBLE_EDGE_16) & 0xFF, world.driver(0).drives())
    };
    // STST is clear after a step. Bits: OLA 5, SHORTA 3, OTPW 2, OT 1.
    assert_eq!(status(Fault::Repaired), (0, true));
    assert_eq!(status(Fault::DriverOpenLoad(Actuator::Alpha)), (1 << 5, true));
    assert_eq!(status(Fault::DriverShort(Actuator::Alpha)), (1 << 3, false));
    assert_eq!(status(Fault::DriverTemperature(Actuator::Alpha, 125)), (1 << 2, true));
    assert_eq!(status(Fault::DriverTemperature(Actuator::Alpha, 160)), (1 << 2 | 1 << 1, false));
    assert_eq!(status(Fault::DriverSilent(Actuator::Alpha)).0, 0xFF);
}

#[test]
fn a_stuck_switch_stays_as_it_is_and_an_honest_one_tells_its_closing() {
    let approach = |fault: Option<Fault>| {
        let mut world = energised();
        fault.iter().for_each(|fault| world.inject(fault).expect("the machine has that switch"));
        world.take_switch_changes();
        world.turn(0, Actuator::Alpha, Direction::Backward);
        (1..=2_500).for_each(|n| world.step(n * 10_000, Actuator::Alpha));
        (world.switch_high(0), world.take_switch_changes())
    };
    let closing = SwitchChange { at_ns: 2_400 * 10_000, switch: 0, high: true };
    assert_eq!(approach(None), (true, vec![closing]));
    assert_eq!(approach(Some(Fault::SwitchNeverOperates("minx".into()))), (false, vec![]));
    assert_eq!(approach(Some(Fault::SwitchAlwaysOperated("minx".into()))), (true, vec![]));
}

#[test]
fn a_fault_of_something_the_machine_lacks_is_refused_by_name() {
    let mut world = energised();
    let reason = world.inject(&Fault::ThermistorOpen("chamber".into())).expect_err("there is no chamber");
    assert!(reason.contains("chamber") && reason.contains("hotend"), "{reason}");
    assert!(world.schedule(TimedFault::parse("driver-short:zeta").expect("well spelled")).is_err());
    assert!(TimedFault::parse("thermistor-open").is_err() && TimedFault::parse("motor-supply:much").is_err());
    assert_eq!(TimedFault::parse("heater-dead:bed@1.5").expect("well spelled").at_ns, 1_500 * MS);
}

#[test]
fn a_heater_settles_where_power_equals_loss() {
    let mut world = heating();
    world.heater_duty(0, 0, 0.25);
    world.advance(1_200_000 * MS);
    // 40 W at a quarter duty over 0.1 W/K of loss: 100 K above the air.
    assert!((world.heater_c(0) - 122.0).abs() < 0.1, "{}", world.heater_c(0));
}

#[test]
fn a_broken_thermistor_reads_full_scale_and_a_stuck_heater_needs_its_supply() {
    let mut world = heating();
    let input = world.config().heaters[0].sensor.expect("a thermistor");
    world.inject(&Fault::ThermistorOpen("hotend".into())).expect("there is one");
    assert_eq!(world.adc_counts(input), u16::MAX);
    world.inject(&Fault::HeaterStuckOn("hotend".into())).expect("there is one");
    world.heater_pin(0, 0, false);
    world.advance(1_000 * MS);
    let hot = world.heater_c(0);
    assert!(hot > 24.0, "the switch conducts: {hot}");
    world.fet_power_pin(1_000 * MS, false);
    world.advance(60_000 * MS);
    assert!(world.heater_c(0) < hot, "without supply even a stuck switch heats nothing");
}

/// Sheet mosfets: Q25 feeds hot ends and fans; the bed's connectors lie before it.
#[test]
fn the_load_switch_feeds_hot_ends_and_fans_and_not_the_bed() {
    let heated = |name: &str, switch_on: bool, buffer_on: bool, stuck: bool| {
        let mut world = World::new(WorldConfig::default());
        world.fet_buffer_pin(0, !buffer_on);
        world.fet_power_pin(0, switch_on);
        let index = world.heater_index(name).expect("there is one");
        if stuck {
            world.inject(&Fault::HeaterStuckOn(name.into())).expect("there is one");
        } else {
            world.heater_pin(0, index, true);
        }
        world.advance(10_000 * MS);
        world.heater_c(index) > 22.5
    };
    // Name, load switch, buffer, shorted MOSFET, whether it heats.
    let cases = [
        ("hotend", true, true, false, true),
        ("hotend", false, true, false, false),
        ("hotend", true, false, false, false),
        ("hotend", true, false, true, true),
        ("hotend", false, false, true, false),
        ("bed", true, true, false, true),
        ("bed", false, true, false, true),
        ("bed", true, false, false, false),
        ("bed", false, false, true, true),
    ];
    for (name, switch_on, buffer_on, stuck, expected) in cases {
        let heats = heated(name, switch_on, buffer_on, stuck);
        assert_eq!(heats, expected, "{name}, load switch {switch_on}, buffer {buffer_on}, shorted {stuck}");
    }
}

#[test]
fn the_heaters_supply_is_measured_before_the_load_switch() {
    let mut world = World::new(WorldConfig::default());
    let volts = |world: &World| world.analog_volts(VFET_INPUT).expect("a monitor") * 11.0;
    assert!((volts(&world) - 24.0).abs() < 1e-9 && world.vfet_v() == 0.0);
    world.fet_power_pin(0, true);
    assert!((volts(&world) - 24.0).abs() < 1e-9 && world.vfet_v() == 24.0);
    world.inject(&Fault::FetSupply(0.0)).expect("every machine has one");
    assert_eq!(volts(&world), 0.0);
}

#[test]
fn a_scheduled_fault_comes_at_its_time() {
    let mut world = heating();
    let input = world.config().heaters[0].sensor.expect("a thermistor");
    world.schedule(TimedFault::parse("thermistor-short:hotend@0.05").expect("well spelled")).expect("there is one");
    world.advance(49 * MS);
    assert!(world.adc_counts(input) > 0);
    world.advance(50 * MS);
    assert_eq!(world.adc_counts(input), 0);
}

proptest! {
    /// Physics runs on its own grid: questions for the time, however frequent, change nothing.
    #[test]
    fn how_often_time_is_asked_for_changes_nothing(cuts in proptest::collection::vec(1_u64..200 * MS, 0..40)) {
        let end = 2_000 * MS;
        let mut whole = heating();
        whole.advance(end);
        let mut cut = heating();
        let mut at = 0;
        for step in cuts {
            at = (at + step).min(end);
            cut.advance(at);
        }
        cut.advance(end);
        prop_assert_eq!(whole.heater_c(0).to_bits(), cut.heater_c(0).to_bits());
    }

    /// As many steps forward as backward end where they began, whatever the order, unless a stop is met.
    #[test]
    fn steps_out_and_back_cancel(directions in proptest::collection::vec(any::<bool>(), 1..400)) {
        let mut world = energised();
        let mut at = 1_000;
        let back: Vec<bool> = directions.iter().map(|forward| !forward).collect();
        for forward in directions.into_iter().chain(back) {
            let direction = if forward { Direction::Forward } else { Direction::Backward };
            world.turn(at, Actuator::Beta, direction);
            world.step(at + 500, Actuator::Beta);
            at += 1_000;
        }
        prop_assert_eq!(world.carriage_mm(Actuator::Beta), Some(40.0));
        prop_assert_eq!(world.trace().tally(Actuator::Beta).net_steps, 0);
        prop_assert_eq!(world.timing_faults(), 0);
    }

    /// The fault parser answers any text, and does nothing else.
    #[test]
    fn any_text_is_a_fault_or_a_reason(text in ".{0,40}") {
        if let Err(reason) = TimedFault::parse(&text) {
            prop_assert!(reason.starts_with("fault `"));
        }
    }
}

/// The configuration's pin for the stall output of a driver is the pin of the schematic.
#[test]
fn stall_outputs_lead_where_the_schematic_has_them() {
    let mut text = include_str!("../../../config/samples/cartesian.ini").to_owned();
    for motor in Actuator::ALL.into_iter().take(ON_BOARD_DRIVERS) {
        let change = format!("{}.stall_watch", motor.name());
        let edit = ::config::edit::Edit { section: "tmc2590", key: &change, value: Some("true") };
        text = ::config::edit::apply(&text, edit);
    }
    let (machine, _) = ::config::parse(text.as_bytes(), ::config::BoardId::Prime2590, &mut ());
    let watched: Vec<_> = machine.watched_for_stalls().collect();
    assert!(watched.len() >= 3, "{watched:?}");
    for (motor, input) in watched {
        let socket = &board_facts::wiring::DRIVERS[motor as usize];
        assert_eq!(Pin::parse(socket.stall), Some(Pin { port: input.port, number: input.number }), "{}", motor.name());
    }
    let world = WorldConfig::of(&machine, crate::models::tmc26x::Chip::Tmc2590);
    let stalls = world.switches.iter().filter(|switch| matches!(switch.operator, Some((Operator::Stall(_), ..))));
    assert!(stalls.count() >= 3, "the modelled board leads them there too");
}
