//! Which line of a program comes next, and the parameters that its conditions read.

mod line_order;
pub(crate) mod memory;

pub(crate) use line_order::{Change, MOST_CALLS};
pub use line_order::{Flow, FlowFault, FlowProblem, Next, Place};
