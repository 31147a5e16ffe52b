//! A strip of lights with a chip each: WS2812B and its kin, by their data sheets.
//!
//! A pulse is a bit, and its length gives the value. Each chip keeps the first bits it is sent and passes
//! the rest on; a line that is low for long has all chips show their bits. Pulses outside the data sheet's
//! times are counted: real chips may or may not take them.

use std::ops::RangeInclusive;

/// Times of a chip, nanoseconds.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Times {
    /// High and low times of a 0.
    pub zero: [RangeInclusive<u64>; 2],
    /// High and low times of a 1.
    pub one: [RangeInclusive<u64>; 2],
    /// Time for which the line is low before the chips show their bits.
    pub latch_ns: u64,
}

impl Times {
    /// Returns the times of a Worldsemi WS2812B, data sheet version 1: 0.4, 0.85, 0.8 and 0.45 us, each
    /// +-0.15 us; above 50 us.
    #[must_use]
    pub const fn ws2812b() -> Self {
        Self { zero: [250..=550, 700..=1_000], one: [650..=950, 300..=600], latch_ns: 50_000 }
    }

    /// Returns the times of a Worldsemi WS2812B-V5: 0 high 220 to 380 ns, all others 580 to 1000 ns; above
    /// 280 us.
    #[must_use]
    pub const fn ws2812b_v5() -> Self {
        Self { zero: [220..=380, 580..=1_000], one: [580..=1_000, 580..=1_000], latch_ns: 280_000 }
    }

    /// Returns the times of SK6812 and SK6812RGBW: 0.3, 0.9, 0.6 and 0.6 us, each +-0.15 us; above 80 us.
    #[must_use]
    pub const fn sk6812() -> Self {
        Self { zero: [150..=450, 750..=1_050], one: [450..=750, 450..=750], latch_ns: 80_000 }
    }
}

/// The shortest and the longest times seen, nanoseconds: the pulses of 0 and of 1, and the pauses behind them
/// but for the last.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Seen {
    /// High and low times of a 0.
    pub zero: [Option<(u64, u64)>; 2],
    /// High and low times of a 1.
    pub one: [Option<(u64, u64)>; 2],
}

/// Strip of lights on a line.
#[derive(Clone, Debug)]
pub struct LedStrip {
    /// Kinds of chips that the strip may have: every pulse must suit all of them.
    chips: Vec<Times>,
    /// Number of bytes that the strip's lights keep.
    capacity: usize,
    high: bool,
    /// Time of the line's last change.
    since_ns: u64,
    /// Length of the line's last pulse.
    pulse_ns: Option<u64>,
    /// Bits since the line was last low for long.
    bits: Vec<bool>,
    shown: Vec<u8>,
    frames: u64,
    faults: u64,
    seen: Seen,
}

impl LedStrip {
    /// Makes a dark strip of so many lights of so many bytes, on a line that is low.
    #[must_use]
    pub fn new(lights: usize, bytes_each: usize) -> Self {
        Self {
            chips: vec![Times::ws2812b(), Times::ws2812b_v5(), Times::sk6812()],
            capacity: lights * bytes_each,
            high: false,
            since_ns: 0,
            pulse_ns: None,
            bits: Vec::new(),
            shown: vec![0; lights * bytes_each],
            frames: 0,
            faults: 0,
            seen: Seen::default(),
        }
    }

    fn latch_ns(&self) -> u64 {
        self.chips.iter().map(|chip| chip.latch_ns).max().unwrap_or(0)
    }

    /// Sets the level of the line from now on.
    pub fn level(&mut self, at_ns: u64, high: bool) {
        if high == self.high {
            return;
        }
        let lasted_ns = at_ns.saturating_sub(self.since_ns);
        (self.high, self.since_ns) = (high, at_ns);
        if !high {
            self.pulse_ns = Some(lasted_ns);
            return;
        }
        self.end_bit(lasted_ns);
        if lasted_ns > self.latch_ns() {
            self.show();
        }
    }

    /// Ends the bit of the last pulse with the low line behind it.
    fn end_bit(&mut self, low_ns: u64) {
        let Some(high_ns) = self.pulse_ns.take() else { return };
        let is_last = low_ns > self.latch_ns();
        let fits =
            |[high, low]: &[RangeInclusive<u64>; 2]| high.contains(&high_ns) && (is_last || low.contains(&low_ns));
        let one = self.chips.iter().all(|chip| fits(&chip.one));
        let zero = self.chips.iter().all(|chip| fits(&chip.zero));
        self.faults += u64::from(one == zero);
        let bit = one || !zero && high_ns > 500;
        let seen = if bit { &mut self.seen.one } else { &mut self.seen.zero };
        for (seen, lasted_ns) in seen.iter_mut().zip([Some(high_ns), (!is_last).then_some(low_ns)]) {
            let Some(lasted_ns) = lasted_ns else { continue };
            let (least, most) = seen.unwrap_or((lasted_ns, lasted_ns));
            *seen = Some((least.min(lasted_ns), most.max(lasted_ns)));
        }
        self.bits.push(bit);
    }

    fn show(&mut self) {
        if self.bits.is_empty() {
            return;
        }
        self.faults += u64::from(!self.bits.len().is_multiple_of(8));
        let byte = |bits: &[bool]| bits.iter().fold(0_u8, |byte, bit| byte << 1 | u8::from(*bit));
        let bytes: Vec<u8> = self.bits.chunks_exact(8).map(byte).take(self.capacity).collect();
        self.shown[..bytes.len()].copy_from_slice(&bytes);
        self.bits.clear();
        self.frames += 1;
    }

    /// Returns the bytes that the lights show, in the order of sending.
    pub fn shown(&mut self, now_ns: u64) -> &[u8] {
        if !self.high && now_ns.saturating_sub(self.since_ns) > self.latch_ns() {
            self.end_bit(u64::MAX);
            self.show();
        }
        &self.shown
    }

    /// Takes bytes from a sender that makes no pulses.
    pub fn take(&mut self, bytes: &[u8]) {
        let count = bytes.len().min(self.capacity);
        self.shown[..count].copy_from_slice(&bytes[..count]);
        self.frames += 1;
    }

    /// Returns the number of transmissions so far.
    #[must_use]
    pub const fn frames(&self) -> u64 {
        self.frames
    }

    /// Returns the times of the line so far.
    #[must_use]
    pub const fn seen(&self) -> Seen {
        self.seen
    }

    /// Returns the number of pulses, and of pauses behind them, that some chip need not understand; and of
    /// bytes with bits missing.
    #[must_use]
    pub const fn faults(&self) -> u64 {
        self.faults
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Sends bits with these high and low times of 0 and 1.
    fn send(strip: &mut LedStrip, at_ns: &mut u64, bytes: &[u8], [zero, one]: [[u64; 2]; 2]) {
        for bit in bytes.iter().flat_map(|byte| (0..8).rev().map(move |bit| byte >> bit & 1 == 1)) {
            let [high, low] = if bit { one } else { zero };
            strip.level(*at_ns, true);
            strip.level(*at_ns + high, false);
            *at_ns += high + low;
        }
    }

    const SUITS_ALL: [[u64; 2]; 2] = [[320, 970], [700, 590]];

    #[test]
    fn each_light_keeps_its_bytes_and_all_show_them_after_a_pause() {
        let mut strip = LedStrip::new(2, 3);
        let mut at_ns = 1_000_000;
        send(&mut strip, &mut at_ns, &[1, 2, 3, 4, 5, 255, 9], SUITS_ALL);
        assert_eq!(strip.shown(at_ns + 200_000), [0; 6], "not before the pause is long enough");
        assert_eq!(strip.shown(at_ns + 300_000), [1, 2, 3, 4, 5, 255]);
        at_ns += 400_000;
        send(&mut strip, &mut at_ns, &[7, 8, 9], SUITS_ALL);
        assert_eq!(strip.shown(at_ns + 300_000), [7, 8, 9, 4, 5, 255]);
        assert_eq!((strip.frames(), strip.faults()), (2, 0));
    }

    #[test]
    fn what_one_of_the_chips_need_not_understand_is_counted() {
        for times in
            [[[400, 890], [700, 590]], [[320, 970], [800, 490]], [[320, 600], [700, 590]], [[320, 970], [700, 5_000]]]
        {
            let mut strip = LedStrip::new(1, 3);
            let mut at_ns = 1_000_000;
            send(&mut strip, &mut at_ns, &[0x55; 3], times);
            strip.shown(at_ns + 1_000_000);
            assert!(strip.faults() > 0, "{times:?}");
        }
    }

    #[test]
    fn half_a_byte_is_a_fault() {
        let mut strip = LedStrip::new(1, 3);
        for bit in 0..4 {
            strip.level(bit * 1_290, true);
            strip.level(bit * 1_290 + 320, false);
        }
        strip.shown(1_000_000);
        assert_eq!(strip.faults(), 1);
    }
}
