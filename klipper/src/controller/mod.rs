//! The controller: blocks of the host to objects, and what the objects do as time passes.

mod analog;
mod basic;
mod buses;
mod dispatch;
mod inputs;
mod job;
mod outputs;
mod run;
mod sensors;
mod state;
mod steppers;

pub use job::Job;
pub use state::Controller;
