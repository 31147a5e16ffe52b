//! The watch over drivers and supplies, against drivers whose answers a test writes.

use super::*;
use units::Amps;

/// Drivers whose answers a test writes.
struct Bench {
    status: Result<DriverStatus, DriverFault>,
    initialised: u32,
}

impl MotorDrivers for Bench {
    fn initialise(&mut self, _: Actuator) -> Result<(), DriverFault> {
        self.initialised += 1;
        Ok(())
    }
    fn set_enabled(&mut self, _: Actuator, _: bool) -> Result<(), DriverFault> {
        Ok(())
    }
    fn set_current(&mut self, _: Actuator, peak: Amps) -> Result<Amps, DriverFault> {
        Ok(peak)
    }
    fn current(&self, _: Actuator) -> Option<Amps> {
        None
    }
    fn status(&mut self, _: Actuator) -> Result<DriverStatus, DriverFault> {
        self.status
    }
    fn phase(&mut self, _: Actuator) -> Result<crate::ports::ElectricalPhase, DriverFault> {
        Err(DriverFault::Silent)
    }
    fn begin_stall_search(&mut self, _: Actuator, _: crate::ports::StallSearch) -> Result<(), DriverFault> {
        Ok(())
    }
    fn reserve(&mut self, _: Actuator) -> Result<u16, DriverFault> {
        Err(DriverFault::Silent)
    }
    fn end_stall_search(&mut self, _: Actuator) -> Result<(), DriverFault> {
        Ok(())
    }
    fn describe(
        &mut self,
        _: Actuator,
        _: crate::ports::Description,
        _: &mut dyn core::fmt::Write,
    ) -> core::fmt::Result {
        Ok(())
    }
    fn fit_chopper(
        &mut self,
        _: Actuator,
        _: crate::ports::Coil,
        _: Volts,
    ) -> Result<Option<crate::ports::ChopperFit>, DriverFault> {
        Ok(None)
    }
    fn set_stealth_threshold(&mut self, _: Actuator, _: Option<f32>) -> Result<(), DriverFault> {
        Err(DriverFault::External)
    }
    fn set_microsteps(&mut self, _: Actuator, count: u16) -> Result<u16, DriverFault> {
        Ok(count)
    }
    fn write_register(&mut self, _: Actuator, _: u8, _: u32) -> Result<(), DriverFault> {
        Ok(())
    }
    fn set_option(&mut self, _: Actuator, _: u8, _: &dyn Fn(char) -> Option<f64>) -> Result<(), DriverFault> {
        Ok(())
    }
}

const SUPPLIED: SupplyVoltages = SupplyVoltages { motor: Some(Volts(24.0)), fets: None };

fn bench() -> (Supervisor, Bench) {
    let mut supervisor = Supervisor::new();
    supervisor.configure(Actuator::Beta.bit(), 0, true);
    (supervisor, Bench { status: Ok(DriverStatus::default()), initialised: 0 })
}

#[test]
fn a_fault_counts_when_seen_twice_and_is_told_once() {
    let (mut supervisor, mut drivers) = bench();
    let shorted = Ok(DriverStatus { short_a: true, ..DriverStatus::default() });
    let course = [shorted, Ok(DriverStatus::default()), shorted, shorted, shorted];
    let mut reported = [0; 5];
    for (second, status) in course.into_iter().enumerate() {
        drivers.status = status;
        supervisor.look(Micros::from_seconds(second as u64), &mut drivers, SUPPLIED);
        while let Some(event) = supervisor.take_event() {
            assert_eq!(event, SupervisorEvent::Driver(Actuator::Beta, DriverTrouble::ShortA));
            reported[second] += 1;
        }
    }
    assert_eq!(reported, [0, 0, 0, 1, 0]);
}

#[test]
fn a_driver_that_sways_about_its_limit_is_told_once_and_again_when_it_has_cooled() {
    let (mut supervisor, mut drivers) = bench();
    let mut told = Vec::new();
    for second in 0..200 {
        // A warning lasts two seconds over the limit, then five below, with a long rest in between.
        let over_temperature_warning = !(70..150).contains(&second) && second % 7 < 2;
        drivers.status = Ok(DriverStatus { over_temperature_warning, ..DriverStatus::default() });
        supervisor.look(Micros::from_seconds(second), &mut drivers, SUPPLIED);
        while let Some(event) = supervisor.take_event() {
            assert_eq!(event, SupervisorEvent::Driver(Actuator::Beta, DriverTrouble::OverTemperatureWarning));
            told.push(second);
        }
    }
    assert_eq!(told, [1, 155], "{told:?}");
}

#[test]
fn an_open_coil_is_told_after_three_polls_in_slow_motion_and_no_others_count() {
    let (mut supervisor, mut drivers) = bench();
    let (open, sound) = (DriverStatus { open_b: true, ..DriverStatus::default() }, DriverStatus::default());
    // Standing, fast, slow and open twice, slow and sound; then slow and open, with pauses.
    let (stands, slow) = (0, Actuator::Beta.bit());
    let course = [(stands, open), (stands, open), (slow, open), (slow, open), (slow, sound), (slow, open)];
    let course = course.into_iter().chain([(stands, open), (slow, open), (stands, sound), (slow, open), (slow, open)]);
    let mut told = Vec::new();
    for (second, (slow, status)) in course.enumerate() {
        let now = Micros::from_seconds(second as u64);
        drivers.status = Ok(status);
        supervisor.set_slow(slow, now);
        supervisor.look(now, &mut drivers, SUPPLIED);
        told.extend(supervisor.take_event().map(|event| (second, event)));
    }
    assert_eq!(told, [(9, SupervisorEvent::Driver(Actuator::Beta, DriverTrouble::OpenB))]);
}

#[test]
fn drivers_outside_are_asked_one_at_a_tick_and_set_up_again_after_a_reset() {
    let (mut supervisor, mut drivers) = bench();
    let outside = Actuator::Delta.bit() | Actuator::Epsilon.bit();
    supervisor.configure(0, outside, true);
    drivers.status = Ok(DriverStatus { reset: true, ..DriverStatus::default() });
    // The supply of the board does not feed these external drivers.
    let supply = SupplyVoltages { motor: Some(Volts(0.5)), fets: None };
    let mut set_up = Vec::new();
    for tick in 0..20 {
        supervisor.look(Micros::from_millis(tick * 100), &mut drivers, supply);
        set_up.push(drivers.initialised);
    }
    // Both drivers are set up in each second, as the run goes on.
    let expected = (0..20).map(|tick| if tick < 10 { (tick + 1).min(2) } else { (tick - 7).min(4) });
    assert_eq!(set_up, expected.collect::<Vec<_>>());
    let told: Vec<_> = core::iter::from_fn(|| supervisor.take_event()).skip(1).collect();
    let reset = |motor| SupervisorEvent::Driver(motor, DriverTrouble::Reset);
    assert_eq!(told, [reset(Actuator::Delta), reset(Actuator::Epsilon)]);
}

#[test]
fn a_driver_on_the_board_that_has_lost_its_settings_is_believed_at_once_and_set_up_again() {
    let (mut supervisor, mut drivers) = bench();
    let course = [Ok(DriverStatus::default()), Err(DriverFault::Reset), Ok(DriverStatus::default())];
    let mut seen = Vec::new();
    for (second, status) in course.into_iter().enumerate() {
        drivers.status = status;
        supervisor.look(Micros::from_seconds(second as u64), &mut drivers, SUPPLIED);
        seen.push((drivers.initialised, supervisor.take_event()));
    }
    let told = SupervisorEvent::Driver(Actuator::Beta, DriverTrouble::Reset);
    assert_eq!(seen, [(0, None), (1, Some(told)), (1, None)]);
}

#[test]
fn losing_and_regaining_motor_supply_initialises_the_drivers_again() {
    let (mut supervisor, mut drivers) = bench();
    for (second, volts) in [24.0, 2.0, 2.0, 24.0].into_iter().enumerate() {
        let supply = SupplyVoltages { motor: Some(Volts(volts)), fets: None };
        supervisor.look(Micros::from_seconds(second as u64), &mut drivers, supply);
    }
    assert_eq!(supervisor.take_event(), Some(SupervisorEvent::MotorSupplyLost));
    assert_eq!(supervisor.take_event(), Some(SupervisorEvent::MotorSupplyReturned));
    assert_eq!(supervisor.take_event(), None);
    assert_eq!(drivers.initialised, 1);
}

#[test]
fn the_heaters_supply_is_missed_once_and_only_while_its_switch_is_on() {
    let (mut supervisor, mut drivers) = bench();
    let mut reported = Vec::new();
    for (second, volts) in [0.0, 0.0, 0.0, 0.0, 24.0, 0.0, 24.0].into_iter().enumerate() {
        // The supply switch goes on after the first poll.
        if second == 1 {
            supervisor.expect_fet_supply(true);
        }
        let supply = SupplyVoltages { motor: None, fets: Some(Volts(volts)) };
        supervisor.look(Micros::from_seconds(second as u64), &mut drivers, supply);
        reported.extend(supervisor.take_event().map(|event| (second, event)));
    }
    assert_eq!(reported, [(2, SupervisorEvent::FetSupplyLost), (4, SupervisorEvent::FetSupplyReturned)]);
}

#[test]
fn trouble_that_was_told_at_boot_is_no_news() {
    let (mut supervisor, mut drivers) = bench();
    drivers.status = Err(DriverFault::Silent);
    supervisor.mark_told(Actuator::Beta, DriverTrouble::Silent);
    for second in 0..5 {
        supervisor.look(Micros::from_seconds(second), &mut drivers, SUPPLIED);
    }
    assert_eq!(supervisor.take_event(), None);
}

#[test]
fn without_supply_the_silence_of_drivers_is_no_news() {
    let (mut supervisor, mut drivers) = bench();
    drivers.status = Err(DriverFault::Silent);
    for second in 0..5 {
        let supply = SupplyVoltages { motor: Some(Volts(0.5)), fets: None };
        supervisor.look(Micros::from_seconds(second), &mut drivers, supply);
    }
    assert_eq!(supervisor.take_event(), Some(SupervisorEvent::MotorSupplyLost));
    assert_eq!(supervisor.take_event(), None);
}
