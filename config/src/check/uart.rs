//! Checks of the auxiliary UART's word format.

use super::findings::Checks;
use crate::machine::Parity;

/// A word carries a character, of seven or eight bits, and perhaps a parity bit.
pub(super) fn check(checks: &mut Checks<'_, '_>) {
    let uart = checks.config.uart;
    if !uart.enable {
        return;
    }
    match (uart.bits, uart.parity) {
        (7, Parity::Odd | Parity::Even) => {
            let reason = format_args!("a word of 7 bits of which one is parity carries no character");
            checks.error(("uart console", 0, "bits"), reason, format_args!("write bits = 8, or parity = none"));
        }
        (9, Parity::None) => {
            let reason = format_args!("a word of 9 bits without parity carries more than a byte");
            checks.error(("uart console", 0, "bits"), reason, format_args!("write bits = 8, or a parity"));
        }
        _ => {}
    }
}
