//! Keys of programs that use the page's API: kept on the card, made and revoked by visitors of the page.

use base::Ports;
use base::ports::{KEYS_RECORD_BYTES, StorageError};
use base::secrets::KEYS_PATH as PATH;

use super::kept;

/// Path of the keys before, which are not to stay on the card.
const BEFORE: &str = "/sd/previous-netkeys";

/// Reads the keys from the card into the network.
///
/// # Errors
/// Why they cannot be read, if there is a file.
pub(super) fn load<P: Ports>(ports: &mut P) -> Result<(), &'static str> {
    let record = kept::read::<KEYS_RECORD_BYTES>(ports, PATH).map_err(StorageError::text)?;
    if let Some(record) = record {
        ports.set_keys_record(&record);
    }
    Ok(())
}

/// Keeps the keys that a visitor has changed, and tells whether they are kept.
pub(super) fn keep<P: Ports>(ports: &mut P) {
    let Some(record) = ports.take_keys_record() else { return };
    let kept = if record.is_empty() {
        kept::remove(ports, PATH).and_then(|()| kept::remove(ports, BEFORE))
    } else {
        kept::write(ports, PATH, BEFORE, &record)
    };
    ports.tell_kept(kept.map_err(StorageError::text));
}
