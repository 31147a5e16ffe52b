//! Geometry of a program as moves: lines, cut where that is asked for, and arcs, whole or as chords.
//!
//! All are iterators that end at the exact target, so an executor can stop between two points when the queue
//! is full. The iterators know positions only; feed rates and queues are the caller's.

mod arc;
mod chords;
mod line;
mod nurbs;
mod spline;

pub use arc::{Arc, ArcError, ArcParts, ArcShape, MOST_TURNS};
pub use chords::Chords;
pub use line::Line;
pub use nurbs::{Nurbs, ORDERS};
pub use spline::{Bezier, ParametricCurve, SplineMoves};
pub use units::{ArcSettings, LineSettings, Plane};
