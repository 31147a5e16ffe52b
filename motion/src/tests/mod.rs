//! Laws of the whole pipeline, from submitted moves to played events.

mod corners;
mod curves;
mod detours;
mod feed_on_demand;
mod filters;
mod forecast;
mod hard_files;
mod jerk_limited;
mod laser;
mod laws;
mod leveling;
mod limits;
mod nonlinear;
mod path_made;
mod random_programs;
pub(crate) mod rig;
mod shortest_time;
mod stops;
mod taking_back;
mod timeline;
