//! The probe: searches along a straight line that end where its contact changes, and what they are for.
//!
//! Where the contact changed is where the motors were at the tick its input fired, which the latch keeps; the
//! braking after it costs nothing. So the speed of a search decides how far the machine runs past the
//! contact, never what it measures.

mod delta_calibration;
mod delta_fit;
mod grids;
mod points;
mod repeatability;
mod search;
mod settings;
mod strategy;
mod three_point;
mod to_contact;

pub(crate) use grids::level_by_cartesian_grid;
pub(crate) use repeatability::repeatability;
pub(crate) use search::touches;
pub(crate) use settings::{probe_settings, write_probe};
pub(crate) use strategy::{prepare, strategy};
pub(crate) use to_contact::{probe_along, probe_down};
