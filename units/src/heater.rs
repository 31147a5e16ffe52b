//! Temperature controls and switches, by their places in the machine's description.

/// Temperature controls at most: seven analog inputs and one SPI sensor.
pub const MAX_HEATERS: usize = 8;

/// A temperature control of this machine. What a user writes becomes one by the machine's description alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeaterId(u8);

impl HeaterId {
    /// Its place in lists that are kept in the description's order.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// Every id a machine can have, in the description's order.
    pub fn all() -> impl Iterator<Item = Self> {
        (0..MAX_HEATERS as u8).map(Self)
    }
}

/// A switch of this machine, by its place in the machine's description.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SwitchId(pub u8);

impl SwitchId {
    /// Its place in lists that are kept in the description's order.
    #[must_use]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}
