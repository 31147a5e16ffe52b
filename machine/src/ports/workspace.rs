//! What a look ahead at files works with.

use motion::Motion;
use program::Interpreter;

/// A second motion object, of which no step is made, and a second program. Large, and looked at only while
/// there is nothing else to do: a board gives it memory that need not be fast.
#[derive(Debug)]
pub struct Workspace {
    pub(crate) motion: Motion,
    /// `None` before the configuration has been read.
    pub(crate) program: Option<Interpreter>,
}

impl Workspace {
    /// With a motion object that nothing else uses.
    #[must_use]
    pub const fn new(motion: Motion) -> Self {
        Self { motion, program: None }
    }
}
