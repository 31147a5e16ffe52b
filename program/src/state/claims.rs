//! Codes that the configuration assigns to heaters and switches: M104 sets the hot end because the hot end's
//! section says so.
//!
//! Any code can be claimed, even a code of the table: then both act, the switch first.

use gcode::{Code, Letter};
use heapless::Vec;
use units::{HeaterId, SwitchId};

/// Most claims of one code: every switch, every heater and every rule may listen to the code.
pub(crate) const MOST_CLAIMS: usize = 16 + units::MAX_HEATERS + MOST_RULES;
/// Most claims in all: three codes of each heater and of each switch, one of each rule, three of a laser's
/// air.
const MOST: usize = 3 * units::MAX_HEATERS + 3 * 16 + MOST_RULES + 3;
/// Most rules that codes arm.
const MOST_RULES: usize = 8;

/// Effect that the configuration assigns to a code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Claim {
    /// Set a heater's target.
    Target(HeaterId),
    /// Set a heater's target and wait until the heater reaches the target.
    TargetAndWait(HeaterId),
    /// Report the temperature of a heater.
    Temperature(HeaterId),
    /// Switch an output on; S may give the value.
    SwitchOn(SwitchId),
    /// Switch an output off.
    SwitchOff(SwitchId),
    /// Arm or disarm a rule that follows a temperature, by the rule's index in the configuration's list.
    Arm(u8),
}

/// All claimed codes of a machine.
#[derive(Clone, Debug)]
pub struct Claims {
    claims: Vec<(Code, Claim), MOST>,
    /// Bit set of claimed G and M numbers, so that one look tells nearly every unclaimed code. Numbers beyond
    /// the sets share the bits of lower numbers.
    g: [u32; 4],
    m: [u32; 32],
}

impl Default for Claims {
    fn default() -> Self {
        Self { claims: Vec::new(), g: [0; 4], m: [0; 32] }
    }
}

/// Returns the index of the word with the number's bit, and the bit.
const fn place(number: u16, words: usize) -> (usize, u32) {
    (number as usize / 32 % words, 1 << (number % 32))
}

impl Claims {
    /// Adds a claim. Returns false when the code cannot be claimed: T.
    pub fn add(&mut self, code: Code, claim: Claim) -> bool {
        let words: &mut [u32] = match code.letter {
            Letter::G => &mut self.g,
            Letter::M => &mut self.m,
            Letter::T => return false,
        };
        let (word, bit) = place(code.number, words.len());
        let Some(word) = words.get_mut(word) else { return false };
        *word |= bit;
        self.claims.push((code, claim)).is_ok()
    }

    /// Whether the number may be claimed, with any subcode; false means certainly not.
    #[must_use]
    pub fn may_have(&self, code: Code) -> bool {
        let words: &[u32] = match code.letter {
            Letter::G => &self.g,
            Letter::M => &self.m,
            Letter::T => return false,
        };
        let (word, bit) = place(code.number, words.len());
        words.get(word).is_some_and(|word| word & bit != 0)
    }

    /// Returns all claims of this code.
    pub fn of(&self, code: Code) -> impl Iterator<Item = Claim> + '_ {
        self.claims.iter().filter(move |(claimed, _)| *claimed == code).map(|(_, claim)| *claim)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_claim_of_a_code_is_found_and_no_other() {
        let mut claims = Claims::default();
        let [on, off] = [Claim::SwitchOn(SwitchId(2)), Claim::SwitchOff(SwitchId(2))];
        assert!(claims.add(Code::m(106), on) && claims.add(Code::m(107), off) && claims.add(Code::m(106).sub(1), off));
        assert!(claims.add(Code::m(106), off));
        assert_eq!(claims.of(Code::m(106)).collect::<std::vec::Vec<_>>(), [on, off]);
        assert_eq!(claims.of(Code::m(106).sub(1)).collect::<std::vec::Vec<_>>(), [off]);
        assert!(claims.may_have(Code::m(107)) && !claims.may_have(Code::m(108)) && !claims.may_have(Code::g(107)));
        assert_eq!(claims.of(Code::m(108)).count(), 0);
        assert!(!claims.add(Code::t(1), on) && !claims.may_have(Code::t(1)));
        for code in [Code::m(1_024), Code::m(u16::MAX), Code::g(128), Code::g(u16::MAX)] {
            assert!(claims.add(code, on) && claims.may_have(code), "{code}");
            assert_eq!(claims.of(code).collect::<std::vec::Vec<_>>(), [on]);
        }
    }
}
