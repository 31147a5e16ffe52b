//! Bytes that act at once, wherever they stand in a line, and are never part of it.
//!
//! Only consoles look for them; a file being played or uploaded keeps its bytes.

/// A request that does not wait for the end of the line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Realtime {
    /// `?`: report the status.
    Status,
    /// `!`: feed hold.
    Hold,
    /// `~`: resume.
    Resume,
    /// Ctrl-X: abort, halt.
    Abort,
    /// Ctrl-Y: clear a halt, else stop what this console started (jog, listing).
    Stop,
}

/// The request a byte makes, if it makes one.
#[must_use]
pub const fn classify(byte: u8) -> Option<Realtime> {
    Some(match byte {
        b'?' => Realtime::Status,
        b'!' => Realtime::Hold,
        b'~' => Realtime::Resume,
        0x18 => Realtime::Abort,
        0x19 => Realtime::Stop,
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exactly_five_bytes_leave_the_stream() {
        let taken: Vec<u8> = (0..=255).filter(|&byte| classify(byte).is_some()).collect();
        assert_eq!(taken, [0x18, 0x19, b'!', b'?', b'~']);
    }
}
