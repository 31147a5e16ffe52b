//! Which heater is meant, and the highest temperature that is set of it.

use core::fmt::Write as _;

use config::{MachineConfig, ToolId};
use program::Words;
use units::{Celsius, HeaterId};

use crate::failure::{Failure, FailureKind, Texts, short};

/// The heater that a word names by its `tool_id`.
///
/// # Errors
/// When nobody has it: those there are.
pub(crate) fn heater_named(
    texts: &Texts,
    config: &MachineConfig,
    number: u16,
    letter: char,
    word: f64,
) -> Result<HeaterId, Failure> {
    let id = ToolId::from_word(word).and_then(|id| config.heater_with(id));
    id.ok_or_else(|| {
        let mut text = short(format_args!("M{number}: no temperature control has tool_id {word}; there are"));
        for (place, (_, heater)) in config.heaters().enumerate() {
            let comma = if place == 0 { "" } else { "," };
            // What does not fit any more is left out.
            let _ = write!(text, "{comma} {letter}{} {}", heater.tool_id, heater.name);
        }
        texts.keep(FailureKind::Refused, &text)
    })
}

/// Which heater M143 sets to which maximum; none where it only asks.
///
/// # Errors
/// When nobody has that id.
pub(crate) fn maximum_of(
    texts: &Texts,
    config: &MachineConfig,
    words: &Words<'_>,
) -> Result<Option<(HeaterId, Celsius)>, Failure> {
    let named = words.get('S').map(|word| heater_named(texts, config, words.code().number, 'S', word)).transpose()?;
    let most = words.get('P').filter(|most| *most > 0.0).map(|most| Celsius(most as f32));
    Ok(named.zip(most))
}
