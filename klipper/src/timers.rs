//! Times at which the objects are to be looked at.

/// Objects of a host at most; it numbers them from 0.
pub const MAX_OBJECTS: usize = 96;
/// Timers: one for each object, and two of the controller's own.
const TIMERS: usize = MAX_OBJECTS + 2;
/// Timer of the statistics.
pub const STATISTICS: u8 = MAX_OBJECTS as u8;
/// Timer that looks whether the host still speaks.
pub const SILENCE: u8 = MAX_OBJECTS as u8 + 1;

/// Timers of all objects, one for each. Times are of the 32-bit clock, less than half a turn away.
#[derive(Debug)]
pub struct Timers {
    due: [u32; TIMERS],
    armed: u128,
}

impl Timers {
    /// Creates timers of which none is armed.
    pub const fn new() -> Self {
        Self { due: [0; TIMERS], armed: 0 }
    }

    /// Has an object looked at, at this time rather than the one before.
    pub fn set(&mut self, object: u8, clock: u32) {
        if let Some(due) = self.due.get_mut(usize::from(object)) {
            *due = clock;
            self.armed |= 1 << object;
        }
    }

    /// Has an object looked at, or not.
    pub fn set_or_clear(&mut self, object: u8, clock: Option<u32>) {
        match clock {
            Some(clock) => self.set(object, clock),
            None => self.clear(object),
        }
    }

    /// Has an object not looked at.
    pub fn clear(&mut self, object: u8) {
        self.armed &= !(1_u128.checked_shl(u32::from(object)).unwrap_or(0));
    }

    /// Returns the object whose time comes first, and how many ticks from now that is; negative when it has
    /// passed.
    pub fn first(&self, now: u32) -> Option<(u8, i32)> {
        let (mut armed, mut first) = (self.armed, None::<(u8, i32)>);
        while armed != 0 {
            let object = armed.trailing_zeros() as u8;
            armed &= armed - 1;
            let ahead = self.due.get(usize::from(object)).map_or(i32::MAX, |due| due.wrapping_sub(now) as i32);
            if first.is_none_or(|(_, least)| ahead < least) {
                first = Some((object, ahead));
            }
        }
        first
    }
}
