//! The probe: searches along a straight line that end when its contact changes, and their uses.
//!
//! The place of a contact is the motors' position at the tick its input fired, which the latch keeps; the
//! braking after it costs nothing. So the speed of a search decides the braking distance past the contact,
//! never the result.

mod calibration_print;
mod delta_calibration;
mod delta_fit;
mod delta_records;
mod deployment;
mod deployment_state;
mod faulty;
mod grids;
mod hands;
mod lost_motion;
mod measured_part;
mod plan;
mod points;
mod probe_settings;
mod repeatability;
mod search;
mod strategy;
#[cfg(test)]
mod tests;
mod three_point;
mod to_contact;

pub use delta_records::DeltaRecords;
pub use deployment::{deploy_or_stow, leave_out, stow_after};
pub use deployment_state::Deployment;
pub use grids::touch_cartesian_grid;
pub use hands::ProbeHands;
pub use lost_motion::lost_motion;
pub use measured_part::measured_part;
pub use plan::Plan;
pub use points::{nozzle_over, touch_here, touch_places, touch_uncorrected};
pub use probe_settings::{probe_settings, write_probe};
pub use repeatability::repeatability;
pub use search::check_homed;
pub use strategy::{prepare, strategy};
pub use to_contact::{probe_along, probe_down};
