//! State of a deployable probe.

/// State of the probe, as far as the machine knows.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Deployment {
    /// Not deployed.
    #[default]
    Stowed,
    /// Deployed by a search: stowed at its command's end.
    BySearch,
    /// Deployed by the command M401.
    ByCommand,
    /// Unknown, since the script that moves the probe did not come to its end.
    Unknown,
}
