//! Updates on a modelled flash and card, with the power cut at every operation.

mod cuts;
mod flaws;
mod model;
mod receiving;
mod trials;
