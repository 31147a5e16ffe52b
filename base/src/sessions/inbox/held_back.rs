//! Bytes that a transport holds back for want of room: those among them that act at once.

use core::ops::Range;
use core::sync::atomic::Ordering;

use gcode::realtime::{Heard, Realtime, Receiver};

use super::{Inbox, Intake};

impl Inbox {
    /// Looks through bytes that a transport holds back for want of room, in order behind those received, for
    /// one that acts at once; the first `looked` bytes were looked through before.
    ///
    /// The first such byte acts. Returned are the bytes that must not be received any more: the byte itself,
    /// or all up to it where it drops what was sent before it. A whole line that acts at once, as M112 does,
    /// acts and stays.
    pub fn look_ahead(&self, intake: &mut Intake, waiting: &[u8], looked: usize) -> Option<Range<usize>> {
        if self.raw.load(Ordering::Relaxed) || self.is_forgotten() {
            return None;
        }
        let (is_text, extended) = (self.text.load(Ordering::Relaxed), self.extended.load(Ordering::Relaxed));
        let mut receiver = intake.receiver;
        let mut before = 0;
        for (at, &byte) in waiting.iter().enumerate() {
            let last = core::mem::replace(&mut before, byte);
            if is_text && !matches!(byte, 0x18 | 0x19) {
                receiver = Receiver::new();
                continue;
            }
            match receiver.hear(byte, extended) {
                Heard::Request(request) if at >= looked => {
                    self.act(intake, request, extended);
                    // A command above 0x7F may come as a letter of two bytes.
                    let is_letter = byte >= 0x80 && last == 0xC2;
                    let begin = if extended && request == Realtime::Abort { 0 } else { at - usize::from(is_letter) };
                    return Some(begin..at + 1);
                }
                Heard::Line(request) if at >= looked => self.request(request),
                Heard::Request(_) | Heard::Line(_) | Heard::Byte | Heard::Letter | Heard::Nothing => {}
            }
        }
        None
    }
}
