//! The slow watch over motor drivers and their supply, run by the slow task.
//!
//! Once a second every internal driver's status is read over SPI; a fault counts when it is seen twice in a
//! row, so a disturbed datagram alarms nobody. Motor supply below [`MOTOR_SUPPLY_OFF`] is "off": drivers lose
//! their registers with it, so they are written anew when it returns. The supply of heaters and fans lies
//! behind a switch of the board; it is judged only while that switch is on. What is found waits here as
//! events for the dispatcher.

mod trouble;

use heapless::Deque;
use units::{Actuator, Micros, PerActuator, Volts};

use crate::axes::motors;
use crate::ports::{DriverFault, DriverStatus, MotorDrivers, SupplyVoltages};
pub use trouble::DriverTrouble;

/// Below this the motor supply counts as switched off.
pub const MOTOR_SUPPLY_OFF: Volts = Volts(6.0);
/// Below this the supply of heaters and fans counts as switched off.
pub const FET_SUPPLY_OFF: Volts = Volts(6.0);
/// Time between status reads.
const POLL_PERIOD: Micros = Micros::from_seconds(1);
/// Events that can wait for the dispatcher: every kind for every motor.
const EVENTS: usize = 32;

/// Something the dispatcher must hear of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SupervisorEvent {
    /// A driver reported trouble twice.
    Driver(Actuator, DriverTrouble),
    /// Motor supply went below [`MOTOR_SUPPLY_OFF`].
    MotorSupplyLost,
    /// Motor supply came back; drivers have been initialised again.
    MotorSupplyReturned,
    /// The supply of heaters and fans is below [`FET_SUPPLY_OFF`] though its switch is on.
    FetSupplyLost,
    /// The supply of heaters and fans came back.
    FetSupplyReturned,
}

#[derive(Clone, Copy, Debug, Default)]
struct Watch {
    /// Troubles in the last poll.
    seen: u16,
    /// Troubles already reported.
    reported: u16,
    /// Polls in a row, of those in slow motion, in which coil A and coil B were open.
    open: [u8; 2],
    /// Polls in a row without the temperature warning.
    cooler: u8,
}

impl Watch {
    /// One poll in slow motion; what has been open for long enough.
    fn count_open(&mut self, open: [bool; 2]) -> u16 {
        let mut found = 0;
        for ((count, open), trouble) in self.open.iter_mut().zip(open).zip([DriverTrouble::OpenA, DriverTrouble::OpenB])
        {
            *count = if open { count.saturating_add(1) } else { 0 };
            if *count >= OPEN_POLLS {
                found |= trouble.bit();
            }
        }
        found
    }
}

/// What is known of the supply of heaters and fans.
#[derive(Clone, Copy, Debug, Default)]
struct FetWatch {
    /// Its switch is on.
    expected: bool,
    /// It was missing at the last poll.
    missing: bool,
    /// That has been reported.
    reported: bool,
}

/// The slow task's state.
#[derive(Debug)]
pub struct Supervisor {
    /// Motors with drivers on the board, one bit each: they live on the motor supply.
    on_board: u8,
    /// Motors with drivers outside that can be asked, which have a supply of their own.
    outside: u8,
    /// Those of them that are yet to be asked in this period: one each tick, for they take longer.
    to_ask: u8,
    check_drivers: bool,
    watches: PerActuator<Watch>,
    supply_on: Option<bool>,
    fets: FetWatch,
    due: Micros,
    /// Motors that turn slowly, one bit each, and when that was.
    slow: (u8, Micros),
    events: Deque<SupervisorEvent, EVENTS>,
}

impl Default for Supervisor {
    fn default() -> Self {
        Self::new()
    }
}

impl Supervisor {
    /// Watches nothing yet.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            on_board: 0,
            outside: 0,
            to_ask: 0,
            check_drivers: false,
            watches: PerActuator([Watch { seen: 0, reported: 0, open: [0; 2], cooler: 0 }; units::MAX_ACTUATORS]),
            supply_on: None,
            fets: FetWatch { expected: false, missing: false, reported: false },
            due: Micros(0),
            slow: (0, Micros(0)),
            events: Deque::new(),
        }
    }

    /// Sets which motors (one bit each) have drivers on the board, which have drivers outside that can be
    /// asked, and whether their status is watched.
    pub fn configure(&mut self, on_board: u8, outside: u8, check_drivers: bool) {
        self.on_board = on_board;
        self.outside = outside;
        self.check_drivers = check_drivers;
    }

    /// Is the motor supply there? Unknown, before the first reading or without a monitor, counts as there.
    #[must_use]
    pub fn motor_supply_on(&self) -> bool {
        self.supply_on.unwrap_or(true)
    }

    /// Tells whether the switch of the supply of heaters and fans is on.
    pub fn expect_fet_supply(&mut self, expected: bool) {
        self.fets = FetWatch { expected, ..FetWatch::default() };
    }

    /// Is the supply of heaters and fans there? Counts as there until it has been missed twice in a row,
    /// which leaves it time to rise.
    #[must_use]
    pub fn fet_supply_on(&self) -> bool {
        !self.fets.reported
    }

    /// The motor supply was found off by somebody who looks oftener, and told. When it comes back, drivers are set
    /// up.
    pub const fn motor_supply_is_lost(&mut self) {
        self.supply_on = Some(false);
    }

    /// The same for the supply of heaters and fans.
    pub const fn fet_supply_is_lost(&mut self) {
        (self.fets.missing, self.fets.reported) = (true, true);
    }

    /// These motors, one bit each, turn slowly and steadily now: whether a coil is open can be seen.
    pub fn set_slow(&mut self, motors: u8, now: Micros) {
        self.slow = (motors, now);
    }

    /// This trouble has been told already; it is news again only after it has gone.
    pub fn mark_told(&mut self, motor: Actuator, trouble: DriverTrouble) {
        let watch = &mut self.watches[motor];
        watch.seen |= trouble.bit();
        watch.reported |= trouble.bit();
    }

    /// The next event.
    pub fn take_event(&mut self) -> Option<SupervisorEvent> {
        self.events.pop_front()
    }

    /// The slow task's body; call at 10 Hz, so that every driver is asked once a second. Worst cost: one
    /// status datagram for each driver on the board, and seven, or writing all registers, for one outside.
    pub fn tick(&mut self, now: Micros, drivers: &mut impl MotorDrivers, supply: SupplyVoltages) {
        let slow = if now.since(self.slow.1) <= SLOW_HOLDS { self.slow.0 } else { 0 };
        if now < self.due {
            return self.ask_outside(drivers, slow);
        }
        self.due = now.plus(POLL_PERIOD);
        self.watch_supply(drivers, supply);
        self.watch_fet_supply(supply);
        if self.check_drivers && self.motor_supply_on() {
            for motor in motors(self.on_board) {
                self.watch_driver(motor, drivers.status(motor), slow & motor.bit() != 0);
            }
        }
        self.to_ask = if self.check_drivers { self.outside } else { 0 };
        self.ask_outside(drivers, slow);
    }

    /// The next driver outside. One that was without power is set up again, and is off.
    fn ask_outside(&mut self, drivers: &mut impl MotorDrivers, slow: u8) {
        let Some(motor) = motors(self.to_ask).next() else { return };
        self.to_ask &= !motor.bit();
        self.watch_driver(motor, drivers.status(motor), slow & motor.bit() != 0);
        if self.watches[motor].reported & DriverTrouble::Reset.bit() != 0 {
            // If it fails, its silence or another reset shows at the next poll.
            let _ = drivers.initialise(motor);
        }
    }

    fn watch_supply(&mut self, drivers: &mut impl MotorDrivers, supply: SupplyVoltages) {
        let Some(volts) = supply.motor else { return };
        let is_on = volts >= MOTOR_SUPPLY_OFF;
        let was_on = self.supply_on.replace(is_on);
        match (was_on, is_on) {
            (Some(true) | None, false) => self.report(SupervisorEvent::MotorSupplyLost),
            (Some(false), true) => {
                for motor in motors(self.on_board) {
                    if drivers.initialise(motor).is_err() {
                        self.report(SupervisorEvent::Driver(motor, DriverTrouble::Silent));
                    }
                }
                self.report(SupervisorEvent::MotorSupplyReturned);
            }
            _ => {}
        }
    }

    fn watch_fet_supply(&mut self, supply: SupplyVoltages) {
        let Some(volts) = supply.fets.filter(|_| self.fets.expected) else { return };
        let was_missing = core::mem::replace(&mut self.fets.missing, volts < FET_SUPPLY_OFF);
        if was_missing && self.fets.missing && !self.fets.reported {
            self.fets.reported = true;
            self.report(SupervisorEvent::FetSupplyLost);
        } else if self.fets.reported && !self.fets.missing {
            self.fets.reported = false;
            self.report(SupervisorEvent::FetSupplyReturned);
        }
    }

    fn watch_driver(&mut self, motor: Actuator, status: Result<DriverStatus, DriverFault>, is_slow: bool) {
        let watch = &mut self.watches[motor];
        let open = match status {
            Ok(status) if is_slow => watch.count_open([status.open_a, status.open_b]),
            // In fast motion and at standstill it says nothing, for or against.
            _ => watch.reported & OPEN,
        };
        let now_seen = troubles(status);
        let confirmed = now_seen & watch.seen | open;
        let fresh = confirmed & !watch.reported;
        watch.seen = now_seen;
        watch.cooler = if now_seen & WARM != 0 { 0 } else { watch.cooler.saturating_add(1) };
        // A temperature that sways about the limit is told once.
        let stays = now_seen | if watch.cooler < COOL_POLLS { WARM } else { 0 };
        watch.reported = (watch.reported & stays) | confirmed;
        for trouble in DriverTrouble::ALL {
            if fresh & trouble.bit() != 0 {
                self.report(SupervisorEvent::Driver(motor, trouble));
            }
        }
    }

    fn report(&mut self, event: SupervisorEvent) {
        // A dispatcher that does not fetch 32 events is dead, and the watchdog will say so; nothing is lost
        // by dropping.
        let _ = self.events.push_back(event);
    }
}

/// Polls in a row without the temperature warning after which it is news again.
const COOL_POLLS: u8 = 30;
const WARM: u16 = DriverTrouble::OverTemperatureWarning.bit();
/// Polls in a row in slow motion that must agree that a coil is open.
const OPEN_POLLS: u8 = 3;
/// How long motors that turned slowly count as doing so.
const SLOW_HOLDS: Micros = Micros::from_millis(250);
const OPEN: u16 = DriverTrouble::OpenA.bit() | DriverTrouble::OpenB.bit();

fn troubles(status: Result<DriverStatus, DriverFault>) -> u16 {
    let status = match status {
        Ok(status) => status,
        Err(DriverFault::External) => return 0,
        Err(DriverFault::Silent | DriverFault::BadAnswer | DriverFault::BadSetting) => {
            return DriverTrouble::Silent.bit();
        }
    };
    let flags = [
        (status.over_temperature_warning, DriverTrouble::OverTemperatureWarning),
        (status.over_temperature, DriverTrouble::OverTemperature),
        (status.short_a, DriverTrouble::ShortA),
        (status.short_b, DriverTrouble::ShortB),
        (status.supply_short_a, DriverTrouble::SupplyShortA),
        (status.supply_short_b, DriverTrouble::SupplyShortB),
        (status.reset, DriverTrouble::Reset),
    ];
    flags.into_iter().filter(|(set, _)| *set).fold(0, |bits, (_, trouble)| bits | trouble.bit())
}

#[cfg(test)]
mod tests {
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
            supervisor.tick(Micros::from_seconds(second as u64), &mut drivers, SUPPLIED);
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
            // Two seconds over the limit, five below, and a long rest in between.
            let over_temperature_warning = !(70..150).contains(&second) && second % 7 < 2;
            drivers.status = Ok(DriverStatus { over_temperature_warning, ..DriverStatus::default() });
            supervisor.tick(Micros::from_seconds(second), &mut drivers, SUPPLIED);
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
        let course =
            course.into_iter().chain([(stands, open), (slow, open), (stands, sound), (slow, open), (slow, open)]);
        let mut told = Vec::new();
        for (second, (slow, status)) in course.enumerate() {
            let now = Micros::from_seconds(second as u64);
            drivers.status = Ok(status);
            supervisor.set_slow(slow, now);
            supervisor.tick(now, &mut drivers, SUPPLIED);
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
        // The supply of the board is not theirs.
        let supply = SupplyVoltages { motor: Some(Volts(0.5)), fets: None };
        let mut set_up = Vec::new();
        for tick in 0..20 {
            supervisor.tick(Micros::from_millis(tick * 100), &mut drivers, supply);
            set_up.push(drivers.initialised);
        }
        // Seen twice, the second time in the second second.
        let expected = (0..20).map(|tick| if tick < 10 { 0 } else { (tick - 9).min(2) });
        assert_eq!(set_up, expected.collect::<Vec<_>>());
        let told: Vec<_> = core::iter::from_fn(|| supervisor.take_event()).skip(1).collect();
        let reset = |motor| SupervisorEvent::Driver(motor, DriverTrouble::Reset);
        assert_eq!(told, [reset(Actuator::Delta), reset(Actuator::Epsilon)]);
    }

    #[test]
    fn losing_and_regaining_motor_supply_initialises_the_drivers_again() {
        let (mut supervisor, mut drivers) = bench();
        for (second, volts) in [24.0, 2.0, 2.0, 24.0].into_iter().enumerate() {
            let supply = SupplyVoltages { motor: Some(Volts(volts)), fets: None };
            supervisor.tick(Micros::from_seconds(second as u64), &mut drivers, supply);
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
            // The switch goes on after the first poll.
            if second == 1 {
                supervisor.expect_fet_supply(true);
            }
            let supply = SupplyVoltages { motor: None, fets: Some(Volts(volts)) };
            supervisor.tick(Micros::from_seconds(second as u64), &mut drivers, supply);
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
            supervisor.tick(Micros::from_seconds(second), &mut drivers, SUPPLIED);
        }
        assert_eq!(supervisor.take_event(), None);
    }

    #[test]
    fn without_supply_the_silence_of_drivers_is_no_news() {
        let (mut supervisor, mut drivers) = bench();
        drivers.status = Err(DriverFault::Silent);
        for second in 0..5 {
            let supply = SupplyVoltages { motor: Some(Volts(0.5)), fets: None };
            supervisor.tick(Micros::from_seconds(second), &mut drivers, supply);
        }
        assert_eq!(supervisor.take_event(), Some(SupervisorEvent::MotorSupplyLost));
        assert_eq!(supervisor.take_event(), None);
    }
}
