//! The sections of the file, each with its struct and its settings in one declaration.

mod actuators;
mod alignment;
mod arms;
mod buttons;
mod drivers;
mod extruder;
mod fans;
mod filament;
mod heat;
mod homing;
mod led_strips;
mod leveling;
mod motion;
mod outputs;
mod stealth_drivers;
mod system;
mod temperature_switches;
mod to_come;

pub use actuators::*;
pub use alignment::*;
pub use arms::*;
pub use buttons::*;
pub use drivers::*;
pub use extruder::*;
pub use fans::*;
pub use filament::*;
pub use heat::*;
pub use homing::*;
pub use led_strips::*;
pub use leveling::*;
pub use motion::*;
pub use outputs::*;
pub use stealth_drivers::*;
pub use system::*;
pub use temperature_switches::*;
pub(crate) use to_come::*;
