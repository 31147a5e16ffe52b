//! Dependence of a laser's power on the speed.

/// Power of a move over its speed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PowerLaw {
    /// The laser is off, whatever S says (M5).
    #[default]
    Off,
    /// Constant power (M3).
    Constant,
    /// Power in proportion to the actual speed along the path over the requested one (M4).
    BySpeed,
}
