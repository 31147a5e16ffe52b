//! A step of a motor, as it was played.

use units::{Actuator, StepCount};

/// Step of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// Motor that stepped.
    pub actuator: Actuator,
    /// Time of the step, nanoseconds from boot.
    pub at: f64,
    /// Position of the motor after the step.
    pub count: StepCount,
    /// Direction of the step, 1 or -1.
    pub sign: StepCount,
}
