//! The heater that a code names, and the highest temperature that M143 sets for it.

use core::fmt::Write as _;

use base::failure::{Failure, FailureKind, Texts, short};
use config::{MachineConfig, ToolId};
use program::Words;
use units::{Celsius, HeaterId};

/// Returns the heater that a word names by its `tool_id`.
///
/// # Errors
/// When no heater has that id; the message lists the known ones.
pub fn heater_named(
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
            // Names that do not fit any more are left out.
            let _ = write!(text, "{comma} {letter}{} {}", heater.tool_id, heater.name);
        }
        texts.keep(FailureKind::Refused, &text)
    })
}

/// Returns the heater that a code names: by `letter` with its `tool_id`; by E in Marlin's dialect, in which
/// the bed is -1 and no E means the first hot end; by T in RepRapFirmware's. `None` if the code names no
/// heater.
///
/// # Errors
/// When no heater has that id; when there are words and none of them names a heater.
pub fn heater_of(
    texts: &Texts,
    config: &MachineConfig,
    words: &Words<'_>,
    letter: char,
) -> Result<Option<HeaterId>, Failure> {
    let number = words.code().number;
    let letter = ['E', 'T'].into_iter().find(|other| words.takes(*other)).unwrap_or(letter);
    match words.get(letter) {
        Some(-1.0) if letter == 'E' => bed(config).map(Some),
        Some(word) => heater_named(texts, config, number, letter, word).map(Some),
        None if words.is_bare() => Ok(None),
        None if letter == 'E' => heater_named(texts, config, number, letter, 0.0).map(Some),
        None => Err(texts.refused(format_args!("M{number}: {letter} must say which heater"))),
    }
}

/// Returns the bed: the heater that M140 sets.
///
/// # Errors
/// When the machine has no bed.
pub fn bed(config: &MachineConfig) -> Result<HeaterId, Failure> {
    let bed = config.heaters().find(|(_, heater)| heater.set_m_code == 140 && heater.heater_pin.is_some());
    bed.map(|(id, _)| id).ok_or_else(|| Failure::refused(&"there is no bed: no heater has set_m_code = 140"))
}

/// Returns the heater whose maximum M143 sets, and that maximum; `None` if M143 only asks.
///
/// # Errors
/// When no heater has that id.
pub fn maximum_of(
    texts: &Texts,
    config: &MachineConfig,
    words: &Words<'_>,
) -> Result<Option<(HeaterId, Celsius)>, Failure> {
    let named = words.get('S').map(|word| heater_named(texts, config, words.code().number, 'S', word)).transpose()?;
    let most = words.get('P').filter(|most| *most > 0.0).map(|most| Celsius(most as f32));
    Ok(named.zip(most))
}
