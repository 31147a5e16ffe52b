//! State of the machine's parts: motors, switched outputs, heaters, fans, filament.

use board_facts::wiring::{self, Feed};

use super::config::GRID_NS;
use super::config::{ActuatorConfig, DriverConfig, FanConfig, HeaterConfig, Pin, SwitchConfig};
use crate::models::carriage::Carriage;
use crate::models::converter::{Converter, Leads};
use crate::models::fan::{Fan, Plant};
use crate::models::heater::Heater;
use crate::models::rotor::Rotor;
use crate::models::surface::TouchNoise;
use crate::models::switch::{self, Side, Switch};
use crate::models::thermistor::Wiring;

/// A motor with its driver's logic inputs and its carriage.
#[derive(Clone, Debug)]
pub(super) struct Motor {
    pub driver: DriverConfig,
    pub forward_high: bool,
    pub step_high: bool,
    pub step_changed_ns: Option<u64>,
    pub dir_high: bool,
    pub dir_changed_ns: u64,
    /// Only external drivers have an enable of their own.
    pub enabled: bool,
    pub carriage: Carriage,
    pub rotor: Option<Rotor>,
    pub sense_ohms: f64,
}

impl Motor {
    /// Makes the part at power-on.
    pub fn new(config: &ActuatorConfig) -> Self {
        Self {
            driver: config.driver,
            forward_high: config.forward_high,
            step_high: false,
            step_changed_ns: None,
            dir_high: false,
            dir_changed_ns: 0,
            enabled: matches!(config.driver, DriverConfig::External { enable_high: None, .. }),
            carriage: Carriage::new(config.start_mm, config.limits_mm, config.mm_per_full_step),
            rotor: config.rotor.map(Rotor::new),
            sense_ohms: config.sense_ohms,
        }
    }
}

/// Returns the switch of a configuration, without a fault.
pub(super) fn switch_of(config: &SwitchConfig) -> Switch {
    let (position_mm, side) = match config.operator {
        Some((_, position_mm, side)) => (position_mm, side),
        None => (f64::NEG_INFINITY, Side::Below),
    };
    Switch { position_mm, side, fault: switch::Fault::Sound, noise_mm: 0.0, noise: TouchNoise::default() }
}

/// Path from an output's pin to the current through its load.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Path {
    /// The buffer, the output's own MOSFET, and the load switch.
    Switched,
    /// The buffer and the output's own MOSFETs: the bed.
    Direct,
    /// The buffer and a relay with a supply of its own.
    Relay,
    /// A header pin that leads to something with a supply of its own.
    Header,
}

impl Path {
    /// Returns the path of the output on this pin.
    pub fn of(pin: Option<Pin>) -> Self {
        let output = pin.and_then(|pin| wiring::power_output(&pin.to_string()));
        match output.map(|output| output.feed) {
            Some(Feed::Switched) => Self::Switched,
            Some(Feed::Direct) => Self::Direct,
            Some(Feed::FiveVolts) => Self::Relay,
            None => Self::Header,
        }
    }
}

/// A switched output and the share of the current grid step it has been on.
#[derive(Clone, Debug, Default)]
pub(super) struct Load {
    /// Share of full drive right now: 0 or 1 from a pin, anything between from a duty.
    pub drive: f64,
    pub since_ns: u64,
    /// Drive integrated over the grid step so far, in nanoseconds.
    pub on_ns: f64,
    /// Mean drive of the last whole grid step.
    pub last: f64,
}

impl Load {
    /// Sets the drive from now on.
    pub fn set(&mut self, at_ns: u64, drive: f64) {
        self.on_ns += self.drive * at_ns.saturating_sub(self.since_ns) as f64;
        self.since_ns = at_ns;
        self.drive = drive;
    }

    /// Ends a grid step here; returns the mean drive over the step.
    pub fn finish(&mut self, at_ns: u64) -> f64 {
        self.set(at_ns, self.drive);
        self.last = self.on_ns / GRID_NS as f64;
        self.on_ns = 0.0;
        self.last
    }
}

/// A fan and its switched output.
#[derive(Clone, Debug)]
pub(super) struct FanState {
    pub load: Load,
    pub path: Path,
    pub fan: Fan,
}

impl FanState {
    /// Makes the part at power-on.
    pub fn new(config: &FanConfig) -> Self {
        Self { load: Load::default(), path: Path::of(Some(config.pin)), fan: Fan::new(Plant::SMALL) }
    }
}

/// Seat of a sensor in its heater, and its plug.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Seat {
    /// The sensor slides out.
    pub slips: bool,
    /// Share of the sensor that feels the air.
    pub out: f64,
    /// The plug is loose.
    pub loose: bool,
    /// Noise that the wire picks up, kelvin, either way.
    pub noise_k: f64,
    /// Drift of the sensor per second, and the drift so far.
    pub drift_k_per_s: f64,
    pub drift_k: f64,
}

/// A heater, its switched output and its sensor.
#[derive(Clone, Debug)]
pub(super) struct HeaterState {
    pub load: Load,
    pub path: Path,
    pub heater: Heater,
    pub wiring: Wiring,
    pub leads: Leads,
    pub converter: Option<Converter>,
    /// Switch that conducts always or never.
    pub stuck: Option<bool>,
    /// Share of power that the heater still gives.
    pub strength: f64,
    pub seat: Seat,
    pub max_c: f64,
    /// Mean drive over about the last second, for reports.
    pub smooth_duty: f64,
}

impl HeaterState {
    /// Makes the part at power-on.
    pub fn new(config: &HeaterConfig, air_c: f64) -> Self {
        Self {
            load: Load::default(),
            path: Path::of(config.pin),
            heater: Heater::new(config.plant, air_c),
            wiring: Wiring::Sound,
            leads: Leads::Sound,
            converter: config.converter.map(|converter| Converter::new(converter.kind, 0)),
            stuck: None,
            strength: 1.0,
            seat: Seat::default(),
            max_c: air_c,
            smooth_duty: 0.0,
        }
    }
}

/// Filament that runs through the sensor.
#[derive(Clone, Debug)]
pub(super) struct Filament {
    /// Thickness of the filament, by the position from which it applies, in millimetres of filament that
    /// has come out of the nozzle by then.
    pub pieces: Vec<(f64, f64)>,
    /// Whether the sensor's plug is in.
    pub plugged: bool,
}

impl Default for Filament {
    fn default() -> Self {
        Self { pieces: Vec::new(), plugged: true }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_load_gets_the_mean_of_its_drive_over_a_step_of_the_grid() {
        let mut load = Load::default();
        load.set(GRID_NS / 4, 1.0);
        load.set(GRID_NS / 2, 0.5);
        assert!((load.finish(GRID_NS) - 0.5).abs() < 1e-12, "a quarter at full drive, a half at half of it");
        assert!((load.finish(2 * GRID_NS) - 0.5).abs() < 1e-12, "the drive stays");
        load.set(2 * GRID_NS, 0.0);
        assert_eq!((load.finish(3 * GRID_NS), load.last), (0.0, 0.0));
    }

    #[test]
    fn outputs_have_the_paths_of_the_board() {
        let of = |name: &str| Path::of(Pin::parse(name));
        assert_eq!(
            [of("PE0"), of("PE1"), of("PE3"), of("PD4")],
            [Path::Switched, Path::Switched, Path::Direct, Path::Header]
        );
        assert_eq!(Path::of(None), Path::Header);
    }
}
