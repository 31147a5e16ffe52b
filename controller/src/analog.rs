//! Analog inputs: those of the thermistor scan, and those of the converter for supplies and the chip.

use bsp_prime::adc::{MAX_INPUTS, Supplies, Thermistors};
use bsp_prime::pins::{PinName, Pins, table};
use bsp_prime::time;
use klipper::board::{CHIP_TEMPERATURE, PAD_PA0_C};
use units::Micros;

use crate::board::OWNER;

/// Bits of a reading that the host does not get: the converters give 16, it counts on 12.
const FINER_BITS: u32 = 4;
/// Least time between two looks at the scan's progress. Within it two samples come.
const LOOK_EVERY: Micros = Micros(500);
/// Looks without progress after which the scan counts as stopped.
const STUCK_LOOKS: u8 = 3;

/// Input that the host has claimed.
#[derive(Clone, Copy)]
pub enum AnalogInput {
    /// Place in the scan.
    Scanned(usize),
    /// Index of [`table::SUPPLIES`].
    Supply(usize),
}

/// The two converters and the inputs that the host has claimed.
pub struct AnalogInputs {
    thermistors: Thermistors,
    supplies: Supplies,
    /// Channels of the scan, and their number.
    channels: [u8; MAX_INPUTS],
    scanned: usize,
    /// Indices of the supplies that the host reads, one bit each.
    wanted: u16,
    /// Place of the scan at the last look, its time, and looks since which it has been there.
    place: u32,
    looked: Micros,
    stuck: u8,
}

impl AnalogInputs {
    /// Creates the inputs, none of which is claimed.
    pub const fn new(thermistors: Thermistors, supplies: Supplies) -> Self {
        let looked = Micros(0);
        Self { thermistors, supplies, channels: [0; MAX_INPUTS], scanned: 0, wanted: 0, place: 0, looked, stuck: 0 }
    }

    /// Claims the input of this number; `None` for one that is no analog input, or taken.
    pub fn claim(&mut self, number: u32, pins: &mut Pins) -> Option<AnalogInput> {
        let pin = PinName::numbered(number);
        let is_meant = |input: &table::AnalogInput| match input.pin {
            Some(_) => input.pin == pin,
            None => false,
        };
        let thermistor = |input: &&table::AnalogInput| is_meant(input) || input.pin.is_none() && number == PAD_PA0_C;
        if let Some(input) = table::THERMISTORS.iter().find(thermistor) {
            return self.claim_scanned(input, pins);
        }
        let index = if number == CHIP_TEMPERATURE {
            table::CHIP_TEMPERATURE
        } else {
            table::SUPPLIES.iter().position(is_meant)?
        };
        if self.wanted & 1 << index != 0 {
            return None;
        }
        if let Some(pin) = pin {
            pins.analog(pin, OWNER).ok()?;
        }
        self.wanted |= 1 << index;
        Some(AnalogInput::Supply(index))
    }

    fn claim_scanned(&mut self, input: &table::AnalogInput, pins: &mut Pins) -> Option<AnalogInput> {
        let claimed = self.channels.get(..self.scanned)?;
        if claimed.contains(&input.channel) {
            return None;
        }
        let place = self.scanned;
        let channel = self.channels.get_mut(place)?;
        if let Some(pin) = input.pin {
            pins.analog(pin, OWNER).ok()?;
        }
        *channel = input.channel;
        self.scanned += 1;
        Some(AnalogInput::Scanned(place))
    }

    /// Starts the conversions of what was claimed. Inputs of a converter that does not start have no
    /// readings.
    pub fn start(&mut self) {
        let channels = self.channels.get(..self.scanned).unwrap_or_default();
        if !channels.is_empty() && self.thermistors.start(channels).is_err() {
            defmt::error!("the converter of the thermistors does not start");
        }
        let mut wanted = [0; table::SUPPLIES.len()];
        let mut count = 0;
        for (place, index) in
            wanted.iter_mut().zip((0..table::SUPPLIES.len()).filter(|index| self.wanted & 1 << index != 0))
        {
            *place = index;
            count += 1;
        }
        let wanted = wanted.get(..count).unwrap_or_default();
        if !wanted.is_empty() && self.supplies.start(wanted).is_err() {
            defmt::error!("the converter of the supplies does not start");
        }
    }

    /// Returns the newest reading, 12 bits of it; `None` before there is one, and when the converter has
    /// stopped.
    pub fn read(&mut self, input: AnalogInput) -> Option<u16> {
        let reading = match input {
            AnalogInput::Scanned(place) if self.goes_on() => self.thermistors.latest(place).ok()?,
            AnalogInput::Scanned(_) => return None,
            AnalogInput::Supply(index) => self.supplies.latest(index)?,
        };
        Some(reading >> FINER_BITS)
    }

    /// Whether the scan has not stopped.
    fn goes_on(&mut self) -> bool {
        let now = time::now();
        if now.since(self.looked) >= LOOK_EVERY {
            let place = self.thermistors.samples_to_wrap();
            self.stuck = if place == self.place { self.stuck.saturating_add(1) } else { 0 };
            (self.place, self.looked) = (place, now);
        }
        self.stuck < STUCK_LOOKS
    }
}
