//! Macros, as viewers are told of them: a few at a look, as each is read from the card.

use base::ports::{Storage as _, Viewers as _};
use heapless::Vec;

use super::hands::{MacroHands, Seen};

/// Most macros that are told at a look.
const AT_ONCE: usize = 4;
/// Most bytes of what a macro says of itself that are told.
const ABOUT_BYTES: usize = 96;

/// Tells viewers of the macros that they want to be told of, once the card is free.
///
/// Never inlined: a file that is read takes half a kilobyte of the stack, which every wait would have below
/// it.
#[inline(never)]
pub(super) fn tell<'c>(hands: &mut impl MacroHands<'c>) {
    let Seen { macros, world, .. } = hands.seen();
    for _ in 0..AT_ONCE {
        let Some(number) = world.ports.wants_macro() else { return };
        if !world.ports.is_ready() {
            return;
        }
        let store = &macros.memory.store;
        let section = store.macro_at(number);
        // A list whose rest cannot be read ends there: the console says why when a macro is called.
        let name = section.and_then(|section| store.name(section, &mut world.ports).ok());
        let mut about = Vec::<u8, ABOUT_BYTES>::new();
        if let Some(section) = section {
            let _ = store.read((section, "description"), &mut world.ports, |text| {
                about.extend(text.take(ABOUT_BYTES).map(|byte| if byte.is_ascii_control() { b' ' } else { byte }));
            });
        }
        let whole = match core::str::from_utf8(&about) {
            Ok(text) => text,
            // A character was cut.
            Err(error) => {
                about.get(..error.valid_up_to()).and_then(|text| core::str::from_utf8(text).ok()).unwrap_or("")
            }
        };
        world.ports.show_macro(number, name.as_deref().map(|name| (name, whole)));
    }
}
