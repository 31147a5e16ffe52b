//! Buttons and encoders: levels of up to eight pins, of which no change is lost on the line.

use crate::board::Input;
use crate::reason::Reason;

/// Pins of an object, and changes that are kept until the host has acknowledged them.
const MOST: usize = 8;

/// Pins that are looked at together.
#[derive(Debug)]
pub struct Buttons<I> {
    pins: [Option<I>; MOST],
    count: usize,
    rest_ticks: u32,
    retransmit_count: u8,
    /// Looks until the changes are told again; zero: they have just come.
    looks_left: u8,
    /// The level that counts as released, one bit each.
    invert: u8,
    /// Levels of the last look.
    seen: u8,
    /// Levels that were told last.
    pressed: u8,
    /// Changes that the host has acknowledged so far.
    acknowledged: u8,
    changes: heapless::Vec<u8, MOST>,
}

impl<I: Input> Buttons<I> {
    /// # Errors
    /// More than eight buttons.
    pub fn new(count: u32) -> Result<Self, Reason> {
        if count as usize > MOST {
            return Err(Reason::ButtonsMost);
        }
        Ok(Self {
            pins: [const { None }; MOST],
            count: count as usize,
            rest_ticks: 0,
            retransmit_count: 0,
            looks_left: 0,
            invert: 0,
            seen: 0,
            pressed: 0,
            acknowledged: 0,
            changes: heapless::Vec::new(),
        })
    }

    /// # Errors
    /// A place beyond the number that was configured.
    pub fn add(&mut self, place: u32, pin: I) -> Result<(), Reason> {
        let count = self.count;
        let slot = self.pins.get_mut(..count).and_then(|pins| pins.get_mut(place as usize));
        *slot.ok_or(Reason::ButtonsRange)? = Some(pin);
        Ok(())
    }

    /// Begins to look, or ends it. Returns when to look first.
    ///
    /// # Errors
    /// Changes would never be told again.
    pub fn ask(&mut self, clock: u32, rest_ticks: u32, retransmit: u8, invert: u8) -> Result<Option<u32>, Reason> {
        if rest_ticks != 0 && retransmit == 0 {
            return Err(Reason::ButtonsRetransmit);
        }
        self.rest_ticks = rest_ticks;
        self.retransmit_count = retransmit;
        self.looks_left = u8::MAX;
        self.invert = invert;
        (self.seen, self.pressed, self.acknowledged) = (0, 0, 0);
        self.changes.clear();
        Ok((rest_ticks != 0).then_some(clock))
    }

    /// Looks at the pins. Returns the time of the next look, and whether changes are to be told.
    pub fn look(&mut self, due: u32) -> (u32, bool) {
        let levels = self
            .pins
            .iter()
            .rev()
            .fold(0_u8, |levels, pin| levels << 1 | u8::from(pin.as_ref().is_some_and(Input::is_high)));
        let levels = levels ^ self.invert;
        // A change counts when two looks agree.
        if levels == self.seen && levels != self.pressed && self.changes.push(levels).is_ok() {
            self.pressed = levels;
            self.looks_left = 0;
        }
        self.seen = levels;
        let tells = !self.changes.is_empty() && self.looks_left == 0;
        self.looks_left = if tells { self.retransmit_count } else { self.looks_left.saturating_sub(1) };
        (due.wrapping_add(self.rest_ticks), tells)
    }

    /// Number of changes acknowledged, and those that are not.
    pub fn state(&self) -> (u32, &[u8]) {
        (u32::from(self.acknowledged), &self.changes)
    }

    /// The host has the first `count` changes.
    pub fn acknowledge(&mut self, count: u32) {
        let count = (count as usize).min(self.changes.len());
        self.acknowledged = self.acknowledged.wrapping_add(count as u8);
        self.changes = self.changes.iter().skip(count).copied().collect();
    }
}
