//! Translates the configuration of motion to `motion`'s own types.

use config::{ArmSolution, InputShaperConfig, MachineConfig};
use motion::kinematics::{CoreXz, Generic, LinearDelta, MOST_ANCHORS, Winch};
use motion::{ActuatorConfig, FilterConfig, Kinematics, Limits, MotionConfig, PressureAdvance, Shaper};
use units::{Actuator, MmPerSecond, PerActuator, STEP_CLOCK_HZ, Ticks};

/// Converts nanoseconds to ticks, rounded up.
const fn ticks_of_ns(nanoseconds: u32) -> u32 {
    nanoseconds.div_ceil(units::TICK_NANOSECONDS)
}

/// Returns the configuration of `motion`.
///
/// # Errors
/// The arm solution, when its geometry fits no machine.
pub fn motion_config(config: &MachineConfig) -> Result<MotionConfig, ArmSolution> {
    let kinematics = kinematics(config).ok_or(config.motion.arm_solution)?;
    let mut actuators = PerActuator([None; units::MAX_ACTUATORS]);
    for (motor, _) in config.actuators() {
        actuators[motor] = Some(actuator(config, motor));
    }
    Ok(MotionConfig {
        kinematics,
        actuators,
        limits: limits(config),
        queue_size: usize::from(config.planner.queue_size),
        queue_delay: Ticks::from_micros(config.planner.queue_delay.0),
        filters: filters(config),
    })
}

/// Returns the kinematics of a machine; `None` when the geometry fits no machine.
#[must_use]
pub fn kinematics(config: &MachineConfig) -> Option<Kinematics> {
    let arms = &config.motion.arms;
    let [x, z] = arms.corexz;
    Some(match config.motion.arm_solution {
        ArmSolution::Cartesian => Kinematics::Cartesian,
        ArmSolution::CoreXy => Kinematics::CoreXy,
        ArmSolution::CoreXz => Kinematics::CoreXz(CoreXz { x, z }),
        ArmSolution::HybridCoreXy => Kinematics::HybridCoreXy,
        ArmSolution::HybridCoreXz => Kinematics::HybridCoreXz,
        ArmSolution::Lathe => Kinematics::Lathe,
        ArmSolution::Polar => Kinematics::Polar,
        ArmSolution::LinearDelta => Kinematics::LinearDelta(LinearDelta::new(arms.linear_delta)),
        ArmSolution::RotaryDelta => Kinematics::RotaryDelta(arms.rotary_delta),
        ArmSolution::Morgan => Kinematics::Morgan(arms.morgan),
        ArmSolution::Deltesian => Kinematics::Deltesian(arms.deltesian),
        ArmSolution::Generic => Kinematics::Generic(Generic::new(arms.generic)?),
        ArmSolution::Winch => {
            let anchors: heapless::Vec<_, MOST_ANCHORS> = arms.anchors.iter().map_while(|anchor| *anchor).collect();
            Kinematics::Winch(Winch::new(&anchors)?)
        }
    })
}

/// Returns the filters: input shaping and pressure advance.
fn filters(config: &MachineConfig) -> FilterConfig {
    let mut filters = FilterConfig { shapers: config.input_shapers.map(shaper), ..FilterConfig::NONE };
    for extruder in &config.extruders {
        if let Some(slot) = filters.advance.get_mut(usize::from(extruder.tool.id.0)) {
            *slot = Some(PressureAdvance {
                factor: extruder.pressure_advance_s,
                smooth_time: extruder.pressure_advance_smooth_time_s,
            });
        }
    }
    filters
}

fn shaper(settings: InputShaperConfig) -> Option<Shaper> {
    let frequency = settings.frequency_hz?;
    Some(Shaper { kind: settings.shaper, frequency, damping: settings.damping_ratio })
}

/// Returns one motor's settings as motion needs them: its steps and the intervals that its driver needs.
#[must_use]
pub fn actuator(config: &MachineConfig, motor: Actuator) -> ActuatorConfig {
    let settings = &config.actuators[motor];
    let on_board = ActuatorConfig::new(settings.steps_per_mm);
    // An external driver takes pulses: high for step_pulse_us, low for as long, even if the interrupt that
    // ends one comes half a microsecond late.
    let pulse_ticks = config.system.step_pulse_us * (STEP_CLOCK_HZ / 1_000_000);
    let step_interval = if settings.driver.is_on_board() {
        on_board.step_interval
    } else {
        2 * pulse_ticks + STEP_CLOCK_HZ / 2_000_000
    };
    ActuatorConfig {
        slaved_to: settings.slaved_to,
        direction_setup: ticks_of_ns(settings.dir_setup_ns).max(on_board.direction_setup),
        step_interval: step_interval.max(on_board.step_interval),
        ..on_board
    }
}

fn limits(config: &MachineConfig) -> Limits {
    let default_rate = Limits::DEFAULT.actuator_rate;
    let mut actuator_rate = default_rate;
    let mut actuator_acceleration = PerActuator([None; units::MAX_ACTUATORS]);
    for (motor, settings) in config.actuators() {
        actuator_rate[motor] = settings.max_rate;
        actuator_acceleration[motor] = settings.acceleration;
    }
    Limits {
        axis_speed: config.motion.axis_max_speed,
        max_speed: config.motion.max_speed,
        actuator_rate,
        acceleration: config.motion.default_acceleration,
        actuator_acceleration,
        jerk: config.planner.jerk,
        axis_jerk: config.planner.axis_jerk,
        square_corner_velocity: config.planner.square_corner_velocity,
        cruise_ratio: config.planner.minimum_cruise_ratio,
        junction_deviation: config.planner.junction_deviation,
        z_junction_deviation: config.planner.z_junction_deviation,
        minimum_speed: config.planner.minimum_planner_speed,
    }
}

/// Returns whether a move out of reach halts: yes, unless the configuration says otherwise.
pub const fn halts_out_of_reach(config: &MachineConfig) -> bool {
    let arms = &config.motion.arms;
    match config.motion.arm_solution {
        ArmSolution::LinearDelta => arms.linear_delta_halts,
        ArmSolution::RotaryDelta => arms.rotary_delta_halts,
        _ => true,
    }
}

/// Returns the slowest `max_rate` among motors, mm/s: a rate that no motor of them exceeds.
#[must_use]
pub fn slowest_rate(config: &MachineConfig, motors: impl Iterator<Item = Actuator>) -> MmPerSecond {
    let slowest =
        motors.map(|motor| config.actuators[motor].max_rate.0).fold(f64::INFINITY, |a, b| if b < a { b } else { a });
    MmPerSecond(slowest)
}
