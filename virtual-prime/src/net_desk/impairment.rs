//! A bad line: frames are lost, doubled, put out of order, damaged and delayed, the same ones for the same
//! seed.

use std::collections::BTreeMap;
use std::ops::Range;

/// Length of an Ethernet header, which damage leaves alone: a frame to another address would only be lost.
const HEADER: usize = 14;

/// Shares of frames, in thousandths, and times.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Impairment {
    /// Frames that are lost.
    pub loss: u32,
    /// Frames that arrive twice.
    pub doubling: u32,
    /// Frames that wait so long that others overtake them.
    pub reordering: u32,
    /// Frames with a wrong bit behind a right check sequence, as a bad switch makes them.
    pub corruption: u32,
    /// Time on the way, nanoseconds; an empty range is none.
    pub delay_ns: Range<u64>,
    /// Time more for frames to be overtaken.
    pub overtaken_ns: u64,
}

impl Impairment {
    /// Returns a line that only loses this share of frames, in thousandths.
    #[must_use]
    pub fn losing(loss: u32) -> Self {
        Self { loss, ..Self::default() }
    }
}

/// Numbers that look random and are the same for the same seed: SplitMix64, of Steele, Lea and Flood.
#[derive(Clone, Debug)]
pub struct Random(u64);

impl Random {
    /// Begins a sequence.
    #[must_use]
    pub const fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns the next number.
    pub const fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ self.0 >> 30).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ mixed >> 27).wrapping_mul(0x94D0_49BB_1331_11EB);
        mixed ^ mixed >> 31
    }

    /// Returns a number below a bound; 0 for none.
    pub const fn below(&mut self, bound: u64) -> u64 {
        if bound == 0 { 0 } else { self.next() % bound }
    }

    const fn hits(&mut self, thousandths: u32) -> bool {
        self.below(1_000) < thousandths as u64
    }
}

/// One direction of the line.
#[derive(Clone, Debug)]
pub struct Way {
    /// What happens to frames that enter from now on.
    pub impairment: Impairment,
    random: Random,
    /// Frames on the way, by the instant of their arrival and in the order in which they entered.
    frames: BTreeMap<(u64, u64), Vec<u8>>,
    entered: u64,
    lost: u64,
}

impl Way {
    /// Creates a way without impairment.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self {
            impairment: Impairment::default(),
            random: Random::new(seed),
            frames: BTreeMap::new(),
            entered: 0,
            lost: 0,
        }
    }

    /// Returns the number of frames that were lost.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        self.lost
    }

    /// Puts a frame on the way.
    pub fn enter(&mut self, at_ns: u64, frame: Vec<u8>) {
        let Impairment { loss, doubling, corruption, .. } = self.impairment;
        if self.random.hits(loss) {
            self.lost += 1;
            return;
        }
        let mut frame = frame;
        if self.random.hits(corruption) {
            self.damage(&mut frame);
        }
        if self.random.hits(doubling) {
            self.insert(at_ns, frame.clone());
        }
        self.insert(at_ns, frame);
    }

    fn damage(&mut self, frame: &mut [u8]) {
        let place = HEADER as u64 + self.random.below((frame.len().saturating_sub(HEADER)) as u64);
        let bit = self.random.below(8);
        if let Some(byte) = frame.get_mut(place as usize) {
            *byte ^= 1 << bit;
        }
    }

    fn insert(&mut self, at_ns: u64, frame: Vec<u8>) {
        let Range { start, end } = self.impairment.delay_ns;
        let mut due_ns = at_ns + start + self.random.below(end.saturating_sub(start));
        if self.random.hits(self.impairment.reordering) {
            due_ns += self.impairment.overtaken_ns;
        } else if let Some((&(last_ns, _), _)) = self.frames.last_key_value() {
            // Delay alone keeps the order.
            let kept = self.impairment.reordering == 0;
            due_ns = if kept { due_ns.max(last_ns) } else { due_ns };
        }
        self.frames.insert((due_ns, self.entered), frame);
        self.entered += 1;
    }

    /// Takes the frames that have arrived, oldest first.
    pub fn arrived(&mut self, now_ns: u64) -> Vec<Vec<u8>> {
        let later = self.frames.split_off(&(now_ns + 1, 0));
        std::mem::replace(&mut self.frames, later).into_values().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn through(impairment: Impairment, seed: u64) -> Vec<Vec<u8>> {
        let mut way = Way::new(seed);
        way.impairment = impairment;
        for number in 0..1_000_u32 {
            way.enter(u64::from(number) * 1_000, [&[0; HEADER][..], &number.to_le_bytes()].concat());
        }
        way.arrived(u64::MAX - 1)
    }

    #[test]
    fn a_good_line_changes_nothing() {
        let frames = through(Impairment::default(), 1);
        assert_eq!(frames.len(), 1_000);
        assert!(frames.is_sorted_by_key(|frame| u32::from_le_bytes([frame[14], frame[15], frame[16], frame[17]])));
    }

    #[test]
    fn the_same_seed_impairs_the_same_frames() {
        let impairment = Impairment {
            loss: 200,
            doubling: 50,
            reordering: 100,
            corruption: 20,
            delay_ns: 1_000..9_000,
            overtaken_ns: 50_000,
        };
        assert_eq!(through(impairment.clone(), 7), through(impairment.clone(), 7));
        assert_ne!(through(impairment.clone(), 7), through(impairment.clone(), 8));
        let lost = 1_000 - through(Impairment::losing(200), 7).len();
        assert!((150..250).contains(&lost), "{lost}");
    }

    #[test]
    fn delay_keeps_the_order_and_reordering_does_not() {
        let delayed = Impairment { delay_ns: 0..100_000, ..Impairment::default() };
        assert_eq!(through(delayed, 3), through(Impairment::default(), 3));
        let reordered = Impairment { reordering: 100, overtaken_ns: 10_000, ..Impairment::default() };
        let (mut reordered, sorted) = (through(reordered, 3), through(Impairment::default(), 3));
        assert_ne!(reordered, sorted);
        reordered.sort_by_key(|frame| u32::from_le_bytes([frame[14], frame[15], frame[16], frame[17]]));
        assert_eq!(reordered, sorted);
    }

    #[test]
    fn damage_changes_one_bit_behind_the_header() {
        let damaged = through(Impairment { corruption: 1_000, ..Impairment::default() }, 5);
        for (damaged, sound) in damaged.iter().zip(through(Impairment::default(), 5)) {
            let bits: u32 = damaged.iter().zip(&sound).map(|(one, other)| (one ^ other).count_ones()).sum();
            assert_eq!((bits, &damaged[..HEADER]), (1, &sound[..HEADER]));
        }
    }
}
