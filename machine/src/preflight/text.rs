//! A preflight of a file that is at hand as a whole.

use gcode::MAX_LINE_LENGTH;
use motion::Motion;
use program::{Dialect, Next, Place};

use super::state::{Listener, Preflight};
use crate::wait::run_to_end;

/// What a text says of its dialect, as a job's file is asked.
#[must_use]
pub fn dialect_of(text: &[u8]) -> Option<Dialect> {
    crate::jobs::of_text(text)
}

/// Reads a text to its end. Subroutines are looked for in it alone.
pub fn read(preflight: &mut Preflight<'_>, text: &[u8], motion: &mut Motion, listener: &mut dyn Listener) {
    run_to_end(read_on(preflight, text, motion, listener));
}

async fn read_on(preflight: &mut Preflight<'_>, text: &[u8], motion: &mut Motion, listener: &mut dyn Listener) {
    let mut place = Place::default();
    while let Some(rest) = text.get(place.offset as usize..).filter(|rest| !rest.is_empty()) {
        if preflight.has_ended() || preflight.is_endless(listener) {
            break;
        }
        let end = rest.iter().position(|byte| *byte == b'\n').map_or(rest.len(), |end| end + 1);
        let line = rest.get(..end).unwrap_or(rest).trim_ascii_end();
        let after = Place { offset: place.offset.saturating_add(end as u32), line: place.line + 1 };
        if line.len() > MAX_LINE_LENGTH && line.first() != Some(&b';') {
            preflight.too_long(place, listener);
            place = after;
            continue;
        }
        let line = line.get(..line.len().min(MAX_LINE_LENGTH)).unwrap_or(line);
        place = match preflight.line(line, (place, after), motion, listener).await {
            Next::Following | Next::Returned => after,
            Next::At(place) => place,
            Next::FirstOf(_) => {
                preflight.enter_file(false);
                after
            }
        };
    }
    preflight.end(motion, listener).await;
}
