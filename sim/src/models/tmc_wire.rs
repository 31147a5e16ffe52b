//! A UART of one wire with driver chips on it: TMC2209 datasheet rev. 1.03, chapter 4.
//!
//! Each chip hears everything on the wire: requests, writes, and the answers of the others. A chip learns
//! the time of a bit from the first byte of a datagram. A chip that has lost its way hears nothing until
//! the wire has been idle for twelve bit times, and a pause of more than 63 within a datagram begins a new
//! one.

use super::tmc_stealth::TmcStealth;

const SYNC: u8 = 0x05;
const MASTER: u8 = 0xFF;
const WRITE: u8 = 0x80;
const BYTE_BITS: u64 = 10;
/// Longest time of a bit, at 9600 baud.
const SLOWEST_BIT_NS: u64 = 104_167;
/// SLAVECONF: "SENDDELAY" in bits 11 to 8.
const SLAVECONF: u8 = 0x03;

/// Listening state of the chips on a wire. All chips hear alike, so a single state does for all.
#[derive(Clone, Debug, Default)]
pub struct Wire {
    heard: Vec<u8>,
    is_lost: bool,
    last_ns: Option<u64>,
    bit_ns: u64,
}

/// Answer of a chip: each byte with the time at which its last bit is over.
pub type Answer = [(u64, u8); 8];

impl Wire {
    /// Takes a byte whose stop bit ends now; returns a chip's answer to it.
    pub fn hear(&mut self, at_ns: u64, byte: u8, chips: &mut [&mut TmcStealth]) -> Option<Answer> {
        let datagram = self.take(at_ns, byte)?;
        let [sync, address, register, data @ .., sum] = &datagram[..] else { return None };
        let is_sound = sync & 0xF == SYNC && check_sum(&datagram[..datagram.len() - 1]) == *sum;
        self.is_lost = !is_sound;
        let (chip, register) = (chips.iter_mut().find(|chip| chip.address() == *address)?, *register);
        if !is_sound || chip.condition.silent {
            return None;
        }
        if let Ok(data) = <[u8; 4]>::try_from(data) {
            chip.write_wire(register & !WRITE, u32::from_be_bytes(data));
            return None;
        }
        let delay = u64::from(chip.register(SLAVECONF) >> 8 & 0xF) / 2 * 2 + 1;
        let mut answer = [SYNC, MASTER, register, 0, 0, 0, 0, 0];
        answer[3..7].copy_from_slice(&chip.read_wire(at_ns, register).to_be_bytes());
        answer[7] = check_sum(&answer[..7]);
        let begins = at_ns + delay * 8 * self.bit_ns;
        let ends = |place: usize| begins + (place as u64 + 1) * BYTE_BITS * self.bit_ns;
        let answer = std::array::from_fn(|place| (ends(place), answer[place]));
        for (at_ns, byte) in answer {
            // An answer gets no answer itself.
            self.take(at_ns, byte);
            self.is_lost = true;
        }
        Some(answer)
    }

    /// Adds a byte; returns the datagram that it completes.
    fn take(&mut self, at_ns: u64, byte: u8) -> Option<Vec<u8>> {
        let since = self.last_ns.replace(at_ns).map_or(u64::MAX, |last| at_ns.saturating_sub(last));
        let bit_ns = if self.bit_ns == 0 { SLOWEST_BIT_NS } else { self.bit_ns };
        let idle = since.saturating_sub(BYTE_BITS * bit_ns);
        if idle > 63 * bit_ns || self.is_lost && idle >= 12 * bit_ns {
            self.heard.clear();
            self.is_lost = false;
        }
        if self.is_lost {
            return None;
        }
        self.heard.push(byte);
        if self.heard.len() == 2 {
            self.bit_ns = since / BYTE_BITS;
        }
        let length = match self.heard.get(2) {
            Some(register) if register & WRITE == 0 => 4,
            _ => 8,
        };
        (self.heard.len() == length).then(|| std::mem::take(&mut self.heard))
    }
}

/// Returns the CRC8-ATM, as the datasheet's figure shifts it.
fn check_sum(bytes: &[u8]) -> u8 {
    let mut sum = 0_u8;
    for byte in bytes {
        for place in 0..8 {
            let carry = sum >> 7 ^ byte >> place & 1;
            sum = (sum << 1) ^ (carry * 0b111);
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::super::tmc_stealth::StealthKind;
    use super::*;

    const BIT_NS: u64 = 4_000;

    /// Sends bytes in succession from this time on; returns the answer.
    fn say(wire: &mut Wire, chip: &mut TmcStealth, from_ns: u64, bytes: &[u8]) -> Option<Answer> {
        let mut chips = [chip];
        let ends = |place: usize| from_ns + (place as u64 + 1) * BYTE_BITS * BIT_NS;
        let said = bytes.iter().enumerate().map(|(place, byte)| wire.hear(ends(place), *byte, &mut chips)).last();
        said.flatten()
    }

    /// A datagram seen on a real wire: IOIN of a TMC2209 at address 0.
    const ASK: [u8; 4] = [0x55, 0x00, 0x06, 0xE8];

    #[test]
    fn a_request_is_answered_after_its_delay() {
        let (mut wire, mut chip) = (Wire::default(), TmcStealth::on_wire(StealthKind::Tmc2209, 0, false));
        let answer = say(&mut wire, &mut chip, 1_000_000, &ASK).expect("an answer");
        assert_eq!(answer.map(|(_, byte)| byte), [0x05, 0xFF, 0x06, 0x21, 0, 0, 0, answer[7].1]);
        let asked_ns = 1_000_000 + 40 * BIT_NS;
        assert_eq!(answer[0].0, asked_ns + (8 + 10) * BIT_NS, "SENDDELAY 0 is 8 bit times");
        assert_eq!(say(&mut wire, &mut chip, 2_000_000, &[0x55, 0x01, 0x06, 0xE8]), None, "a wrong sum");
    }

    #[test]
    fn who_does_not_leave_the_wire_idle_is_not_heard() {
        let (mut wire, mut chip) = (Wire::default(), TmcStealth::on_wire(StealthKind::Tmc2209, 0, false));
        let ends_ns = say(&mut wire, &mut chip, 1_000_000, &ASK).expect("an answer")[7].0;
        assert_eq!(say(&mut wire, &mut chip, ends_ns + 5 * BIT_NS, &ASK), None);
        let (mut wire, mut chip) = (Wire::default(), TmcStealth::on_wire(StealthKind::Tmc2209, 0, false));
        let ends_ns = say(&mut wire, &mut chip, 1_000_000, &ASK).expect("an answer")[7].0;
        assert!(say(&mut wire, &mut chip, ends_ns + 12 * BIT_NS, &ASK).is_some());
        // Half a datagram is forgotten after a while.
        say(&mut wire, &mut chip, 3_000_000, &ASK[..2]);
        assert!(say(&mut wire, &mut chip, 3_000_000 + 90 * BIT_NS, &ASK).is_some());
    }

    #[test]
    fn a_write_is_counted_when_it_arrives_whole() {
        let (mut wire, mut chip) = (Wire::default(), TmcStealth::on_wire(StealthKind::Tmc2209, 0, false));
        let mut write = [0x05, 0x00, 0xEC, 0x10, 0x00, 0x00, 0x53, 0x9C];
        say(&mut wire, &mut chip, 1_000_000, &write);
        assert_eq!((chip.register(0x6C), chip.register(0x02)), (0x1000_0053, 1));
        write[5] ^= 1;
        say(&mut wire, &mut chip, 2_000_000, &write);
        assert_eq!((chip.register(0x6C), chip.register(0x02)), (0x1000_0053, 1));
    }
}
