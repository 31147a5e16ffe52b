//! Colours that codes have given to LED strips. [`crate::lights`] decides what is sent to the strips.

use config::{MAX_STRIPS, MOST_LIGHTS};
use heapless::Vec;
use program::{LightChange, Lights};
use units::Colour;

/// Range of a strip's lights among all lights.
#[derive(Clone, Copy, Debug, Default)]
struct Span {
    first: u16,
    count: u16,
    /// Place of the lights that come next ([`Lights::Next`]).
    next: u16,
}

/// Colours of all strips.
#[derive(Debug)]
pub struct Strips {
    spans: Vec<Span, MAX_STRIPS>,
    colours: [Colour; MOST_LIGHTS as usize],
    /// Strips whose colours have changed and are to be shown, one bit each.
    changed: u8,
}

impl Default for Strips {
    fn default() -> Self {
        Self::new()
    }
}

impl Strips {
    /// Starts without any strips.
    #[must_use]
    pub const fn new() -> Self {
        Self { spans: Vec::new(), colours: [Colour::BLACK; MOST_LIGHTS as usize], changed: 0 }
    }

    /// Adds the next strip, in the configuration's order, all of it in this colour. False when there is no
    /// room.
    #[must_use]
    pub fn add(&mut self, count: u16, colour: Colour) -> bool {
        let first = self.spans.last().map_or(0, |last| last.first + last.count);
        let place = self.spans.len();
        if first + count > MOST_LIGHTS || self.spans.push(Span { first, count, next: 0 }).is_err() {
            return false;
        }
        self.changed |= 1 << place;
        self.lights_mut(place, 0, count).fill(colour);
        true
    }

    /// Changes the colours of lights.
    pub fn change(&mut self, change: &LightChange) {
        for place in 0..self.spans.len() {
            if change.strip.is_none_or(|strip| usize::from(strip) == place) {
                self.change_one(place, change);
            }
        }
    }

    fn change_one(&mut self, place: usize, change: &LightChange) {
        let Some(span) = self.spans.get_mut(place) else { return };
        let (from, count) = match change.which {
            Lights::All => (0, span.count),
            Lights::One(light) => (light, 1),
            Lights::Next { count, more } => {
                let from = span.next;
                span.next = if more { from.saturating_add(count).min(span.count) } else { 0 };
                (from, count)
            }
        };
        for colour in self.lights_mut(place, from, count) {
            let mut parts = colour.parts();
            for (part, to) in parts.iter_mut().zip(change.parts) {
                *part = to.unwrap_or(*part);
            }
            *colour = Colour::from_parts(parts);
        }
        self.changed |= u8::from(change.shown) << place;
    }

    /// Returns so many lights of a strip from this one on, as far as the strip has them.
    fn lights_mut(&mut self, place: usize, from: u16, count: u16) -> &mut [Colour] {
        let Some(span) = self.spans.get(place) else { return &mut [] };
        let (from, to) = (from.min(span.count), from.saturating_add(count).min(span.count));
        let range = usize::from(span.first + from)..usize::from(span.first + to);
        self.colours.get_mut(range).unwrap_or_default()
    }

    /// Returns the colours of a strip.
    #[must_use]
    pub fn colours(&self, place: usize) -> &[Colour] {
        let Some(span) = self.spans.get(place) else { return &[] };
        let first = usize::from(span.first);
        self.colours.get(first..first + usize::from(span.count)).unwrap_or_default()
    }

    /// Takes the strips whose colours have changed since the last call, one bit each.
    pub const fn take_changed(&mut self) -> u8 {
        core::mem::replace(&mut self.changed, 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::vec::Vec as List;

    const RED: Colour = Colour::rgb(255, 0, 0);
    const WHOLE: LightChange = LightChange {
        strip: None,
        which: Lights::All,
        parts: [Some(255), Some(0), Some(0), Some(0)],
        shown: true,
        rides: true,
    };

    fn two() -> Strips {
        let mut strips = Strips::new();
        assert!(strips.add(3, Colour::BLACK) && strips.add(2, Colour::rgb(1, 2, 3)));
        assert_eq!(strips.take_changed(), 0b11);
        strips
    }

    fn reds(strips: &Strips, place: usize) -> List<u8> {
        strips.colours(place).iter().map(|colour| colour.red).collect()
    }

    #[test]
    fn a_change_is_of_one_strip_or_of_all_of_one_light_or_of_all() {
        let mut strips = two();
        strips.change(&LightChange { strip: Some(1), ..WHOLE });
        assert_eq!((reds(&strips, 0), reds(&strips, 1)), (vec![0; 3], vec![255; 2]));
        assert_eq!([strips.take_changed(), strips.take_changed()], [0b10, 0]);
        strips.change(&LightChange { which: Lights::One(2), ..WHOLE });
        assert_eq!((reds(&strips, 0), strips.take_changed()), (vec![0, 0, 255], 0b11));
    }

    #[test]
    fn what_is_not_named_stays() {
        let mut strips = two();
        strips.change(&LightChange { strip: Some(1), parts: [None, Some(9), None, None], ..WHOLE });
        assert_eq!(strips.colours(1), [Colour::rgb(1, 9, 3); 2]);
    }

    #[test]
    fn the_next_lights_begin_where_the_last_ended_until_no_more_follow() {
        let mut strips = two();
        let next = |count, more| LightChange { strip: Some(0), which: Lights::Next { count, more }, ..WHOLE };
        strips.change(&LightChange { parts: [Some(1), None, None, None], ..next(1, true) });
        strips.change(&LightChange { parts: [Some(2), None, None, None], ..next(9, false) });
        assert_eq!(reds(&strips, 0), [1, 2, 2]);
        strips.change(&LightChange { parts: [Some(3), None, None, None], ..next(1, false) });
        assert_eq!(reds(&strips, 0), [3, 2, 2]);
    }

    #[test]
    fn what_is_held_back_is_seen_with_the_next_change() {
        let mut strips = two();
        strips.change(&LightChange { which: Lights::One(0), shown: false, ..WHOLE });
        assert_eq!((strips.take_changed(), reds(&strips, 0)), (0, vec![255, 0, 0]));
    }

    #[test]
    fn there_is_room_for_so_many_lights_and_strips_and_no_more() {
        let mut strips = Strips::new();
        assert!(strips.add(MOST_LIGHTS, RED) && !strips.add(1, RED));
        assert!(strips.colours(0).iter().all(|colour| *colour == RED) && strips.colours(1).is_empty());
        let mut strips = Strips::new();
        assert!((0..MAX_STRIPS).all(|_| strips.add(1, RED)) && !strips.add(1, RED));
        strips.change(&LightChange { strip: Some(7), which: Lights::One(700), ..WHOLE });
    }
}
