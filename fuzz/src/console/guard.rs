//! Watch on a machine from outside, slot by slot: its step edges, its carriages, its heaters.
//!
//! Limits can be changed at run time (M203, M204, M92), for moves that come after. So a motor is compared
//! with the widest limits that have been in force since power-on.

use std::collections::VecDeque;

use motion::{Kinematics, MotionConfig};
use sim::runner::Runner;
use sim::world::ON_BOARD_DRIVERS;
use units::{Actuator, Axis, Direction, MAX_ACTUATORS};

/// Factor on a speed limit for the error of step times: the grid of 5 ns, and the solver.
const SPEED_ALLOWED: f64 = 1.01;
/// Factor on an acceleration limit for the same error, and for corners so flat that they count as straight.
const ACCELERATION_ALLOWED: f64 = 1.1;
/// Half the time over which accelerations are measured, nanoseconds.
const WINDOW_NS: u64 = 10_000_000;
/// Least time between kept positions, nanoseconds.
const SAMPLE_NS: u64 = 1_000_000;
/// Greatest difference between the machine's idea of its position and the true one, mm.
const KNOWN_MM: f64 = 0.1;
/// Codes that redefine the machine's position or travel, or free it from them: after such a code the
/// position is unknown from outside.
const REDEFINES: &[&[u8]] =
    &[b"28", b"206", b"306", b"665", b"666", b"92", b"211", b"load", b"501", b"play", b"M24", b"M32", b"reset"];

/// Observed state of a motor.
#[derive(Clone, Debug, Default)]
struct Motor {
    /// Steps from the first position.
    count: i64,
    /// Time of the last edge, nanoseconds, and its direction.
    last: Option<(u64, Direction)>,
    /// Times and positions, steps, since the motor last stood still.
    samples: VecDeque<(u64, f64)>,
    /// Widest limits so far, steps a second and steps a second squared.
    speed: f64,
    acceleration: f64,
}

/// Guard that watches the whole machine.
#[derive(Clone, Debug, Default)]
pub struct Guard {
    motors: [Motor; MAX_ACTUATORS],
    /// A corner may be taken at speed, the path is not that of the motors, or something broke:
    /// accelerations are no motor's own.
    is_bent: bool,
    /// Extruders run ahead by pressure advance, which no limit counts (docs/motion.md).
    runs_ahead: bool,
    /// A switch that stops the motors at once, without braking, was armed at the last look.
    may_stop_at_once: bool,
    /// Travel lost at hard stops up to homing, mm; some if the machine is homed and sound.
    homed: Option<[f64; 3]>,
}

impl Guard {
    /// Notes that the machine is homed: from now on carriages may leave their travel no more.
    pub fn is_homed(&mut self, runner: &Runner) {
        let place = runner.motion(|motion| motion.live_position());
        let is_there = |(actuator, mm): (Actuator, f64)| {
            let there = runner.world(|world| world.carriage_mm(actuator));
            there.is_none_or(|there| (there - mm).abs() < KNOWN_MM)
        };
        self.homed = Actuator::ALL.into_iter().zip(place.0).take(3).all(is_there).then(|| lost(runner));
    }

    /// Notes a switch pressed by hand: any end position of the carriages is allowed then.
    pub const fn switch_is_pressed(&mut self) {
        self.homed = None;
    }

    /// Notes that something breaks: a driver without supply takes no steps, so that its motor goes by
    /// jumps.
    pub const fn something_breaks(&mut self) {
        self.homed = None;
        self.is_bent = true;
    }

    /// Notes a line that was typed.
    pub fn hear_typed(&mut self, line: &[u8]) {
        if REDEFINES.iter().any(|code| line.windows(code.len()).any(|part| part == *code)) {
            self.homed = None;
        }
    }

    /// Checks the machine; to be called in every slot.
    ///
    /// # Panics
    /// When a motor, a carriage or a heater is out of its limits.
    pub fn look(&mut self, runner: &Runner) {
        let edges = runner.world(|world| world.trace_mut().take());
        if let Some((config, idle)) = runner.motion(|motion| Some((*motion.config()?, motion.is_idle()))) {
            self.learn(&config);
            for edge in edges {
                self.step(edge.time_ns, edge.actuator, edge.direction);
            }
            let may_stop = runner.hard_stop_is_armed();
            // Homing that cannot brake before the frame stops so, and measures again slowly.
            if idle || may_stop || std::mem::replace(&mut self.may_stop_at_once, may_stop) {
                self.motors.iter_mut().for_each(|motor| motor.samples.clear());
            }
        } else {
            assert!(edges.is_empty(), "steps without a configuration");
        }
        self.look_at_travel(runner);
        look_at_targets(runner);
    }

    fn learn(&mut self, config: &MotionConfig) {
        let limits = &config.limits;
        self.runs_ahead |= config.filters.advance.iter().flatten().any(|advance| advance.factor > 0.0);
        let cartesian = matches!(config.kinematics, Kinematics::Cartesian);
        self.is_bent |= !cartesian
            || limits.junction_deviation.get() > 0.0
            || limits.z_junction_deviation.is_some_and(|deviation| deviation.get() > 0.0)
            || limits.square_corner_velocity.is_some()
            || limits.minimum_speed.get() > 0.0;
        for actuator in Actuator::ALL {
            let Some(settings) = config.actuators[actuator] else { continue };
            let axis = Axis::PRIMARY.into_iter().position(|axis| axis as usize == actuator as usize && cartesian);
            let own = limits.actuator_rate[actuator].get();
            let of_axis = axis.and_then(|axis| limits.axis_speed[axis]).map_or(f64::INFINITY, |speed| speed.get());
            let along = limits.actuator_acceleration[actuator].map_or(f64::INFINITY, |own| own.get());
            let motor = &mut self.motors[actuator as usize];
            motor.speed = motor.speed.max(own.min(of_axis) * settings.steps_per_mm);
            motor.acceleration = motor.acceleration.max(along.min(limits.acceleration.get()) * settings.steps_per_mm);
        }
    }

    fn step(&mut self, at_ns: u64, actuator: Actuator, direction: Direction) {
        let is_bent = self.is_bent;
        let motor = &mut self.motors[actuator as usize];
        let before = motor.count;
        motor.count += i64::from(direction.sign());
        let is_limited = (actuator as usize) < Axis::PRIMARY.len() || !self.runs_ahead;
        if let Some((last_ns, last)) = motor.last.replace((at_ns, direction))
            && last == direction
            && is_limited
        {
            assert!(at_ns >= last_ns, "{} steps at {at_ns} ns after a step at {last_ns} ns", actuator.name());
            // Ten nanoseconds are added for two ticks of the grid.
            let seconds = (at_ns - last_ns + 10) as f64 * 1e-9;
            let rate = 1.0 / seconds;
            let name = actuator.name();
            assert!(
                rate <= motor.speed * SPEED_ALLOWED,
                "{name} at {rate:.0} steps/s of {:.0}, {at_ns} ns",
                motor.speed
            );
        }
        if !is_bent && (actuator as usize) < Axis::PRIMARY.len() {
            motor.accelerates(at_ns, (before + motor.count) as f64 / 2.0, actuator);
        }
    }

    fn look_at_travel(&mut self, runner: &Runner) {
        let Some(before) = self.homed else { return };
        let place = runner.motion(|motion| motion.live_position());
        for (index, actuator) in Actuator::ALL.into_iter().take(before.len()).enumerate() {
            let (there, lost, on) = runner.world(|world| {
                let there = world.carriage_mm(actuator).unwrap_or_default();
                (there, world.lost_mm(actuator), world.driver(index).drives())
            });
            assert!(lost <= before[index], "{} meets the frame at {there} mm", actuator.name());
            // Live positions are some milliseconds old.
            let is_known = !runner.motion(|motion| motion.is_idle()) || (there - place.0[index]).abs() < KNOWN_MM;
            if !on || !is_known {
                self.homed = None;
            }
        }
    }

    /// Checks the state after an emergency stop: no target, no duty, nothing on a timer.
    ///
    /// # Panics
    /// When something is on.
    pub fn nothing_is_on(&self, runner: &Runner) {
        runner.heat(|heat| {
            for (id, heater) in heat.heaters() {
                assert!(!heater.is_on() && heater.duty().0 == 0, "{id:?} is on after M112: {heater:?}");
            }
        });
        for (timer, channel) in [(0, 0), (0, 1), (0, 2), (0, 3), (1, 0), (1, 1), (1, 2), (1, 3)] {
            let duty = runner.world(|world| world.pwm_duty(timer, channel));
            assert!(duty == 0.0, "timer {timer} channel {channel} at {duty} after M112");
        }
    }

    /// Returns whether nothing moves, and no motor has current.
    pub fn rests(runner: &Runner) -> bool {
        let has_current = runner.world(|world| (0..ON_BOARD_DRIVERS).any(|index| world.driver(index).drives()));
        !has_current && runner.motion(|motion| motion.is_idle())
    }
}

impl Motor {
    /// Checks a step's acceleration: the second divided difference of three positions is a mean of the
    /// acceleration between them.
    fn accelerates(&mut self, at_ns: u64, place: f64, actuator: Actuator) {
        let before = |samples: &VecDeque<(u64, f64)>, ns: u64| {
            let end = samples.partition_point(|(sample_ns, _)| *sample_ns <= ns);
            end.checked_sub(1).and_then(|index| samples.get(index).copied())
        };
        let middle = before(&self.samples, at_ns.saturating_sub(WINDOW_NS));
        let first = middle.and_then(|(middle_ns, _)| before(&self.samples, middle_ns.saturating_sub(WINDOW_NS)));
        if let (Some((first_ns, first)), Some((middle_ns, middle))) = (first, middle) {
            let seconds = |from: u64, to: u64| (to - from) as f64 * 1e-9;
            let speeds =
                [(middle - first) / seconds(first_ns, middle_ns), (place - middle) / seconds(middle_ns, at_ns)];
            let found = (speeds[1] - speeds[0]) / seconds(first_ns, at_ns) * 2.0;
            let limit = self.acceleration * ACCELERATION_ALLOWED;
            assert!(found.abs() <= limit, "{} at {found:.0} steps/s2 of {limit:.0}, {at_ns} ns", actuator.name());
        }
        if self.samples.back().is_none_or(|(last_ns, _)| at_ns - last_ns >= SAMPLE_NS) {
            self.samples.push_back((at_ns, place));
        }
        while self.samples.get(1).is_some_and(|(ns, _)| at_ns - ns > 8 * WINDOW_NS) {
            self.samples.pop_front();
        }
    }
}

fn lost(runner: &Runner) -> [f64; 3] {
    let [x, y, z, ..] = Actuator::ALL;
    [x, y, z].map(|actuator| runner.world(|world| world.lost_mm(actuator)))
}

/// Checks that no heater is asked for more than its configuration allows.
fn look_at_targets(runner: &Runner) {
    runner.heat(|heat| {
        for (id, heater) in heat.heaters() {
            let Some(limits) = runner.machine().temperatures.get(id.index()) else { continue };
            assert!(heater.target().0 <= limits.max_temp.0, "{} is to be {} C", limits.name, heater.target().0);
        }
    });
}
