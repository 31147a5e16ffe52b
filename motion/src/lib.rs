//! Motion, from moves to step events: lines, arcs, look-ahead, the trajectory in time, kinematics, step
//! times.
//!
//! The path of one move: [`Motion::submit`] turns the move into a block with its limits ([`planner`]); the
//! reverse pass of [`Motion::plan`] settles the speed at each junction; when the block's turn comes,
//! [`profile`] gives it a trapezoid in closed form. [`StepFeed::run`] takes that trajectory in slices of at
//! most half a millisecond ([`knots::Segment`]: each motor's position and speed at both ends, through the
//! [`Kinematics`]), solves the cubic between the ends for its step crossings ([`step_solver`]), merges the
//! motors in time order and fills the [`queue::StepQueue`], which the step interrupt plays.
//!
//! Three contexts share the work. The executor submits and the planner task plans, both under a brief lock
//! on [`Motion`]; the feed takes slices under the same lock and solves them without it; the interrupt touches
//! the queue's atomics alone. No allocation, no panic path, no `unsafe`, and only `+ - * /` and `libm`, so
//! that every machine computes the same step times to the last bit.
//!
//! The crate knows nothing of G-code, text, heaters or pins.
#![cfg_attr(not(any(test, feature = "oracle")), no_std)]
#![forbid(unsafe_code)]

mod arithmetic;
pub mod compensation;
pub mod config;
mod elsewhere;
mod event_merge;
pub mod feed;
mod feed_exchange;
pub mod feed_schedule;
pub mod filters;
pub mod geometry;
mod jerk_limited;
pub mod kinematics;
pub mod knots;
pub mod laser;
mod motion;
mod motor;
mod move_ends;
mod moves;
#[cfg(any(test, feature = "oracle"))]
pub mod oracle;
pub mod path;
pub mod planner;
pub mod profile;
pub mod queue;
mod ramp;
mod rewind;
mod run;
mod series;
pub mod step_solver;
mod store;
#[cfg(test)]
mod tests;
pub mod timeline;
pub mod trajectory;
pub mod trigger;

pub use arithmetic::use_square_root;
pub(crate) use arithmetic::{greatest, least, square_root};
pub use compensation::{
    Compensation, CompensationError, Fade, GridShape, Interpolation, MOST_SIDE, Plane, Skew, Surface,
};
pub use config::{ActuatorConfig, ConfigError, Limits, MotionConfig};
pub use feed::StepFeed;
pub use feed_schedule::FeedSchedule;
pub use filters::{FilterConfig, PressureAdvance, Shaper, ShaperKind};
pub use kinematics::Kinematics;
pub use motion::{Access, Counters, Motion, State, Waiting};
pub use move_ends::MoveEnd;
pub use moves::{Corner, Mode, Move, Part, Refusal, Tag};
pub use planner::{Block, BlockRing};
pub use run::Passage;
pub use store::Store;
pub use timeline::{Mark, Passed};
pub use trigger::{Latch, Trigger};
pub(crate) use units::convert;
