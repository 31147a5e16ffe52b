//! Reactions to a motor that stalls while it moves.

pub(crate) mod recovery;
pub(crate) mod step;

use base::failure::Failure;
use base::ports::Input;
use base::reason::Alarm;
use base::stall_watch::{Sight, StallWatch};
use base::{Ports, World};
use config::OnStall;
use jobs::player::StalledJob;
use program::{BEGINNING_BYTES, State};
use units::{Actuator, Axis, Micros, PerActuator};

use crate::machine::Machine;
use crate::machine::moments::{JobBegins, Moments};

/// Period of the looks while no motor is watched.
const SELDOM: Micros = Micros::from_seconds(1);
/// Time to the next look while nothing moves.
const SOON: Micros = Micros::from_millis(1);
/// Time without watching after a stall that does not halt.
const TOLD: Micros = Micros::from_seconds(2);

/// Stalls at the machine's moments.
pub(crate) struct Feature;

impl<'c, P: Ports> Moments<Machine<'c, P>> for Feature {
    fn each_250_us(machine: &mut Machine<'_, P>, now: Micros) {
        if machine.features.stalls.is_under_way() {
            recovery::watch(machine);
        }
        if !machine.features.stall_watch.is_due(now) {
            return;
        }
        // An axis without a switch stalls where it homes.
        let is_elsewhere =
            machine.polls.ignores_stalls || machine.safety.is_halted() || machine.safety.mode().is_in(State::Homing);
        let watch = &mut machine.features.stall_watch;
        let Some(motor) = look(&mut machine.world, watch, !is_elsewhere, now) else { return };
        let wanted = machine.world.config.on_stall(motor);
        if wanted.keeps_job() && recovery::brake(machine, motor) {
            return machine.features.stall_watch.rest(now, TOLD);
        }
        machine.axes.lose_place(motor);
        let letter = Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter());
        let what = format_args!("motor {letter} stalls: it hit something, or its load is too high");
        if wanted == OnStall::Tell {
            machine.features.stall_watch.rest(now, TOLD);
            machine.announce(format_args!("WARNING: {what}; home it\n"));
        } else {
            machine.halt(Alarm::Abort, format_args!("ERROR: {what}; home after M999\n"));
        }
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, _now: Micros) {
        recovery::begin(machine);
    }

    fn job_begins(machine: &mut Machine<'_, P>, from: JobBegins) {
        if matches!(from, JobBegins::Whole | JobBegins::FurtherOn) {
            recovery::job_begins(machine);
        }
    }

    fn job_goes_on(machine: &mut Machine<'_, P>, beginning: [u8; BEGINNING_BYTES]) {
        recovery::job_goes_on(machine, beginning);
    }

    fn explains_stop(machine: &Machine<'_, P>) -> bool {
        machine.features.stalls.is_under_way()
    }

    fn before_going_back(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
        recovery::rehome(machine)
    }

    fn arrives(machine: &mut Machine<'_, P>, stall: &StalledJob) -> Result<(), Failure> {
        recovery::arrive(machine, stall)
    }

    fn job_is_dropped(machine: &mut Machine<'_, P>) {
        machine.features.stalls.rest();
    }

    fn work_ends(machine: &mut Machine<'_, P>) {
        machine.features.stalls.rest();
    }
}

/// Looks at the stall outputs of the drivers. `counts`: stalls mean something at present.
fn look<P: Ports>(world: &mut World<'_, P>, watch: &mut StallWatch, counts: bool, now: Micros) -> Option<Actuator> {
    let World { ports, config, .. } = world;
    if config.watched_for_stalls().next().is_none() {
        watch.rest(now, SELDOM);
        return None;
    }
    let speeds = ports.motion(|motion| motion.motor_speeds());
    let Some(speeds) = speeds.filter(|_| counts) else {
        watch.rest(now, SOON);
        return None;
    };
    let levels = ports.inputs();
    let mut sights = PerActuator::<Option<Sight>>::default();
    for (motor, pin) in config.watched_for_stalls() {
        let settings = &config.actuators[motor];
        let full_steps_per_mm = settings.steps_per_mm / f64::from(settings.microsteps.max(1));
        let input = config.endstop_of_pin(pin).map_or(Input::Stall(motor as u8), |stop| Input::Endstop(stop as u8));
        sights[motor] = Some(Sight {
            speed: libm::fabs(speeds[motor] * full_steps_per_mm) as f32,
            // Rounding makes a speed no slower.
            least: (config.load_speed(motor).0 * full_steps_per_mm * 0.999) as f32,
            stalls: levels.is_active(input),
        });
    }
    watch.look(now, &sights)
}
