//! Models of chips and physics, one per module, each from its datasheet or textbook, none aware of the
//! others.

pub mod carriage;
pub mod converter;
pub mod fan;
pub mod gantry;
pub mod heater;
pub mod led_strip;
pub mod rotor;
pub mod sd_card;
pub mod surface;
pub mod switch;
pub mod thermistor;
pub mod tmc26x;
pub mod tmc_stealth;
pub mod tmc_wire;
