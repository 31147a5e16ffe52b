//! The file of saved settings: M500, M501, M502.

use base::failure::{Answer, Outcome, Texts};
use base::paths::{OVERRIDE_PATH, override_path};
use base::ports::{StorageError, Wake};
use base::safe_file;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};

use crate::machine::{Machine, card, saved_settings, suspend};

/// Reads the file of saved settings as a script (M501).
pub(crate) fn load<P: Ports>(machine: &mut Machine<'_, P>, set: Option<&str>, to: Recipient) -> Outcome {
    let path = override_path(machine.world.texts, set)?;
    if let Err(error) = suspend::begin_replay(machine, &path, to, false) {
        machine.say(to, format_args!("failed to load configuration override {path}: {}\n", error.text()));
    }
    Ok(Answer::Ok)
}

/// Saves the settings (M500). At a power loss the file is the old one or the new one.
pub(crate) fn save<P: Ports>(machine: &mut Machine<'_, P>, set: Option<&str>, to: Recipient) -> Outcome {
    let path = override_path(machine.world.texts, set)?;
    let failed = |error: StorageError| machine.world.texts.about_file(&path, error.text());
    let mut draft = safe_file::Draft::begin(&mut machine.world.ports, &path).map_err(failed)?;
    for part in 0..saved_settings::PARTS {
        let Machine { program, tuning, bed, thermal, world: World { ports, config, .. }, .. } = machine;
        let written = match saved_settings::part(part, ports, program, config, (tuning, thermal), bed) {
            Ok(text) => draft.write(ports, text.as_bytes()).map(|_| ()),
            Err(_) => Err(StorageError::Full),
        };
        if let Err(error) = written {
            draft.give_up(&mut machine.world.ports);
            return Err(failed(error));
        }
        machine.wait(Wake::Any).whatever_happens();
        card::at_rest(machine);
    }
    card::finish(machine, draft).map_err(failed)?;
    if path == OVERRIDE_PATH && !machine.world.config.general.config_override {
        machine.say(to, format_args!("WARNING: override will NOT be loaded on boot\n"));
    }
    machine.say(to, format_args!("Settings Stored to {path}\n"));
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
