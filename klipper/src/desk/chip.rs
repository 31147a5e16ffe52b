//! A chip on an I2C bus.

/// A chip of an I2C bus, as it sees the two lines: address 0x42, and registers that count up when read.
#[derive(Default)]
pub struct I2cChip {
    clock: bool,
    data: bool,
    /// Bits of the byte that is on its way, and the byte. `None` before a start.
    bits: Option<(u8, u8)>,
    /// The byte is the address; then, whether it is one that the chip writes.
    is_address: bool,
    writes: bool,
    is_ours: bool,
    pulls: bool,
    next: u8,
    /// Bytes that were written to the chip.
    pub received: Vec<u8>,
    /// Ends of transfers that were seen.
    pub stops: usize,
}

impl I2cChip {
    /// Whether the chip pulls the data line low.
    pub fn pulls_low(&self) -> bool {
        self.pulls
    }

    /// Takes the levels of both lines.
    pub fn see(&mut self, clock: bool, data: bool) {
        let before = (self.clock, self.data);
        (self.clock, self.data) = (clock, data);
        match (before, clock, data) {
            ((true, true), true, false) => {
                (self.bits, self.is_address, self.writes, self.is_ours) = (Some((0, 0)), true, false, false);
            }
            ((true, false), true, true) => {
                self.bits = None;
                self.stops += 1;
            }
            ((false, _), true, _) => self.rise(data),
            ((true, _), false, _) => self.fall(),
            _ => {}
        }
    }

    fn rise(&mut self, data: bool) {
        if let Some((count, byte)) = self.bits {
            let byte = if count < 8 { byte << 1 | u8::from(data) } else { byte };
            // A byte that the host does not acknowledge is the last one.
            if count == 8 && self.writes && !self.is_address && data {
                self.writes = false;
            }
            self.bits = Some((count + 1, byte));
        }
    }

    fn fall(&mut self) {
        let Some((count, byte)) = self.bits else { return };
        if count == 8 && self.is_address {
            self.is_ours = byte >> 1 == 0x42;
            self.pulls = self.is_ours;
        } else if count == 8 && self.is_ours && !self.writes {
            self.received.push(byte);
            self.pulls = true;
        } else if count == 8 {
            self.pulls = false;
        } else if count == 9 {
            if self.is_address {
                self.writes = byte & 1 != 0 && self.is_ours;
                self.is_address = false;
            }
            self.next = self.next.wrapping_add(u8::from(self.writes));
            self.bits = Some((0, 0));
            self.pulls = self.writes && self.next & 0x80 == 0;
        } else if self.writes && !self.is_address {
            self.pulls = self.next << count & 0x80 == 0;
        }
    }
}
