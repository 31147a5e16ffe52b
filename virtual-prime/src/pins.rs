//! Roles of the microcontroller's pins on the Prime, from the board's wiring and the machine's configuration.

use board_facts::wiring;
use sim::world::{Pin, WorldConfig};
use units::Actuator;

/// Number of ports, A to K.
pub const PORTS: usize = 11;
/// Number of pins of a port.
pub const PINS: usize = 16;

/// Returns the pins of a driver socket, as the emulator names them: port and pin of the chip select, active
/// low.
#[must_use]
pub fn driver_selects() -> [(&'static str, u8); 4] {
    wiring::DRIVERS.map(|driver| {
        let Pin { port, number } = pin(driver.select);
        (port_name(port), number)
    })
}

/// Returns the emulator's name of a port.
#[must_use]
pub fn port_name(port: u8) -> &'static str {
    PORT_NAMES[usize::from(port)]
}

/// The emulator's names of the ports.
const PORT_NAMES: [&str; PORTS] =
    ["GPIOA", "GPIOB", "GPIOC", "GPIOD", "GPIOE", "GPIOF", "GPIOG", "GPIOH", "GPIOI", "GPIOJ", "GPIOK"];

/// Role of a pin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// STEP input of a motor's driver.
    Step(Actuator),
    /// DIR input of a motor's driver.
    Direction(Actuator),
    /// Enable input of an external driver.
    Enable(Actuator),
    /// ENN input of the on-board drivers.
    MotorsDisable,
    /// Enable input of the output buffer.
    FetBuffer,
    /// Switch of the supply of heaters and fans.
    FetPower,
    /// Output of a heater, by its index in the machine.
    Heater(usize),
    /// Output of a fan, by its index in the machine.
    Fan(usize),
}

/// The roles of all pins.
#[derive(Clone, Debug)]
pub struct Wiring {
    roles: [[Option<Role>; PINS]; PORTS],
}

/// Returns a pin of the board that is known to exist.
///
/// # Panics
/// When no pin has this name: the tables here are constants.
#[must_use]
pub const fn pin(name: &str) -> Pin {
    match Pin::parse(name) {
        Some(pin) => pin,
        None => panic!("not the name of a pin"),
    }
}

impl Wiring {
    /// Builds the roles from the board's wiring, and from the machine's configuration for its connectors.
    #[must_use]
    pub fn of(machine: &WorldConfig) -> Self {
        let mut wires = Self { roles: [[None; PINS]; PORTS] };
        for actuator in &machine.actuators {
            let lines = [
                (actuator.step_pin, Role::Step(actuator.actuator)),
                (actuator.direction_pin, Role::Direction(actuator.actuator)),
                (actuator.enable_pin, Role::Enable(actuator.actuator)),
            ];
            for (line, role) in lines {
                wires.lead(line, role);
            }
        }
        for (index, heater) in machine.heaters.iter().enumerate() {
            wires.lead(heater.pin, Role::Heater(index));
        }
        for (index, fan) in machine.fans.iter().enumerate() {
            wires.lead(Some(fan.pin), Role::Fan(index));
        }
        for (actuator, driver) in Actuator::ALL.into_iter().zip(wiring::DRIVERS) {
            wires.lead(Some(pin(driver.step)), Role::Step(actuator));
            wires.lead(Some(pin(driver.direction)), Role::Direction(actuator));
        }
        wires.lead(Some(pin(wiring::MOTORS_ENABLE)), Role::MotorsDisable);
        wires.lead(Some(pin(wiring::OUTPUT_BUFFER_ENABLE)), Role::FetBuffer);
        wires.lead(Some(pin(wiring::SUPPLY_SWITCH)), Role::FetPower);
        wires
    }

    fn lead(&mut self, pin: Option<Pin>, role: Role) {
        if let Some(Pin { port, number }) = pin {
            self.roles[usize::from(port)][usize::from(number)] = Some(role);
        }
    }

    /// Returns the role of a pin, by port and number.
    #[must_use]
    pub fn role(&self, port: usize, number: usize) -> Option<Role> {
        self.roles[port][number]
    }

    /// Iterates over every pin with a role.
    pub fn all(&self) -> impl Iterator<Item = (Pin, Role)> + '_ {
        self.roles.iter().enumerate().flat_map(|(port, pins)| {
            pins.iter().enumerate().filter_map(move |(number, role)| {
                role.map(|role| (Pin { port: port as u8, number: number as u8 }, role))
            })
        })
    }
}
