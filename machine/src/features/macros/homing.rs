//! `[homing_override]`: a template in place of G28. A G28 within it homes.

use core::fmt::Write as _;

use base::failure::{Failure, Outcome};
use base::sessions::Recipient;
use heapless::String;
use printer_cfg::Section;
use program::State;
use units::{Axis, AxisSet, PerAxis};

use super::calls::{self, Shares};
use super::hands::{MacroHands, OVERRIDE, read_option};
use super::look::Parameters;
use crate::machine::homing;

/// Homes these axes, or all where none is named, for who asks otherwise than by G28. None: nothing stands for
/// that.
pub(super) fn home<'c>(hands: &mut impl MacroHands<'c>, named: AxisSet, to: Recipient) -> Option<Outcome> {
    let mut words = String::<16>::new();
    for axis in named.axes() {
        // There is room for the letters of all axes.
        let _ = write!(words, "{} ", axis.letter());
    }
    begin(hands, &words, to)
}

/// Begins the template for a G28 with these words. None: G28 homes as ever.
pub(super) fn begin<'c>(hands: &mut impl MacroHands<'c>, words: &str, to: Recipient) -> Option<Outcome> {
    let store = &hands.macros().memory.store;
    let section = store.section(OVERRIDE)?;
    if store.is_called(section) || hands.state() == State::Check {
        return None;
    }
    let letters = || words.split_ascii_whitespace().filter_map(|word| word.chars().next());
    let named = AxisSet::collect(letters().filter_map(|letter| Axis::from_letter(letter.to_ascii_uppercase())));
    match stands_for(hands, section, named) {
        Ok(false) => None,
        Ok(true) => Some(run(hands, section, words, to)),
        Err(failure) => Some(Err(failure)),
    }
}

/// Whether the template stands for homing these axes.
fn stands_for<'c>(hands: &mut impl MacroHands<'c>, section: Section, named: AxisSet) -> Result<bool, Failure> {
    let is_written = read_option(hands, section, "axes")?;
    let axes = if is_written { hands.macros().memory.text.text().unwrap_or("") } else { "xyz" };
    let axes = AxisSet::collect(axes.chars().filter_map(|letter| Axis::from_letter(letter.to_ascii_uppercase())));
    Ok(named.is_empty() || !named.and(axes).is_empty())
}

fn run<'c>(hands: &mut impl MacroHands<'c>, section: Section, words: &str, to: Recipient) -> Outcome {
    let mut places = PerAxis::default();
    for (axis, key) in [(Axis::X, "set_position_x"), (Axis::Y, "set_position_y"), (Axis::Z, "set_position_z")] {
        if !read_option(hands, section, key)? {
            continue;
        }
        places[axis] = hands.macros().memory.text.text().and_then(gcode::read_f64);
        if places[axis].is_none() {
            return Err(hands.world().texts.refused(format_args!("[{OVERRIDE}] {key}: this is no number")));
        }
    }
    if places.0.iter().any(Option::is_some) {
        homing::set_position(hands, &places, true)?;
        hands.resynchronise_if_still();
    }
    calls::call(hands, section, "gcode", &Parameters::Coded(words), to, Shares::No)
}
