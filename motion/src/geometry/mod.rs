//! From what a program draws to straight moves: cutting of lines, and arcs.
//!
//! Both are iterators of target points that end at the exact target, so a dispatcher can stop between two points
//! when the queue is full. They know positions only; feed rates and queues are the caller's.

mod arc;
mod line;

pub use arc::{Arc, ArcError, ArcSettings, ArcShape, Plane};
pub use line::{Line, LineSettings};
