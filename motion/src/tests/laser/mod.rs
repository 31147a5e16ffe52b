//! Power of a laser, from submitted moves to played events: right in place, in amount, and zero when it must
//! be.

mod energy;
mod orders;
mod raster;
mod rest;

use std::vec::Vec;

use proptest::prelude::*;
use units::{MmPerSecond2, MmPerSecond3, PowerLaw};

use super::{
    filters::shapers,
    rig::{Rig, at, printer},
};
use crate::{
    FilterConfig, Limits, MotionConfig, Move,
    laser::{LaserConfig, Power, PowerCurve},
};

/// A laser whose duty is the level.
pub fn plain() -> LaserConfig {
    LaserConfig { on_delay: 0, off_delay: 0, least: 0.0, most: 1.0, curve: PowerCurve::default() }
}

pub fn constant(level: u16) -> Power {
    Power { level, law: PowerLaw::Constant }
}

pub fn by_speed(level: u16) -> Power {
    Power { level, law: PowerLaw::BySpeed }
}

/// Machines with and without shapers and jerk.
pub fn machines() -> impl Strategy<Value = MotionConfig> {
    let jerk = prop::option::weighted(0.4, 100_000.0..500_000.0_f64);
    let shaping = prop::option::weighted(0.6, [shapers(), shapers()]);
    (shaping, jerk, 3_000.0..8_000.0_f64, any::<bool>()).prop_map(|(shaping, jerk, acceleration, core)| {
        let [x, y] = shaping.unwrap_or_default();
        let printer = printer();
        MotionConfig {
            kinematics: if core { crate::Kinematics::CoreXy } else { printer.kinematics },
            filters: FilterConfig { shapers: [x, y, None], ..FilterConfig::NONE },
            limits: Limits { acceleration: MmPerSecond2(acceleration), jerk: jerk.map(MmPerSecond3), ..printer.limits },
            queue_size: 64,
            ..printer
        }
    })
}

/// A machine with a laser, at rest at the origin.
pub fn with_laser(config: MotionConfig, laser: LaserConfig) -> Rig {
    let mut rig = Rig::new(config);
    rig.motion().set_position(at(0.0, 0.0, 0.0, 0.0)).expect("at rest");
    rig.motion().configure_laser(Some(laser)).expect("a laser");
    rig.tick();
    rig.counts = rig.motion().steps();
    rig
}

pub fn run(config: MotionConfig, laser: LaserConfig, moves: &[Move]) -> Rig {
    let mut rig = with_laser(config, laser);
    moves.iter().for_each(|request| rig.submit(request));
    rig.finish();
    rig
}

/// Changes of duty as they were played: time in ns, duty.
pub fn duties(rig: &Rig) -> Vec<(f64, u16)> {
    rig.events.iter().filter_map(|(at, event)| Some((*at as f64 * 5.0, event.laser_duty()?))).collect()
}

/// Everything played but power.
pub fn steps(rig: &Rig) -> Vec<(u64, crate::queue::StepEvent)> {
    rig.events.iter().copied().filter(|(_, event)| event.laser_duty().is_none()).collect()
}
