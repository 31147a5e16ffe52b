//! What passes between a host and the device at the other end of the cable: the level of USB 2.0 chapters 7
//! and 8, transaction by transaction, at full speed.

/// The two data packet identifiers that alternate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Toggle {
    /// DATA0.
    #[default]
    Data0,
    /// DATA1.
    Data1,
}

impl Toggle {
    /// The other one.
    #[must_use]
    pub const fn flipped(self) -> Self {
        match self {
            Self::Data0 => Self::Data1,
            Self::Data1 => Self::Data0,
        }
    }
}

/// Whom a token is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Address {
    /// Of the device, 0 to 127.
    pub device: u8,
    /// Of the endpoint, 0 to 15, without its direction.
    pub endpoint: u8,
}

/// The answer to data from the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handshake {
    /// Taken.
    Ack,
    /// Not now.
    Nak,
    /// Halted, or a request that is not supported.
    Stall,
    /// None within the bus's time-out of 18 bit times.
    Nothing,
}

/// The answer to an IN token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// A data packet.
    Data(Toggle, Vec<u8>),
    /// Nothing to send now.
    Nak,
    /// Halted, or a request that is not supported.
    Stall,
    /// None within the bus's time-out.
    Nothing,
}

/// What the host's port does to the lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drive {
    /// No cable, or a port without power.
    #[default]
    Unplugged,
    /// Nothing: idle, which becomes suspend.
    Idle,
    /// Both lines low: bus reset.
    Reset,
    /// K: resume.
    Resume,
    /// Frames of a millisecond, each with its SOF.
    Frames,
}

/// The device's end.
pub trait Function {
    /// Whether it holds D+ up and so says that it is there, at full speed.
    fn pulls_up(&self) -> bool;

    /// Whether it drives K itself: remote wake-up.
    fn wakes(&self) -> bool;

    /// The host's port does this from now on; nanoseconds.
    fn port(&mut self, now_ns: u64, drive: Drive);

    /// A frame begins, with this number of 11 bits.
    fn start_of_frame(&mut self, now_ns: u64, number: u16);

    /// A SETUP transaction.
    fn setup(&mut self, to: Address, packet: [u8; 8]) -> Handshake;

    /// An OUT transaction.
    fn out(&mut self, to: Address, toggle: Toggle, data: &[u8]) -> Handshake;

    /// An IN token, and what comes back. A data packet stays until [`Self::acknowledge`].
    fn poll(&mut self, from: Address) -> Reply;

    /// The host has acknowledged the data packet.
    fn acknowledge(&mut self, from: Address);

    /// Whether something may have changed, since the last question, that made the device answer NAK.
    fn stirred(&mut self) -> bool;
}
