//! Turns of connections at what they share: the card at rest, a folder that is being listed.

/// Right to use something that is one visitor's at a time.
///
/// Who comes while another has it asks again. A visitor who does not go on for some time loses it, so that
/// nobody is kept waiting by a peer that has gone to sleep.
#[derive(Clone, Copy, Debug, Default)]
pub struct Turn {
    holder: Option<u8>,
    /// Low half of the time at which the holder went on last, milliseconds.
    at_ms: u32,
}

impl Turn {
    /// Returns whether the visitor has the turn, and gives it to him if nobody has gone on with it for so
    /// long.
    pub fn take(&mut self, visitor: u8, now_ms: u64, patience_ms: u32) -> bool {
        let now = now_ms as u32;
        let is_free = match self.holder {
            None => true,
            Some(holder) => holder == visitor || now.wrapping_sub(self.at_ms) >= patience_ms,
        };
        if is_free {
            (self.holder, self.at_ms) = (Some(visitor), now);
        }
        is_free
    }

    /// Ends a visitor's turn, if it is his. Returns whether it was.
    pub fn end(&mut self, visitor: u8) -> bool {
        let is_his = self.holder == Some(visitor);
        if is_his {
            self.holder = None;
        }
        is_his
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_has_the_turn_until_he_ends_it_or_sleeps() {
        let mut turn = Turn::default();
        assert!(turn.take(1, 1_000, 50) && !turn.take(2, 1_049, 50) && turn.take(1, 1_049, 50));
        assert!(!turn.take(2, 1_098, 50));
        assert!(!turn.end(2) && turn.take(2, 1_099, 50), "he slept");
        assert!(turn.end(2));
        assert!(turn.take(1, 1_100, 50));
    }
}
