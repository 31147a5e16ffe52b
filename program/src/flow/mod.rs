//! Order of a program's lines (subroutines, conditions, loops), and the parameters that conditions read.

mod line_order;
pub(crate) mod memory;

pub(crate) use line_order::{Change, MOST_CALLS};
pub use line_order::{Flow, FlowFault, FlowProblem, Next, Place};
