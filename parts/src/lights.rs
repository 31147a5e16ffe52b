//! Contents of LED strips: the colours that codes have given them, or, if configured and there is something
//! to see, the machine's state.

use config::{LedStripConfig, MAX_STRIPS, MOST_LIGHTS, StripShows};
use heapless::Vec;
use units::{Colour, ColourOrder, Micros};

/// Time between two looks at the strips.
const PERIOD: Micros = Micros::from_millis(50);
/// Half the period of blinking.
const BLINK: Micros = Micros::from_millis(500);

const HALTED: Colour = Colour::rgb(255, 0, 0);
const WAITING: Colour = Colour::rgb(255, 160, 0);
const HEATED: Colour = Colour::rgb(255, 60, 0);
const COLD: Colour = Colour::rgb(0, 0, 40);
const MADE: Colour = Colour::rgb(0, 200, 0);
const TO_MAKE: Colour = Colour::rgb(20, 20, 20);

/// State of the machine, as far as lights show it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Condition {
    /// Halted, asleep, or with a configuration that cannot be used.
    Halted,
    /// Waiting for a person: suspended, held, a program's pause, an open door.
    Waits,
    /// Warming up, with the share of the way.
    Heats(f32),
    /// Playing a file, with the share played.
    Makes(f32),
    /// None of the other conditions.
    Quiet,
}

/// Contents of a strip. Equal looks need no sending.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Look {
    /// Colours that codes have given.
    #[default]
    Codes,
    /// All lights in one colour.
    All(Colour),
    /// Number of lights in the first colour; the rest have the second.
    Bar(u16, Colour, Colour),
}

impl Look {
    fn of(condition: Condition, lights: u16, now: Micros) -> Self {
        // At least one light, and all of them only at the end.
        let bar = |share: f32| 1 + (units::within(share, 0.0, 1.0) * f32::from(lights.saturating_sub(1))) as u16;
        match condition {
            Condition::Halted if (now.0 / BLINK.0).is_multiple_of(2) => Self::All(HALTED),
            Condition::Halted => Self::All(Colour::BLACK),
            Condition::Waits => Self::All(WAITING),
            // A single light turns from the first colour into the second.
            Condition::Heats(share) if lights == 1 => Self::All(between(COLD, HEATED, share)),
            Condition::Makes(share) if lights == 1 => Self::All(between(TO_MAKE, MADE, share)),
            Condition::Heats(share) => Self::Bar(bar(share), HEATED, COLD),
            Condition::Makes(share) => Self::Bar(bar(share), MADE, TO_MAKE),
            Condition::Quiet => Self::Codes,
        }
    }

    /// Returns the colour of a light; none: the colour that codes have given.
    const fn colour(self, light: u16) -> Option<Colour> {
        match self {
            Self::Codes => None,
            Self::All(colour) => Some(colour),
            Self::Bar(lit, colour, _) if light < lit => Some(colour),
            Self::Bar(_, _, rest) => Some(rest),
        }
    }
}

/// Mixes two colours by a share; in steps, so that a slow change is no change each time.
fn between(from: Colour, to: Colour, share: f32) -> Colour {
    let share = libm::roundf(units::within(share, 0.0, 1.0) * 32.0) / 32.0;
    let mut parts = from.parts();
    for (part, to) in parts.iter_mut().zip(to.parts()) {
        let (start, end) = (f32::from(*part), f32::from(to));
        *part = (start + (end - start) * share) as u8;
    }
    Colour::from_parts(parts)
}

/// Bytes sent to a strip.
pub type StripBytes = Vec<u8, { MOST_LIGHTS as usize * 4 }>;

/// Contents of all strips.
#[derive(Debug, Default)]
pub struct LightShow {
    due: Micros,
    looks: [Look; MAX_STRIPS],
    /// Strips that are to be sent anew, one bit each.
    wanted: u8,
    was_halted: bool,
}

impl LightShow {
    /// Returns whether a look is due.
    pub fn is_due(&mut self, now: Micros) -> bool {
        let is_due = now >= self.due;
        if is_due {
            self.due = now.plus(PERIOD);
        }
        is_due
    }

    /// Takes over the machine's state. `changed` are strips whose colours codes have changed, one bit each.
    pub fn look(&mut self, strips: &[LedStripConfig], condition: Condition, changed: u8, now: Micros) {
        self.wanted |= changed;
        let is_halted = condition == Condition::Halted;
        if core::mem::replace(&mut self.was_halted, is_halted) && !is_halted {
            // A halt has switched off the outputs of switches.
            self.wanted |= ((1_u16 << strips.len()) - 1) as u8;
        }
        for (place, (strip, shown)) in strips.iter().zip(&mut self.looks).enumerate() {
            let look = match strip.shows {
                StripShows::Codes => Look::Codes,
                StripShows::State => Look::of(condition, strip.lights(), now),
            };
            if core::mem::replace(shown, look) != look {
                self.wanted |= 1 << place;
            }
        }
    }

    /// Returns the next strip that is to be sent.
    pub const fn next(&self) -> Option<usize> {
        if self.wanted == 0 { None } else { Some(self.wanted.trailing_zeros() as usize) }
    }

    /// Notes that a strip has been sent.
    pub const fn sent(&mut self, place: usize) {
        self.wanted &= !(1 << place);
    }

    /// Returns the colours to show on a strip that codes have given `told`, at the configured brightness.
    pub fn colours(&self, place: usize, strip: &LedStripConfig, told: &[Colour]) -> impl Iterator<Item = Colour> {
        let look = self.looks.get(place).copied().unwrap_or_default();
        let brightness = strip.brightness;
        (0..).zip(told).map(move |(light, told)| look.colour(light).unwrap_or(*told).dimmed(brightness))
    }

    /// Returns the same colours as bytes for the strip.
    pub fn bytes(&self, place: usize, strip: &LedStripConfig, told: &[Colour]) -> StripBytes {
        let order = strip.order.unwrap_or(ColourOrder::GRB);
        self.colours(place, strip, told).flat_map(|colour| order.bytes(colour)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn strip(shows: StripShows) -> LedStripConfig {
        LedStripConfig { chain_count: 5, brightness: 1.0, shows, ..LedStripConfig::default() }
    }

    const TOLD: [Colour; 5] = [Colour::rgb(1, 2, 3); 5];

    fn reds(show: &LightShow, strip: &LedStripConfig) -> [u8; 5] {
        let mut colours = show.colours(0, strip, &TOLD).map(|colour| colour.red);
        core::array::from_fn(|_| colours.next().expect("five lights"))
    }

    #[test]
    fn one_that_follows_codes_is_sent_when_they_change_it_and_never_else() {
        let strips = [strip(StripShows::Codes)];
        let mut show = LightShow::default();
        show.look(&strips, Condition::Makes(0.5), 0, Micros(0));
        show.look(&strips, Condition::Halted, 0, Micros(0));
        assert_eq!(show.next(), None);
        show.look(&strips, Condition::Quiet, 0, Micros(0));
        assert_eq!(show.next(), Some(0), "the halt is over");
        show.sent(0);
        show.look(&strips, Condition::Quiet, 1, Micros(0));
        assert_eq!(show.next(), Some(0));
        show.sent(0);
        assert_eq!((show.next(), reds(&show, &strips[0])), (None, [1; 5]));
    }

    #[test]
    fn the_state_is_shown_while_there_is_one_to_see() {
        let strips = [strip(StripShows::State)];
        let mut show = LightShow::default();
        for (condition, at_ms, expected) in [
            (Condition::Heats(0.0), 0, [255, 0, 0, 0, 0]),
            (Condition::Heats(0.5), 0, [255, 255, 255, 0, 0]),
            (Condition::Heats(1.0), 0, [255; 5]),
            (Condition::Makes(0.3), 0, [0, 0, 20, 20, 20]),
            (Condition::Waits, 0, [255; 5]),
            (Condition::Halted, 100, [255; 5]),
            (Condition::Halted, 600, [0; 5]),
            (Condition::Quiet, 0, [1; 5]),
        ] {
            show.look(&strips, condition, 0, Micros::from_millis(at_ms));
            assert_eq!((show.next(), reds(&show, &strips[0])), (Some(0), expected), "{condition:?} at {at_ms} ms");
            show.sent(0);
            show.look(&strips, condition, 0, Micros::from_millis(at_ms));
            assert_eq!(show.next(), None, "{condition:?}: nothing new");
        }
    }

    #[test]
    fn bytes_are_dimmed_and_in_the_order_of_the_chips() {
        let half = LedStripConfig { brightness: 0.5, order: ColourOrder::parse("RGBW"), ..strip(StripShows::Codes) };
        let told = [Colour { red: 200, green: 100, blue: 3, white: 255 }];
        assert_eq!(LightShow::default().bytes(0, &half, &told), [100, 50, 2, 128]);
    }

    #[test]
    fn a_single_light_turns_from_one_colour_into_the_other() {
        let at = |condition| Look::of(condition, 1, Micros(0)).colour(0);
        assert_eq!((at(Condition::Heats(0.0)), at(Condition::Heats(1.0))), (Some(COLD), Some(HEATED)));
        assert_eq!((at(Condition::Makes(0.0)), at(Condition::Makes(1.0))), (Some(TO_MAKE), Some(MADE)));
        let half = at(Condition::Makes(0.5));
        assert!(half != Some(MADE) && half != Some(TO_MAKE), "{half:?}");
    }

    #[test]
    fn a_bar_begins_with_one_light_and_is_whole_only_at_the_end() {
        for (share, lit) in [(0.0, 1), (0.5, 3), (0.99, 4), (1.0, 5), (7.0, 5)] {
            let look = Look::of(Condition::Makes(share), 5, Micros(0));
            assert_eq!((0..5).filter(|light| look.colour(*light) == Some(MADE)).count(), lit, "{share}");
        }
    }
}
