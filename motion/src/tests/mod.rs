//! Laws of the whole pipeline, from submitted moves to played events.

mod arms;
mod back;
mod corners;
mod curves;
mod detours;
mod filters;
mod forecast;
mod hard;
mod jerk_limited;
mod laws;
mod levelled;
mod limits;
mod on_demand;
mod optimum;
mod programs;
mod rig;
mod stops;
mod timeline;
