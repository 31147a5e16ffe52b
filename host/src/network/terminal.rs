//! Terminal that somebody types at. Ctrl-C comes as a sign in the text rather than ending the program at
//! once, which would leave the terminal as it was set here.

#[cfg(unix)]
use rustix::termios::{LocalModes, OptionalActions, SpecialCodeIndex, Termios, tcgetattr, tcsetattr};

/// Sign that Ctrl-C gives.
pub const CTRL_C: u8 = 0x03;
/// Sign that Ctrl-X gives.
pub const CTRL_X: u8 = 0x18;
/// Code of the system for a key that does nothing.
#[cfg(unix)]
const NONE: u8 = 0;

/// The terminal as it was before, which it is again when this is dropped.
pub struct Terminal {
    #[cfg(unix)]
    before: Termios,
}

#[cfg(unix)]
impl Terminal {
    /// Has Ctrl-C and Ctrl-X end what is read, as the end of a line does. `hides` has nothing shown of what
    /// is typed. None if the standard input is no terminal.
    pub fn new(hides: bool) -> Option<Self> {
        let before = tcgetattr(std::io::stdin()).ok()?;
        let mut settings = before.clone();
        settings.special_codes[SpecialCodeIndex::VINTR] = NONE;
        settings.special_codes[SpecialCodeIndex::VEOL] = CTRL_X;
        settings.special_codes[SpecialCodeIndex::VEOL2] = CTRL_C;
        if hides {
            settings.local_modes.remove(LocalModes::ECHO);
        }
        tcsetattr(std::io::stdin(), OptionalActions::Now, &settings).ok()?;
        Some(Self { before })
    }

    /// Sets the terminal as it was before.
    pub fn restore(&self) {
        let _is_there = tcsetattr(std::io::stdin(), OptionalActions::Now, &self.before);
    }
}

#[cfg(not(unix))]
impl Terminal {
    /// Leaves the terminal as it is: Ctrl-C ends the program, Ctrl-X is sent with its line.
    pub fn new(_hides: bool) -> Option<Self> {
        None
    }

    /// Leaves the terminal alone, since nothing of it was changed.
    pub fn restore(&self) {}
}

impl Drop for Terminal {
    fn drop(&mut self) {
        self.restore();
    }
}
