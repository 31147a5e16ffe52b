//! Interface between a host and the device at the other end of the cable: the level of USB 2.0 chapters 7 and
//! 8, transaction by transaction, at full speed.

/// The two data packet identifiers that alternate.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Toggle {
    /// Data packet identifier DATA0.
    #[default]
    Data0,
    /// Data packet identifier DATA1.
    Data1,
}

impl Toggle {
    /// Returns the other data packet identifier.
    #[must_use]
    pub const fn flipped(self) -> Self {
        match self {
            Self::Data0 => Self::Data1,
            Self::Data1 => Self::Data0,
        }
    }
}

/// Address in a token.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Address {
    /// Address of the device, 0 to 127.
    pub device: u8,
    /// Number of the endpoint, 0 to 15, without its direction.
    pub endpoint: u8,
}

/// The answer to data from the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Handshake {
    /// The device has taken the data.
    Ack,
    /// The device cannot take the data now.
    Nak,
    /// The endpoint is halted, or the request is not supported.
    Stall,
    /// No answer within the bus's time-out of 18 bit times.
    Nothing,
}

/// The answer to an IN token.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Reply {
    /// A data packet with its toggle.
    Data(Toggle, Vec<u8>),
    /// The device has nothing to send now.
    Nak,
    /// The endpoint is halted, or the request is not supported.
    Stall,
    /// No answer within the bus's time-out.
    Nothing,
}

/// State that the host's port drives on the lines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drive {
    /// No cable, or a port without power.
    #[default]
    Unplugged,
    /// Idle lines, which become suspend.
    Idle,
    /// Both lines low: bus reset.
    Reset,
    /// K state, which is resume signalling.
    Resume,
    /// Frames of a millisecond, each with its SOF.
    Frames,
}

/// The device at the end of the cable.
pub trait Function {
    /// Whether the device holds D+ up and so signals a connection at full speed.
    fn pulls_up(&self) -> bool;

    /// Whether the device drives K: remote wake-up.
    fn wakes(&self) -> bool;

    /// Sets the state that the host's port drives from `now_ns` on, nanoseconds.
    fn port(&mut self, now_ns: u64, drive: Drive);

    /// Starts a frame with this number of 11 bits.
    fn start_of_frame(&mut self, now_ns: u64, number: u16);

    /// Handles a SETUP transaction.
    fn setup(&mut self, to: Address, packet: [u8; 8]) -> Handshake;

    /// Handles an OUT transaction.
    fn out(&mut self, to: Address, toggle: Toggle, data: &[u8]) -> Handshake;

    /// Answers an IN token. A data packet stays until [`Self::acknowledge`].
    fn poll(&mut self, from: Address) -> Reply;

    /// Takes note that the host has acknowledged the data packet.
    fn acknowledge(&mut self, from: Address);

    /// Whether a reason for an answer NAK may have changed since the last question.
    fn stirred(&mut self) -> bool;
}
