//! Strips of lights: colours as the host wants them, sent at once.

use crate::reason::Reason;

/// Most bytes of a strip, which is the limit of hosts as well.
pub const MOST_BYTES: usize = 500;
/// Strips that there is memory for.
pub const MOST_STRIPS: usize = 4;

/// A strip with its colours.
#[derive(Debug)]
pub struct Lights<S> {
    /// The strip, on the board.
    pub strip: S,
    /// Colours, in the order of the line.
    pub bytes: heapless::Vec<u8, MOST_BYTES>,
}

impl<S> Lights<S> {
    /// A strip all of whose lights are dark.
    ///
    /// # Errors
    /// No colours, or too many.
    pub fn new(strip: S, size: u32) -> Result<Self, Reason> {
        let mut bytes = heapless::Vec::new();
        if size == 0 || bytes.resize(size as usize, 0).is_err() {
            return Err(Reason::LightsSize);
        }
        Ok(Self { strip, bytes })
    }

    /// Changes colours from byte `place` on.
    ///
    /// # Errors
    /// More than the strip has.
    pub fn update(&mut self, place: u32, colours: &[u8]) -> Result<(), Reason> {
        let place = place as usize;
        let part = self.bytes.get_mut(place..).and_then(|rest| rest.get_mut(..colours.len()));
        part.ok_or(Reason::LightsUpdate)?.copy_from_slice(colours);
        Ok(())
    }
}
