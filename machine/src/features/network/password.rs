//! The password of network consoles: set by a command, kept on the card as a record by which it is verified.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::ports::{Network as _, PASSWORD_RECORD_BYTES, StorageError, Wake};
use base::secrets::PASSWORD_PATH as PATH;

use super::kept;

/// Path of the record before, which is not to stay on the card.
const BEFORE: &str = "/sd/previous-netpass";
/// Least and greatest length of a password, bytes.
const LENGTHS: core::ops::RangeInclusive<usize> = 8..=63;

/// Reads the record from the card into the network.
///
/// # Errors
/// Why there is no usable record, if there is a file.
pub(super) fn load<P: base::Ports>(ports: &mut P) -> Result<(), &'static str> {
    let record = kept::read::<PASSWORD_RECORD_BYTES>(ports, PATH).map_err(StorageError::text)?;
    match record {
        Some(record) => ports.set_password_record(Some(record.trim_ascii())),
        None => Ok(()),
    }
}

/// Keeps the password that a visitor of the page has set, and tells whether it is kept. If not, the one
/// before stays in force.
pub(super) fn keep<P: base::Ports>(ports: &mut P) {
    let Some(record) = ports.take_password_record() else { return };
    let kept = kept::write(ports, PATH, BEFORE, &record).map_err(StorageError::text);
    let in_force = match kept {
        Ok(()) => ports.set_password_record(Some(&record)),
        Err(_) => ports.set_password_record(None).and_then(|()| load(ports)),
    };
    ports.tell_kept(kept.and(in_force));
}

/// Sets the password of network consoles: `password word`; `password off` forgets it.
pub(crate) fn set<'c>(hands: &mut impl Hands<'c>, word: &str) -> Outcome {
    if word == "off" {
        return forget(hands);
    }
    if word.is_empty() {
        return Err(Failure::refused(&"write password and a word of 8 to 63 letters, or password off"));
    }
    if !LENGTHS.contains(&word.len()) || word.bytes().any(|byte| !(0x20..0x7F).contains(&byte)) {
        return Err(Failure::refused(&"a password has 8 to 63 letters, digits and signs"));
    }
    if !hands.storage().begin_password(word.as_bytes()) {
        return Err(Failure::refused(&"there is no network: [network] enable"));
    }
    let record = loop {
        if let Some(record) = hands.storage().take_password_record() {
            break record;
        }
        hands.wait(Wake::Any).whatever_happens();
    };
    kept::write(hands.storage(), PATH, BEFORE, &record).map_err(|error| hands.texts().because(error.text()))?;
    hands.storage().set_password_record(Some(&record)).map_err(|why| hands.texts().because(why))?;
    hands.say(format_args!("Consoles of the network ask for this password from now on\n"));
    Ok(Answer::Ok)
}

fn forget<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    kept::remove(hands.storage(), PATH).map_err(|error| hands.texts().because(error.text()))?;
    hands.storage().set_password_record(None).map_err(|why| hands.texts().because(why))?;
    Ok(Answer::Ok)
}
