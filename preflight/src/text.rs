//! Preflight of a file that is at hand as a whole.

use base::sessions::LineBytes;
use gcode::MAX_LINE_LENGTH;
use jobs::player::{MOST_CALLERS, TOO_DEEP};
use motion::Motion;
use program::{Dialect, Next, Place};

use super::state::{Listener, Preflight};
use super::turns::run_to_end;

/// Returns the dialect that a text states, as for a job's file.
#[must_use]
pub fn dialect_of(text: &[u8]) -> Option<Dialect> {
    jobs::player::of_text(text)
}

/// Reads a text to its end. `subs` gives the text of the file NAME.ngc that a subroutine of this name may
/// have.
///
/// # Errors
/// When files call each other too deep.
pub fn read<'t>(
    preflight: &mut Preflight<'_>,
    text: &'t [u8],
    subs: &dyn Fn(&str) -> Option<&'t [u8]>,
    motion: &mut Motion,
    listener: &mut dyn Listener,
) -> Result<(), &'static str> {
    run_to_end(read_on(preflight, text, subs, motion, listener))
}

async fn read_on<'t>(
    preflight: &mut Preflight<'_>,
    text: &'t [u8],
    subs: &dyn Fn(&str) -> Option<&'t [u8]>,
    motion: &mut Motion,
    listener: &mut dyn Listener,
) -> Result<(), &'static str> {
    let (mut text, mut place, mut own) = (text, Place::default(), LineBytes::new());
    let mut callers = heapless::Vec::<(&[u8], Place), MOST_CALLERS>::new();
    while let Some(rest) = text.get(place.offset as usize..).filter(|rest| !rest.is_empty()) {
        if preflight.has_ended() || listener.has_heard_enough() || preflight.is_endless(listener) {
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
        let next = preflight.line(line, (place, after), motion, listener).await;
        preflight.macro_lines(&mut own, motion, listener).await;
        place = match next {
            Next::Following => after,
            Next::At(place) => place,
            Next::FirstOf(name) => match subs(&name) {
                Some(sub) => {
                    callers.push((text, after)).map_err(|_| TOO_DEEP)?;
                    preflight.enter_file(true);
                    text = sub;
                    Place::default()
                }
                None => {
                    preflight.enter_file(false);
                    after
                }
            },
            Next::Returned => match callers.pop() {
                Some((caller, back)) => {
                    preflight.leave_file();
                    text = caller;
                    back
                }
                None => after,
            },
        };
    }
    preflight.end(motion, listener).await;
    Ok(())
}
