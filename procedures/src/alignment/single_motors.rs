//! Turning the motors of one axis alone.
//!
//! A slave is no axis of its own: its steps are those of its master. For the time of one move, motion is told
//! that the slave is an axis, on the slave's own letter, which no program can name then. The master stands
//! meanwhile, so the tool's position does not change in any coordinate.

use base::failure::Failure;
use config::MachineConfig;
use heapless::Vec;
use motion::{Mode, MotionConfig};
use units::{Actuator, Axis, MmPerSecond, PerAxis};

use crate::homing::come_to_rest;
use crate::probing::ProbeHands;

/// Returns the motors that are slaved to `master`, in their order.
pub(super) fn slaves_of(config: &MachineConfig, master: Actuator) -> Vec<Actuator, 3> {
    let slaves = config.actuators().filter(|(_, motor)| motor.slaved_to == Some(master)).map(|(slave, _)| slave);
    // Only delta, epsilon and zeta can be slaves.
    slaves.take(3).collect()
}

/// Moves slaves by these distances, mm, all at once, and waits for the end. Afterwards they are slaves again
/// in any case; after an error the distances that they moved are unknown.
pub(super) fn move_slaves<'c>(
    hands: &mut impl ProbeHands<'c>,
    slaves: &[Actuator],
    distances: &[f64],
    rate: MmPerSecond,
) -> Result<(), Failure> {
    let apart = Apart::begin(hands, slaves)?;
    let mut target = hands.position();
    for (slave, distance) in slaves.iter().zip(distances) {
        target[axis_of(*slave)] = *distance;
    }
    let turned = turn(hands, target, rate);
    let ended = apart.end(hands);
    turned.and(ended)
}

fn turn<'c>(hands: &mut impl ProbeHands<'c>, target: PerAxis<f64>, rate: MmPerSecond) -> Result<(), Failure> {
    hands.go(target, rate, Mode::Rapid)?;
    hands.standstill()?;
    hands.wait_while_held()
}

/// Returns the axis of a motor's letter, along which the motor moves while it is apart.
pub(super) const fn axis_of(slave: Actuator) -> Axis {
    Axis::ALL[slave as usize]
}

/// Slaves configured as axes of their own, each at 0 where it stood.
pub(super) struct Apart {
    whole: MotionConfig,
    here: PerAxis<f64>,
}

impl Apart {
    pub(super) fn begin<'c>(hands: &mut impl ProbeHands<'c>, slaves: &[Actuator]) -> Result<Self, Failure> {
        hands.standstill()?;
        let (whole, here) = (hands.motion_config()?, hands.position());
        let (mut config, mut start) = (whole, here);
        for slave in slaves {
            set_free(&mut config, *slave);
            start[axis_of(*slave)] = 0.0;
        }
        hands.motion(|motion| motion.configure(config)).map_err(|error| hands.texts().refusal(error))?;
        let apart = Self { whole, here };
        match hands.set_position(start) {
            Ok(()) => Ok(apart),
            Err(failure) => apart.end(hands).and(Err(failure)),
        }
    }

    /// Makes the motors slaves again, whether or not their move succeeded.
    pub(super) fn end<'c>(self, hands: &mut impl ProbeHands<'c>) -> Result<(), Failure> {
        // A halt may still be braking.
        come_to_rest(hands);
        if let Err(error) = hands.motion(|motion| motion.configure(self.whole)) {
            hands.axes().forget_all_homed();
            return Err(hands.texts().alarm(format_args!("slaves are still apart: reset the machine ({error})")));
        }
        hands.set_position(self.here)
    }
}

fn set_free(config: &mut MotionConfig, slave: Actuator) {
    if let Some(motor) = &mut config.actuators[slave] {
        motor.slaved_to = None;
    }
}
