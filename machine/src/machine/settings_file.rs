//! The file of saved settings: M500, M501, M502.

use core::fmt;

use base::failure::{Answer, Outcome, Texts};
use base::paths::{OVERRIDE_PATH, override_path};
use base::ports::{StorageError, Wake};
use base::safe_file;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};

use crate::machine::work_hands::{JobHands, WaitHands};
use crate::machine::{Machine, card, saved_settings, suspend};

/// The machine for work that saves settings.
pub(crate) trait SettingsHands<'c>: WaitHands<'c> {
    /// Returns the lines of part n of [`saved_settings::PARTS`].
    ///
    /// # Errors
    /// When they do not fit whole.
    fn part(&mut self, n: u8) -> Result<saved_settings::Text, fmt::Error>;
}

impl<'c, P: Ports> SettingsHands<'c> for Machine<'c, P> {
    fn part(&mut self, n: u8) -> Result<saved_settings::Text, fmt::Error> {
        let Self { program, tuning, bed, thermal, world: World { ports, config, .. }, .. } = self;
        saved_settings::part(n, ports, program, config, (tuning, thermal), bed)
    }
}

/// Reads the file of saved settings as a script (M501).
pub(crate) fn load<'c>(hands: &mut impl JobHands<'c>, set: Option<&str>, to: Recipient) -> Outcome {
    let path = override_path(hands.world().texts, set)?;
    if let Err(error) = suspend::begin_replay(hands, &path, to, false) {
        hands.say(to, format_args!("failed to load configuration override {path}: {}\n", error.text()));
    }
    Ok(Answer::Ok)
}

/// Saves the settings (M500). At a power loss the file is the old one or the new one.
pub(crate) fn save<'c>(hands: &mut impl SettingsHands<'c>, set: Option<&str>, to: Recipient) -> Outcome {
    let path = override_path(hands.world().texts, set)?;
    let texts = hands.world().texts;
    let failed = |error: StorageError| texts.about_file(&path, error.text());
    let mut draft = safe_file::Draft::begin(&mut hands.world().ports, &path).map_err(failed)?;
    for part in 0..saved_settings::PARTS {
        let written = match hands.part(part) {
            Ok(text) => draft.write(&mut hands.world().ports, text.as_bytes()).map(|_| ()),
            Err(_) => Err(StorageError::Full),
        };
        if let Err(error) = written {
            draft.give_up(&mut hands.world().ports);
            return Err(failed(error));
        }
        hands.wait(Wake::Any).whatever_happens();
        card::at_rest(hands);
    }
    card::finish(hands, draft).map_err(failed)?;
    if path == OVERRIDE_PATH && !hands.world().config.general.config_override {
        hands.say(to, format_args!("WARNING: override will NOT be loaded on boot\n"));
    }
    hands.say(to, format_args!("Settings Stored to {path}\n"));
    Ok(Answer::Ok)
}

/// Deletes the file of saved settings (M502).
pub(crate) fn forget<P: Ports>(
    texts: &Texts,
    ports: &mut P,
    reply: &mut Reply<'_>,
    dialect: program::Dialect,
) -> Outcome {
    safe_file::remove(ports, OVERRIDE_PATH).map_err(|error| texts.about_file(OVERRIDE_PATH, error.text()))?;
    reply.say(format_args!("configuration override file deleted\n"));
    if program::Dialects::PRINTERS.has(dialect) {
        reply.say(format_args!("// NOTE what is in force stays until a reset, and M500 before it saves that again\n"));
    }
    Ok(Answer::Ok)
}
