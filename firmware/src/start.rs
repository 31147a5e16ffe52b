//! The reason for this start, for the machine.

use base::ports::{LastWords, Start};
use bsp_prime::identity::{Cause, Identity};

/// Returns the reason for this start.
pub fn reason(identity: &Identity) -> Start {
    match (identity.reset_cause, &identity.last_words) {
        (Cause::Watchdog, _) => Start::Watchdog,
        (Cause::BrownOut, _) => Start::BrownOut,
        // A text has no more bytes than there is room for.
        (Cause::Software, Some(text)) => Start::Ended(LastWords::try_from(text.as_str()).unwrap_or_default()),
        _ => Start::Asked,
    }
}
