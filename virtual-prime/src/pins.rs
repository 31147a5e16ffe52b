//! What each pin of the microcontroller leads to on the Prime, and through the machine's configuration beyond it.

use sim::world::{Pin, WorldConfig};
use units::Actuator;

/// Ports A to K.
pub const PORTS: usize = 11;
/// Pins of one port.
pub const PINS: usize = 16;

/// STEP and DIR pins of the on-board drivers, alpha to delta (board facts, "Steppers").
const STEP_DIR: [(&str, &str); 4] = [("PD3", "PD4"), ("PK2", "PG2"), ("PG3", "PG4"), ("PC6", "PG5")];
/// Chip selects of the on-board drivers, alpha to delta, active low, port and pin.
pub const DRIVER_SELECTS: [(&str, u8); 4] = [("GPIOJ", 13), ("GPIOG", 8), ("GPIOG", 7), ("GPIOG", 6)];
/// ENN of all on-board drivers.
pub const MOTORS_DISABLE: &str = "PH13";
/// Enable of the output buffer, low active, pulled up to 5 V.
pub const FET_BUFFER: &str = "PF14";
/// Switch of the heaters' and fans' supply.
const FET_POWER: &str = "PD7";
/// Board id straps, bit 0 first: grounded is a one.
pub const BOARD_ID: [&str; 4] = ["PF7", "PF5", "PF3", "PE10"];
/// The four indicator LEDs, and the mass storage LED.
pub const LEDS: [&str; 5] = ["PH9", "PH10", "PH11", "PH12", "PF13"];

/// What a pin drives.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// STEP of a motor.
    Step(Actuator),
    /// DIR of a motor.
    Direction(Actuator),
    /// Enable of an external driver.
    Enable(Actuator),
    /// ENN of the on-board drivers.
    MotorsDisable,
    /// Enable of the output buffer.
    FetBuffer,
    /// Supply of heaters and fans.
    FetPower,
    /// A heater, by its index in the machine.
    Heater(usize),
    /// A fan, by its index in the machine.
    Fan(usize),
}

/// The roles of all pins.
#[derive(Clone, Debug)]
pub struct Wiring {
    roles: [[Option<Role>; PINS]; PORTS],
}

/// A pin of the board that is known to exist.
///
/// # Panics
/// When the name is no pin's: the tables here are constants.
#[must_use]
pub const fn pin(name: &str) -> Pin {
    match Pin::parse(name) {
        Some(pin) => pin,
        None => panic!("not the name of a pin"),
    }
}

impl Wiring {
    /// The board's copper, and what the machine's configuration hangs on its connectors.
    #[must_use]
    pub fn of(machine: &WorldConfig) -> Self {
        let mut wiring = Self { roles: [[None; PINS]; PORTS] };
        for actuator in &machine.actuators {
            let lines = [
                (actuator.step_pin, Role::Step(actuator.actuator)),
                (actuator.direction_pin, Role::Direction(actuator.actuator)),
                (actuator.enable_pin, Role::Enable(actuator.actuator)),
            ];
            for (line, role) in lines {
                wiring.lead(line, role);
            }
        }
        for (index, heater) in machine.heaters.iter().enumerate() {
            wiring.lead(heater.pin, Role::Heater(index));
        }
        for (index, fan) in machine.fans.iter().enumerate() {
            wiring.lead(Some(fan.pin), Role::Fan(index));
        }
        for (actuator, (step, direction)) in Actuator::ALL.into_iter().zip(STEP_DIR) {
            wiring.lead(Some(pin(step)), Role::Step(actuator));
            wiring.lead(Some(pin(direction)), Role::Direction(actuator));
        }
        wiring.lead(Some(pin(MOTORS_DISABLE)), Role::MotorsDisable);
        wiring.lead(Some(pin(FET_BUFFER)), Role::FetBuffer);
        wiring.lead(Some(pin(FET_POWER)), Role::FetPower);
        wiring
    }

    fn lead(&mut self, pin: Option<Pin>, role: Role) {
        if let Some(Pin { port, number }) = pin {
            self.roles[usize::from(port)][usize::from(number)] = Some(role);
        }
    }

    /// What a pin drives, by port and number.
    #[must_use]
    pub fn role(&self, port: usize, number: usize) -> Option<Role> {
        self.roles[port][number]
    }

    /// Every pin with a role.
    pub fn all(&self) -> impl Iterator<Item = (Pin, Role)> + '_ {
        self.roles.iter().enumerate().flat_map(|(port, pins)| {
            pins.iter().enumerate().filter_map(move |(number, role)| {
                role.map(|role| (Pin { port: port as u8, number: number as u8 }, role))
            })
        })
    }
}
