//! Temperature controls and switches, by their places in the machine's description.

/// Greatest number of temperature controls: seven analog inputs and one SPI sensor.
pub const MAX_HEATERS: usize = 8;

/// A temperature control of this machine. Only the machine's description turns a user's number into an id.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeaterId(u8);

impl HeaterId {
    /// Returns the control's place in lists that are kept in the description's order.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// Returns every id that a machine can have, in the description's order.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..MAX_HEATERS as u8).map(Self)
    }
}

/// A switch of this machine, by its place in the machine's description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SwitchId(pub u8);

impl SwitchId {
    /// Returns the switch's place in lists that are kept in the description's order.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}
