//! Parts of the machine, each with the work of its codes: outputs, fans, filament, drivers, lights, buttons,
//! the codes of heaters, and reports.
#![cfg_attr(not(test), no_std)]
#![forbid(unsafe_code)]

pub mod buttons;
pub mod drawing;
pub mod driver_codes;
pub mod fans;
pub mod filament;
pub mod gpio;
pub mod heat_codes;
pub mod laser;
pub mod lights;
pub mod motion_codes;
pub mod outputs;
pub mod reports;
pub mod strips;
pub mod z_thermal;
