//! Troubles of motor drivers, and their texts for people.

/// Trouble that a driver can have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DriverTrouble {
    /// Warning of high temperature.
    OverTemperatureWarning,
    /// Shutdown by high temperature.
    OverTemperature,
    /// Short to ground, coil A.
    ShortA,
    /// Short to ground, coil B.
    ShortB,
    /// Short to the motor supply, coil A.
    SupplyShortA,
    /// Short to the motor supply, coil B.
    SupplyShortB,
    /// No answer, or no sensible answer.
    Silent,
    /// No current through coil A.
    OpenA,
    /// No current through coil B.
    OpenB,
    /// The driver alone was without power, and has been set up again.
    Reset,
}

impl DriverTrouble {
    pub(super) const ALL: [Self; 10] = [
        Self::OverTemperatureWarning,
        Self::OverTemperature,
        Self::ShortA,
        Self::ShortB,
        Self::SupplyShortA,
        Self::SupplyShortB,
        Self::Silent,
        Self::OpenA,
        Self::OpenB,
        Self::Reset,
    ];

    /// Returns whether the motor must stop.
    #[must_use]
    pub const fn is_fatal(self) -> bool {
        !matches!(self, Self::OverTemperatureWarning | Self::OpenA | Self::OpenB)
    }

    /// Returns whether the driver has shut its bridges, so that the motor holds nothing.
    #[must_use]
    pub const fn is_off(self) -> bool {
        self.is_fatal() && !matches!(self, Self::Silent)
    }

    /// Returns the trouble as a text for people.
    #[must_use]
    pub const fn text(self) -> &'static str {
        match self {
            Self::OverTemperatureWarning => {
                "Overtemperature Prewarning: the driver is above 100 C: lower its current (M906), or cool it"
            }
            Self::OverTemperature => {
                "Overtemperature Shutdown: the motor was off and is elsewhere: let it cool, lower its current, home"
            }
            Self::ShortA => "SHORT to ground on channel A",
            Self::ShortB => "SHORT to ground on channel B",
            Self::SupplyShortA => "SHORT to supply on channel A",
            Self::SupplyShortB => "SHORT to supply on channel B",
            Self::OpenA => "no current through coil A: check the motor's plug and cable",
            Self::OpenB => "no current through coil B: check the motor's plug and cable",
            Self::Reset => "the driver was without power, the motor was off and is elsewhere: check its supply, home",
            Self::Silent => "driver does not answer, check its supply and wiring",
        }
    }

    pub(super) const fn bit(self) -> u16 {
        1 << self as u16
    }
}
