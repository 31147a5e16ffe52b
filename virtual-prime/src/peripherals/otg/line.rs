//! The state of the cable, as the core sees it.

use usb_host::wire::Drive;

/// State of the line as the core sees it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Link {
    pub(super) drive: Drive,
    /// Instant at which the line fell idle with the pull-up on.
    pub(super) idle_since: Option<u64>,
    pub(super) early: bool,
    pub(super) suspended: bool,
    pub(super) frame: u16,
    /// Whether a bus reset began, and is to be announced once the transceiver's clock runs.
    pub(super) unannounced: bool,
    /// Instant at which a connection that firmware asked for is checked.
    pub(super) judged_at: Option<u64>,
    pub(super) deaf_until: u64,
}

impl Link {
    /// Returns the state after a reset of the core: the port at the other end is unchanged.
    pub fn reset(self) -> Self {
        Self { drive: self.drive, ..Self::default() }
    }

    /// Returns the number of the last frame.
    pub const fn frame(&self) -> u16 {
        self.frame
    }

    /// Notes the number of the frame that has begun.
    pub const fn set_frame(&mut self, number: u16) {
        self.frame = number;
    }

    /// Returns whether the bus is suspended.
    pub const fn is_suspended(&self) -> bool {
        self.suspended
    }

    /// Returns whether the cable is plugged in.
    pub const fn is_plugged(&self) -> bool {
        !matches!(self.drive, Drive::Unplugged)
    }
}
