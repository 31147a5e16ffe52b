//! Places on the Prime for what hangs on the old board: by the role of each thing, never by the old pin.

use std::collections::BTreeMap;

/// Place on the Prime.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Pin as config.ini writes it.
    pub pin: &'static str,
    /// Name of the connector on the board.
    pub label: &'static str,
    /// Remark on the connector, for a person.
    pub remark: &'static str,
}

const fn place(pin: &'static str, label: &'static str) -> Place {
    Place { pin, label, remark: "" }
}

const fn minded(pin: &'static str, label: &'static str, remark: &'static str) -> Place {
    Place { pin, label, remark }
}

/// Kind of thing that wants a place.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    Hotend,
    Bed,
    /// Fan, lamp, relay: something that takes power.
    Load,
    /// Sensor of a hot end, of the bed, of anything else.
    HotendSensor,
    BedSensor,
    Thermistor,
    /// Output of a timer, for servos.
    Servo,
    /// Output of the other timer, for strips of lights.
    Strip,
    /// Input of any kind but a homing switch.
    Input,
    /// Chip select of a sensor on SPI.
    Select,
}

const HOTEND_A: Place = place("PE0", "MOSFET hotend A");
const HOTEND_B: Place = place("PB8", "MOSFET hotend B");
const BED: Place = place("PE3", "MOSFET bed");
const NEEDS_MOSFET: &str = "is a signal of 3.3 V: put a MOSFET or driver between";
const NEEDS_PULL_UP: &str = "has no pull-up resistor and no filter for a thermistor: add them";
const SSR: &str = "switches its supply on the high side, active low";

const T1: Place = place("ADC1_1", "connector T1");
const T2: Place = place("ADC1_2", "connector T2");
const T3: Place = place("ADC1_3", "connector T3");
const GH_5: Place = minded("ADC1_4", "header GH pin 5", NEEDS_PULL_UP);
const GH_3: Place = minded("ADC1_5", "header GH pin 3", NEEDS_PULL_UP);
const GH_4: Place = minded("ADC1_6", "header GH pin 4", NEEDS_PULL_UP);

/// Places by their role, the best first.
const PLACES: &[(Role, &[Place])] = &[
    (Role::Hotend, &[HOTEND_A, HOTEND_B]),
    (Role::Bed, &[BED]),
    (
        Role::Load,
        &[
            place("PE1", "MOSFET fan 1"),
            place("PI11", "MOSFET fan 2"),
            HOTEND_B,
            minded("PI4!", "SSR 1", SSR),
            minded("PB7!", "SSR 2", SSR),
            HOTEND_A,
            BED,
            minded("PD9", "header GB pin 3", NEEDS_MOSFET),
            minded("PK0", "header GB pin 6", NEEDS_MOSFET),
            minded("PK1", "header GB pin 7", NEEDS_MOSFET),
            minded("PD14", "header GC pin 3", NEEDS_MOSFET),
            minded("PD12", "header GC pin 4", NEEDS_MOSFET),
            minded("PD10", "header GC pin 5", NEEDS_MOSFET),
            minded("PE7", "header GD pin 3", NEEDS_MOSFET),
            minded("PH2", "header GG pin 3", NEEDS_MOSFET),
            minded("PH4", "header GG pin 4", NEEDS_MOSFET),
            minded("PF15", "header GG pin 6", NEEDS_MOSFET),
            minded("PH3", "header GG pin 7", NEEDS_MOSFET),
        ],
    ),
    (Role::HotendSensor, &[T1, T2, GH_5, GH_3, GH_4]),
    (Role::BedSensor, &[T3, T2, GH_5, GH_3, GH_4]),
    (Role::Thermistor, &[T2, T3, T1, GH_5, GH_3, GH_4]),
    (
        Role::Servo,
        &[
            place("PWM1_1", "header GD pin 6"),
            place("PWM1_2", "header GD pin 7"),
            place("PWM1_3", "header GD pin 8"),
            place("PWM1_4", "header GD pin 9"),
        ],
    ),
    (
        Role::Strip,
        &[
            place("PWM2_1", "header GC pin 6"),
            place("PWM2_2", "header GC pin 7"),
            place("PWM2_3", "header GC pin 8"),
            place("PWM2_4", "header GC pin 9"),
        ],
    ),
    (
        Role::Input,
        &[
            place("PH15", "connector Z max"),
            place("PA9", "connector Y max"),
            place("PI3", "connector X max"),
            place("PI0", "connector Z min"),
            place("PI8", "header GI pin 6"),
            place("PE4", "header GI pin 7"),
            place("PI9", "header GI pin 8"),
            place("PF2", "header GH pin 6"),
            place("PI10", "header GH pin 7"),
            place("PH7", "header GH pin 8"),
            place("PB12", "header GH pin 9"),
            place("PJ8", "header GE pin 5"),
        ],
    ),
    (
        Role::Select,
        &[place("PD15", "header GE pin 6"), place("PJ7", "header GE pin 4"), place("PE8", "header GE pin 3")],
    ),
];

/// Line of the list of what goes where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wire {
    /// What it is: `heater of [extruder]`.
    pub what: String,
    /// Pin on the old board.
    pub old: String,
    pub pin: String,
    pub label: String,
    pub remark: String,
}

/// Connectors that have been given out.
#[derive(Debug, Default)]
pub struct Wiring {
    taken: Vec<&'static str>,
    /// Who took an old pin, by the pin.
    owners: BTreeMap<String, String>,
    pub wires: Vec<Wire>,
}

impl Wiring {
    /// Takes a certain place, so that it is given out no more.
    pub fn reserve(&mut self, pin: &'static str) {
        if !self.taken.contains(&pin) {
            self.taken.push(pin);
        }
    }

    /// Returns the best free place of a role, and takes it.
    pub fn take(&mut self, role: Role) -> Option<Place> {
        let (_, places) = PLACES.iter().find(|(of, _)| *of == role)?;
        let found = places.iter().find(|place| !self.taken.contains(&place.pin))?;
        self.taken.push(found.pin);
        Some(*found)
    }

    /// Notes who has an old pin; returns who has it already.
    pub fn own(&mut self, old: &str, who: &str) -> Option<String> {
        let known = self.owners.get(old).filter(|owner| *owner != who).cloned();
        self.owners.entry(old.to_owned()).or_insert_with(|| who.to_owned());
        known
    }

    /// Adds a line to the list of what goes where.
    pub fn note(&mut self, what: impl Into<String>, old: &str, pin: &str, label: &str, remark: &str) {
        let [pin, label, remark] = [pin, label, remark].map(str::to_owned);
        self.wires.push(Wire { what: what.into(), old: old.to_owned(), pin, label, remark });
    }
}
