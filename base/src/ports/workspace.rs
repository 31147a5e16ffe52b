//! Memory for preflight, the look ahead at files.

use motion::Motion;
use program::Interpreter;

/// Second motion object, of which no step is made, and second program. Large, and used only while there is
/// nothing else to do: a board gives it memory that need not be fast.
#[derive(Debug)]
pub struct Workspace {
    /// The second motion object, which makes no steps.
    pub motion: Motion,
    /// Program state; `None` before the configuration has been read.
    pub program: Option<Interpreter>,
}

impl Workspace {
    /// Starts with a motion object that nothing else uses.
    #[must_use]
    pub const fn new(motion: Motion) -> Self {
        Self { motion, program: None }
    }
}
