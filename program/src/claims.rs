//! Codes that the configuration gives to heaters and switches: M104 sets the hot end because its section says
//! so.
//!
//! Any code can be claimed, also one that means something already: then both happen, the switch first.

use gcode::{Code, Letter};
use heapless::Vec;
use units::{HeaterId, SwitchId};

/// Claims of one code: every switch listens to it, every heater, and every rule.
pub(crate) const MOST_CLAIMS: usize = 16 + units::MAX_HEATERS + MOST_RULES;
/// Three codes of each heater and of each switch, one of each rule.
const MOST: usize = 3 * units::MAX_HEATERS + 3 * 16 + MOST_RULES;
/// Rules that a code arms at most.
const MOST_RULES: usize = 8;

/// What a code does because the configuration says so.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Claim {
    /// It sets a heater's target.
    Target(HeaterId),
    /// It sets the target and waits for it.
    TargetAndWait(HeaterId),
    /// It asks for temperatures.
    Temperature(HeaterId),
    /// It switches an output on; S may say how far.
    SwitchOn(SwitchId),
    /// It switches an output off.
    SwitchOff(SwitchId),
    /// It arms or disarms a rule that follows a temperature, by its place in the configuration's list.
    Arm(u8),
}

/// All claimed codes of a machine.
#[derive(Clone, Debug)]
pub struct Claims {
    claims: Vec<(Code, Claim), MOST>,
    /// Which G and M numbers may be claimed, one bit each, so that nearly every code is told apart by one
    /// look. What is beyond shares the bits of what is below.
    g: [u32; 4],
    m: [u32; 32],
}

impl Default for Claims {
    fn default() -> Self {
        Self { claims: Vec::new(), g: [0; 4], m: [0; 32] }
    }
}

/// The word of its bit, and the bit.
const fn place(number: u16, words: usize) -> (usize, u32) {
    (number as usize / 32 % words, 1 << (number % 32))
}

impl Claims {
    /// Adds one. False when the code cannot be claimed: T.
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

    /// Whether anything may claim this number, whatever the subcode: nothing does where it is false.
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

    /// What claims this code.
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
