//! Slow watch over motor drivers and their supply, run by the slow task.
//!
//! Once a second every internal driver's status is read over SPI; a fault counts when seen twice in a row, so
//! a disturbed datagram alarms nobody. A driver that has lost its settings is believed at once, for a reset
//! is only reported after a second question: the driver is set up again. Motor supply below
//! [`MOTOR_SUPPLY_OFF`] is "off": drivers lose their registers with it, so they are written anew when it
//! returns. The supply of heaters and fans lies behind a switch of the board; it is judged only while that
//! switch is on. Findings wait here as events for the executor.

mod event;
mod trouble;

use events::EventRing;
use heapless::Deque;
use units::{Actuator, Micros, PerActuator, Volts};

use crate::ports::{DriverFault, DriverStatus, MotorDrivers, SupplyVoltages};
pub use event::SupervisorEvent;
pub use trouble::DriverTrouble;

/// Voltage below which the motor supply counts as switched off.
pub const MOTOR_SUPPLY_OFF: Volts = Volts(6.0);
/// Voltage below which the supply of heaters and fans counts as switched off.
pub const FET_SUPPLY_OFF: Volts = Volts(6.0);
/// Time between status reads.
const POLL_PERIOD: Micros = Micros::from_seconds(1);
/// Events that can wait for the executor: every kind for every motor.
const EVENTS: usize = 32;

#[derive(Clone, Copy, Debug, Default)]
struct Watch {
    /// Troubles in the last poll.
    seen: u16,
    /// Troubles that have been reported.
    reported: u16,
    /// Polls in a row, of those in slow motion, in which coil A and coil B were open.
    open: [u8; 2],
    /// Polls in a row without the temperature warning.
    cooler: u8,
}

impl Watch {
    /// Counts a poll in slow motion. Returns the coils that have been open for long enough.
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

/// State of the supply of heaters and fans.
#[derive(Clone, Copy, Debug, Default)]
struct FetWatch {
    /// Whether the switch of this supply is on.
    expected: bool,
    /// Whether the supply was missing at the last poll.
    missing: bool,
    /// Whether the missing supply has been reported.
    reported: bool,
}

/// Access to the watch over drivers and supplies.
pub trait SupervisorPort {
    /// Calls `f` with the findings of the slow task (driver faults, supply voltages), locked for that long.
    fn supervisor<R>(&mut self, f: impl FnOnce(&mut Supervisor) -> R) -> R;
}

/// State of the slow task.
#[derive(Debug)]
pub struct Supervisor {
    /// Motors with drivers on the board, one bit each: they live on the motor supply.
    on_board: u8,
    /// Motors with external drivers that can be asked, which have a supply of their own.
    outside: u8,
    /// External drivers yet to be asked in this period: one each tick, for they take longer.
    to_ask: u8,
    check_drivers: bool,
    watches: PerActuator<Watch>,
    supply_on: Option<bool>,
    fets: FetWatch,
    due: Micros,
    /// Motors that turn slowly, one bit each, and the time of this finding.
    slow: (u8, Micros),
    events: Deque<SupervisorEvent, EVENTS>,
}

impl Default for Supervisor {
    fn default() -> Self {
        Self::new()
    }
}

impl Supervisor {
    /// Starts with nothing to watch.
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

    /// Sets which motors (one bit each) have drivers on the board, which have external drivers that can be
    /// asked, and whether their status is watched.
    pub fn configure(&mut self, on_board: u8, outside: u8, check_drivers: bool) {
        self.on_board = on_board;
        self.outside = outside;
        self.check_drivers = check_drivers;
    }

    /// Returns whether the motor supply is there. Unknown, before the first reading or without a monitor,
    /// counts as there.
    #[must_use]
    pub fn motor_supply_on(&self) -> bool {
        self.supply_on.unwrap_or(true)
    }

    /// Sets whether the switch of the supply of heaters and fans is on.
    pub fn expect_fet_supply(&mut self, expected: bool) {
        self.fets = FetWatch { expected, ..FetWatch::default() };
    }

    /// Returns whether the supply of heaters and fans is there. The supply counts as there until it has been
    /// missed twice in a row, which leaves it time to rise.
    #[must_use]
    pub fn fet_supply_on(&self) -> bool {
        !self.fets.reported
    }

    /// Notes that the motor supply is off, as a faster watch has found and reported. Drivers are set up when
    /// the supply comes back.
    pub const fn motor_supply_is_lost(&mut self) {
        self.supply_on = Some(false);
    }

    /// Notes the same of the supply of heaters and fans.
    pub const fn fet_supply_is_lost(&mut self) {
        (self.fets.missing, self.fets.reported) = (true, true);
    }

    /// Notes the motors, one bit each, that turn slowly and steadily now: whether a coil is open can be seen.
    pub fn set_slow(&mut self, motors: u8, now: Micros) {
        self.slow = (motors, now);
    }

    /// Marks a trouble as reported already; it is news again only after it has gone.
    pub fn mark_told(&mut self, motor: Actuator, trouble: DriverTrouble) {
        let watch = &mut self.watches[motor];
        watch.seen |= trouble.bit();
        watch.reported |= trouble.bit();
    }

    /// Makes all reported troubles of a driver news again.
    pub fn forget_told(&mut self, motor: Actuator) {
        self.watches[motor] = Watch::default();
    }

    /// Takes the next event.
    pub fn take_event(&mut self) -> Option<SupervisorEvent> {
        self.events.pop_front()
    }

    /// Does the slow task's work; to be called at 10 Hz, so that every driver is asked once a second. Worst
    /// cost: one status datagram for each driver on the board, and seven, or writing all registers, for an
    /// external one.
    pub fn tick(
        &mut self,
        now: Micros,
        drivers: &mut impl MotorDrivers,
        supply: SupplyVoltages,
        events: EventRing<'_>,
    ) {
        let waiting = self.events.len();
        self.look(now, drivers, supply);
        // Recorded before the executor hears of the event, for it may never do.
        self.events.iter().skip(waiting).for_each(|news| events.record(now, &news.told()));
    }

    fn look(&mut self, now: Micros, drivers: &mut impl MotorDrivers, supply: SupplyVoltages) {
        let slow = if now.since(self.slow.1) <= SLOW_HOLDS { self.slow.0 } else { 0 };
        if now < self.due {
            return self.ask_outside(drivers, slow);
        }
        self.due = now.plus(POLL_PERIOD);
        self.watch_supply(drivers, supply);
        self.watch_fet_supply(supply);
        if self.check_drivers && self.motor_supply_on() {
            for motor in Actuator::of_bits(self.on_board) {
                self.ask(motor, drivers, slow);
            }
        }
        self.to_ask = if self.check_drivers { self.outside } else { 0 };
        self.ask_outside(drivers, slow);
    }

    /// Asks the next external driver.
    fn ask_outside(&mut self, drivers: &mut impl MotorDrivers, slow: u8) {
        let Some(motor) = Actuator::of_bits(self.to_ask).next() else { return };
        self.to_ask &= !motor.bit();
        self.ask(motor, drivers, slow);
    }

    /// Asks a driver for its status. A driver that was without power is set up again, and is off.
    fn ask(&mut self, motor: Actuator, drivers: &mut impl MotorDrivers, slow: u8) {
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
                for motor in Actuator::of_bits(self.on_board) {
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
            // In fast motion and at standstill the bits say nothing, for or against.
            _ => watch.reported & OPEN,
        };
        let now_seen = troubles(status);
        let confirmed = now_seen & (watch.seen | AT_ONCE) | open;
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
        // An executor that does not fetch 32 events is dead, and the watchdog will say so; nothing is lost
        // by dropping.
        let _ = self.events.push_back(event);
    }
}

/// Polls in a row without the temperature warning after which it is news again.
const COOL_POLLS: u8 = 30;
/// Troubles that count when seen once.
const AT_ONCE: u16 = DriverTrouble::Reset.bit();
const WARM: u16 = DriverTrouble::OverTemperatureWarning.bit();
/// Polls in a row in slow motion that must agree that a coil is open.
const OPEN_POLLS: u8 = 3;
/// Time for which motors that turned slowly count as doing so.
const SLOW_HOLDS: Micros = Micros::from_millis(250);
const OPEN: u16 = DriverTrouble::OpenA.bit() | DriverTrouble::OpenB.bit();

fn troubles(status: Result<DriverStatus, DriverFault>) -> u16 {
    let status = match status {
        Ok(status) => status,
        Err(DriverFault::External) => return 0,
        Err(DriverFault::Reset) => return DriverTrouble::Reset.bit(),
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
mod tests;
