//! The password of network consoles: set by a command, kept on the card as a record by which it is verified.

use base::failure::{Answer, Failure, Outcome};
use base::hands::Hands;
use base::ports::{Network as _, OpenMode, PASSWORD_RECORD_BYTES, PasswordRecord, Storage, StorageError, Wake};
use base::safe_file::{self, Draft};

/// Path of the record. The name is its own short name (8.3), so the file has no second one.
pub(super) const PATH: &str = "/sd/netpass";
/// Path of the record before, which is not to stay on the card.
const BEFORE: &str = "/sd/previous-netpass";
/// Least and greatest length of a password, bytes.
const LENGTHS: core::ops::RangeInclusive<usize> = 8..=63;

/// Whether a path is that of the record, which nobody is shown.
pub(crate) fn is_record(path: &str) -> bool {
    path.rsplit('/').next().is_some_and(|name| name.eq_ignore_ascii_case("netpass"))
}

/// Reads the record from the card into the network.
///
/// # Errors
/// Why there is no usable record, if there is a file.
pub(super) fn load<P: base::Ports>(ports: &mut P) -> Result<(), &'static str> {
    let record = read(ports).map_err(StorageError::text)?;
    match record {
        Some(record) => ports.set_password_record(Some(&record)),
        None => Ok(()),
    }
}

fn read(storage: &mut impl Storage) -> Result<Option<PasswordRecord>, StorageError> {
    match safe_file::settle(storage, PATH) {
        // A machine without a card has no password.
        Err(StorageError::NoCard | StorageError::NotResponding) => return Ok(None),
        settled => settled?,
    }
    let file = match storage.open(PATH, OpenMode::Read) {
        Err(StorageError::NotFound) => return Ok(None),
        opened => opened?,
    };
    let mut bytes = [0; PASSWORD_RECORD_BYTES];
    let count = storage.read(file, &mut bytes)?;
    storage.close(file)?;
    let text = bytes.get(..count).unwrap_or_default().trim_ascii();
    Ok(PasswordRecord::from_slice(text).ok())
}

fn write(storage: &mut impl Storage, record: &[u8]) -> Result<(), StorageError> {
    let mut draft = Draft::begin(storage, PATH)?;
    if let Err(error) = draft.write(storage, record) {
        draft.give_up(storage);
        return Err(error);
    }
    draft.finish(storage)?;
    remove(storage, BEFORE)
}

fn remove(storage: &mut impl Storage, path: &str) -> Result<(), StorageError> {
    match storage.remove(path) {
        Err(StorageError::NotFound) => Ok(()),
        removed => removed,
    }
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
    write(hands.storage(), &record).map_err(|error| hands.texts().because(error.text()))?;
    hands.storage().set_password_record(Some(&record)).map_err(|why| hands.texts().because(why))?;
    hands.say(format_args!("Consoles of the network ask for this password from now on\n"));
    Ok(Answer::Ok)
}

fn forget<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    remove(hands.storage(), PATH).map_err(|error| hands.texts().because(error.text()))?;
    hands.storage().set_password_record(None).map_err(|why| hands.texts().because(why))?;
    Ok(Answer::Ok)
}
