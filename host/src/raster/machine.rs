//! The machine that is to burn a picture: its limits along the rows, its travel, the S of full power.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, anyhow, bail};
use base::safety::travel::Travel;
use base::tuning::Tuning;
use config::{BoardId, MachineConfig};
use motion::Shaper;
use units::{Actuator, Axis, PerAxis};

/// Way over which motors are compared with an axis, mm.
const WAY: f64 = 1.0;

/// Limits of moves along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    /// Greatest speed, mm/s; infinite where nothing limits it.
    pub speed: f64,
    /// Acceleration, mm/s^2.
    pub acceleration: f64,
    /// Rate of change of the acceleration, mm/s^3; infinite where nothing limits it.
    pub jerk: f64,
    /// Speed of G0, mm/s.
    pub seek: f64,
    /// Time by which an input shaper spreads a change of speed, seconds.
    pub spread: f64,
}

/// Machine as its configuration describes it.
#[derive(Clone, Debug)]
pub struct Machine {
    /// The whole configuration, where there is one.
    pub config: Option<Box<MachineConfig>>,
    pub limits: Limits,
    /// Least and greatest places of X and Y, mm; infinite where an axis does not end.
    pub travel: [[f64; 2]; 2],
    /// S of full power.
    pub scale: f64,
}

impl Limits {
    /// Returns the way on which a move gets from rest to a speed, mm.
    pub fn ramp(&self, speed: f64) -> f64 {
        0.5 * speed * self.ramp_seconds(speed)
    }

    /// Returns the way after which a move from rest has a speed for good, behind the shaper, mm.
    pub fn run_up(&self, speed: f64) -> f64 {
        self.ramp(speed) + self.spread * speed
    }

    /// Returns the greatest speed that a move from rest has for good after a way.
    pub fn fastest(&self, way: f64) -> f64 {
        self.greatest(way, Self::run_up)
    }

    /// Returns the greatest speed that is reached from rest on a way.
    fn reached(&self, way: f64) -> f64 {
        self.greatest(way, Self::ramp)
    }

    /// Returns the greatest speed whose way, by a function that rises with it, is no longer than this.
    fn greatest(&self, way: f64, of: fn(&Self, f64) -> f64) -> f64 {
        let (mut low, mut high) = (0.0, (2.0 * way * self.acceleration).sqrt());
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if of(self, middle) > way { high = middle } else { low = middle }
        }
        low
    }

    /// Returns the time of a move from rest to rest at up to a speed, seconds.
    pub fn seconds(&self, way: f64, speed: f64) -> f64 {
        let peak = speed.min(self.speed).min(self.reached(0.5 * way));
        if peak > 0.0 { 2.0 * self.ramp_seconds(peak) + (way - 2.0 * self.ramp(peak)).max(0.0) / peak } else { 0.0 }
    }

    /// Returns the time in which a speed is reached from rest.
    fn ramp_seconds(&self, speed: f64) -> f64 {
        let rise = self.acceleration / self.jerk;
        // Below this speed the acceleration does not reach its limit.
        if speed < self.acceleration * rise {
            2.0 * (speed / self.jerk).sqrt()
        } else {
            speed / self.acceleration + rise
        }
    }
}

impl Machine {
    /// Reads the machine's configuration, for moves along an axis at a place.
    pub fn read(path: &Path, axis: Axis, at: [f64; 2]) -> Result<Self> {
        let bytes = fs::read(path).with_context(|| format!("cannot read {}", path.display()))?;
        let (config, summary) = config::parse(&bytes, BoardId::default(), &mut ());
        if !summary.is_usable() {
            bail!("{} has errors; see: velvet check {0}", path.display());
        }
        if !config.laser.enable {
            bail!("{} has no laser: it needs [laser] with enable = true", path.display());
        }
        Self::of(config, axis, at).with_context(|| path.display().to_string())
    }

    fn of(mut config: MachineConfig, axis: Axis, at: [f64; 2]) -> Result<Self> {
        let arms = |arms| anyhow!("the geometry of {arms:?} fits no machine");
        let motion = base::motion_config::motion_config(&config).map_err(arms)?;
        let [from, to] = [0.0, WAY].map(|way| {
            let mut place = PerAxis([at[0], at[1], 0.0, 0.0, 0.0, 0.0]);
            place.0[axis as usize] += way;
            motion.kinematics.actuators(&place)
        });
        let infinite = f64::INFINITY;
        let (general, index) = (motion.limits, axis as usize);
        let of_path = general.max_speed.map_or(infinite, |speed| speed.get());
        let of_axis = general.axis_speed[index].map_or(infinite, |speed| speed.get());
        let jerks = [general.jerk, general.axis_jerk[index]].map(|jerk| jerk.map_or(infinite, |jerk| jerk.get()));
        let mut limits = Limits {
            speed: of_path.min(of_axis),
            acceleration: general.acceleration.get(),
            jerk: jerks[0].min(jerks[1]),
            seek: config.motion.default_seek_rate.get(),
            spread: motion.filters.shapers[index].map_or(0.0, |shaper| duration(&shaper)),
        };
        for motor in Actuator::ALL.into_iter().take(Axis::PRIMARY.len()) {
            let share = (to[motor] - from[motor]).abs() / WAY;
            if share > 1e-9 {
                limits.speed = limits.speed.min(general.actuator_rate[motor].get() / share);
                let own = general.actuator_acceleration[motor].map_or(infinite, |own| own.get() / share);
                limits.acceleration = limits.acceleration.min(own);
            }
        }
        let mut travel = Travel::default();
        let ends = travel.up_to_date(&config, &Tuning::new(&config)).ends();
        let travel = ends.map(|end| [end[Axis::X], end[Axis::Y]]);
        let scale = f64::from(config.laser.maximum_s_value);
        // A picture is burnt on a machine that has been homed, and the dry run begins without.
        config.motion.must_be_homed = false;
        Ok(Self { config: Some(Box::new(config)), limits, travel, scale })
    }
}

/// Returns the time from a shaper's first pulse to its last, seconds.
fn duration(shaper: &Shaper) -> f64 {
    shaper.pulses().as_slice().iter().map(|pulse| pulse.time).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const SAMPLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/../config/samples/laser.ini");

    #[test]
    fn the_sample_of_a_laser_is_read() {
        let machine = Machine::read(Path::new(SAMPLE), Axis::X, [0.0; 2]).expect("a laser");
        let limits = Limits { speed: 200.0, acceleration: 1_500.0, jerk: f64::INFINITY, seek: 200.0, spread: 0.0 };
        assert_eq!((machine.limits, machine.scale), (limits, 1_000.0));
        assert_eq!(machine.travel, [[0.0, 0.0], [420.0, 320.0]]);
        let shaper = Shaper { kind: motion::ShaperKind::Zv, frequency: 50.0, damping: 0.0 };
        assert!((duration(&shaper) - 0.01).abs() < 1e-9, "half a period");
        let printer = SAMPLE.replace("laser.ini", "cartesian.ini");
        let error = Machine::read(Path::new(&printer), Axis::X, [0.0; 2]).expect_err("no laser");
        assert!(error.to_string().contains("has no laser"));
    }

    #[test]
    fn times_are_those_of_trapezoids_and_of_ramps_with_a_jerk() {
        let plain = Limits { speed: 200.0, acceleration: 1_000.0, jerk: f64::INFINITY, seek: 200.0, spread: 0.0 };
        assert!((plain.ramp(100.0) - 5.0).abs() < 1e-9 && (plain.seconds(20.0, 100.0) - 0.3).abs() < 1e-9);
        assert!((plain.seconds(4.0, 500.0) - 2.0 * (4.0_f64 / 1_000.0).sqrt()).abs() < 1e-6, "a triangle");
        assert!((plain.seconds(140.0, 500.0) - 0.9).abs() < 1e-9, "the axis' own limit");
        let smooth = Limits { jerk: 20_000.0, ..plain };
        assert!((smooth.ramp(100.0) - 7.5).abs() < 1e-9, "0.15 s at half the speed");
        assert!((smooth.ramp(20.0) - 20.0 * (20.0_f64 / 20_000.0).sqrt()).abs() < 1e-9);
        assert!((smooth.ramp(smooth.reached(3.0)) - 3.0).abs() < 1e-6);
        let shaped = Limits { spread: 0.02, ..plain };
        assert!((shaped.run_up(100.0) - 7.0).abs() < 1e-9 && (shaped.fastest(7.0) - 100.0).abs() < 1e-6);
    }
}
