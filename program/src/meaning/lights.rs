//! M150: the colour of lights, with the words of Marlin and of RepRapFirmware.

use crate::action::Effect;
use crate::context::{Context, Meaning, NOTHING};
use crate::fault::{Fault, Problem};
use crate::interpreter::Interpreter;
use crate::lights::{LightChange, Lights};
use crate::state::setup::StripSetup;
use crate::words::Words;
use gcode::Dialect;

/// Letters of red, green and blue (U in both firmwares), white.
const PARTS: [char; 4] = ['R', 'U', 'B', 'W'];

/// Sets one light, the next lights, or all lights of a strip or of the machine.
pub(crate) fn colour<'b>(program: &mut Interpreter, context: &Context<'b>) -> Result<Meaning<'b>, Fault> {
    let words = &context.words;
    let strips = &program.setup.strips;
    if strips.is_empty() {
        return Ok(Meaning::PassedOver);
    }
    let letter = if context.dialect == Dialect::RepRapFirmware { 'E' } else { 'S' };
    let place = match words.get(letter) {
        Some(number) => {
            Some(place_of(strips, number).ok_or(Problem::NoStrip(number).refused(words.column_of(letter)))?)
        }
        None => None,
    };
    let which = if context.dialect == Dialect::RepRapFirmware { next_ones(words) } else { one_or_all(words) };
    if let Lights::One(light) = which {
        let meant = |at: usize| place.is_none_or(|place| usize::from(place) == at);
        let longest = strips.iter().enumerate().filter(|(at, _)| meant(*at)).map(|(_, strip)| strip.lights).max();
        let lights = longest.unwrap_or(0);
        if light >= lights {
            return Err(Problem::NoLight(lights).refused(words.column_of('I')));
        }
    }
    let change = LightChange {
        strip: place,
        which,
        parts: PARTS.map(|letter| part(words, letter)),
        shown: words.get('T') != Some(0.0),
        rides: words.get('Q') != Some(0.0),
    };
    program.by_the_way(Effect::Light(change));
    NOTHING
}

fn place_of(strips: &[StripSetup], number: f64) -> Option<u8> {
    let place = strips.iter().position(|strip| f64::from(strip.number) == number);
    place.and_then(|place| u8::try_from(place).ok())
}

/// Returns the brightness of a colour: full if its word has no number, dark if the word is absent, or
/// unchanged if K is given. P scales all colours.
fn part(words: &Words<'_>, letter: char) -> Option<u8> {
    if !words.has(letter) {
        return (!words.has('K')).then_some(0);
    }
    let brightness = words.get('P').unwrap_or(255.0);
    Some(libm::round(words.get(letter).unwrap_or(255.0) * brightness / 255.0) as u8)
}

/// Reads Marlin's I, the index of a light.
fn one_or_all(words: &Words<'_>) -> Lights {
    words.get('I').map_or(Lights::All, |place| Lights::One(place as u16))
}

/// Reads RepRapFirmware's S, a number of lights, from the end of the last line with F1.
fn next_ones(words: &Words<'_>) -> Lights {
    let more = words.get('F') == Some(1.0);
    match words.get('S') {
        Some(count) => Lights::Next { count: count as u16, more },
        None if more => Lights::Next { count: 1, more },
        None => Lights::All,
    }
}
