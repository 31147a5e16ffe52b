//! Leveling and skew: M370, M374, M375, M421, M557, M561, M565, M852.
//!
//! `probing` measures the bed. Here a plane or a grid of heights becomes the compensation of the motion
//! object, is kept on the card, shown and saved. A height is the correction added to Z for the tool to be as
//! far from the bed there as at height zero: positive where the bed is higher.
//!
//! Coordinates are those of the program throughout. If the compensation changes while the machine is homed,
//! coordinates stay and the motors follow: the tool moves by as much as the compensation changed there,
//! slowly. On a machine that is not homed nothing moves. Nor does anything move when leveling is taken off,
//! by a person or because a bed is about to be measured: the tool stays, and its coordinates change.

pub mod area;
mod bed_settings;
mod compensation;
pub mod findings;
pub mod form;
pub mod grid;
mod grid_file;
pub mod map;
mod plane;
pub mod profile_file;
mod profiles;
mod skew;
mod table;
#[cfg(test)]
mod tests;
pub mod words;

pub use bed_settings::{axis_twist, marlin_probe_offset, probe_offset, probe_point, write_leveling};
pub use compensation::{
    adopt_grid, fade_height, level_off, mesh_offset, put_compensation_back, set_compensation_aside, take_off,
};
pub use grid_file::grid_point;
pub use map::{map_line, means, say_findings, show_map};
pub use plane::{adopt_plane, bed_plane};
pub use profiles::{delete, list, load, name_at, save, use_mesh};
pub use skew::{configure, skew};
pub use table::{grid_line, show_grid};
