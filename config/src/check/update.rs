//! Checks of the settings for firmware updates.

use super::findings::Checks;

/// Checks that the key is valid, and that a lock has a key.
pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let update = checks.config.update;
    if update.key_is_flawed {
        let reason = format_args!("this is no Ed25519 public key");
        checks.error(
            ("update", 0, "key"),
            reason,
            format_args!("write the 64 hexadecimal digits that velvet key says"),
        );
    } else if update.locked && update.key.is_none() {
        let reason = format_args!("without a key no firmware would be the owner's");
        checks.error(("update", 0, "locked"), reason, format_args!("write key, or locked = false"));
    }
}
