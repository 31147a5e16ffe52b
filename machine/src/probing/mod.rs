//! The probe: searches along a straight line that end when its contact changes, and their uses.
//!
//! The place of a contact is the motors' position at the tick its input fired, which the latch keeps; the
//! braking after it costs nothing. So the speed of a search decides the braking distance past the contact,
//! never the result.

mod calibration_print;
mod delta_calibration;
mod delta_fit;
mod delta_records;
mod deployed;
mod deployment;
mod faulty;
mod grids;
mod lost_motion;
mod measured_part;
mod plan;
mod points;
mod repeatability;
mod search;
mod settings;
mod strategy;
mod three_point;
mod to_contact;

pub(crate) use delta_records::DeltaRecords;
pub(crate) use deployed::Deployment;
pub(crate) use deployment::{deploy_or_stow, leave_out, stow_after};
pub(crate) use grids::touch_cartesian_grid;
pub(crate) use lost_motion::lost_motion;
pub(crate) use measured_part::measured_part;
pub(crate) use plan::Plan;
pub(crate) use points::{nozzle_over, touch_here, touch_places, touch_uncorrected};
pub(crate) use repeatability::repeatability;
pub(crate) use search::check_homed;
pub(crate) use settings::{probe_settings, write_probe};
pub(crate) use strategy::{prepare, strategy};
pub(crate) use to_contact::{probe_along, probe_down};
