//! Whether the probe is out.

/// Whether the probe is out, as far as the machine knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Deployment {
    #[default]
    Stowed,
    /// By a search: stowed at its command's end.
    BySearch,
    /// By M401.
    ByCommand,
    /// The script that moves it did not come to its end.
    Unknown,
}
