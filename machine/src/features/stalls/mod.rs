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
use procedures::stall_recovery::StallRecovery;
use program::{BEGINNING_BYTES, State};
use units::{Actuator, Axis, Micros, PerActuator};

use crate::machine::Machine;
use crate::machine::fast_forward::ReadOverHands;
use crate::machine::moments::{JobBegins, Moments};
use crate::machine::move_dropping::Cut;
use crate::machine::suspend::SuspendHands;

/// Period of the looks while no motor is watched.
const SELDOM: Micros = Micros::from_seconds(1);
/// Time to the next look while nothing moves.
const SOON: Micros = Micros::from_millis(1);
/// Time without watching after a stall that does not halt.
const TOLD: Micros = Micros::from_seconds(2);

/// The machine for recoveries from stalls.
pub(crate) trait StallHands<'c>: SuspendHands<'c> + ReadOverHands<'c> {
    /// Returns the recovery after a stall has stopped the job.
    fn stalls(&mut self) -> &mut StallRecovery;

    /// Whether a stall has stopped the job, which goes on or is suspended later.
    fn is_under_way(&self) -> bool;

    /// Returns the watch over drivers that report stalls, and the world that they are in.
    fn watch_in_world(&mut self) -> (&mut StallWatch, &mut World<'c, Self::Ports>);

    /// Whether a stall means something at present: not where an axis without a switch homes.
    fn counts_stalls(&self) -> bool;

    /// Whether the machine runs a job that can be stopped, and gone on with.
    fn may_be_stopped(&self) -> bool;

    /// Halts the machine for a moment, without an alarm, so that all waits end.
    fn begin_reset(&mut self) -> bool;

    /// Drops planned moves, and changes that wait for their place on the path.
    fn drop_planned(&mut self);

    /// Returns Z's shift for the frame's temperature, mm.
    fn thermal_z(&self) -> f64;
}

impl<'c, P: Ports> StallHands<'c> for Machine<'c, P> {
    fn stalls(&mut self) -> &mut StallRecovery {
        &mut self.features.stalls
    }

    fn is_under_way(&self) -> bool {
        self.features.stalls.is_under_way()
    }

    fn watch_in_world(&mut self) -> (&mut StallWatch, &mut World<'c, P>) {
        (&mut self.features.stall_watch, &mut self.world)
    }

    fn counts_stalls(&self) -> bool {
        !(self.polls.ignores_stalls || self.safety.is_halted() || self.safety.mode().is_in(State::Homing))
    }

    fn may_be_stopped(&self) -> bool {
        self.safety.mode().is_in(State::Run) && self.hold.acts() && self.features.recovery.is_none()
    }

    fn begin_reset(&mut self) -> bool {
        let now = self.world.ports.now();
        self.safety.begin_reset(now)
    }

    fn drop_planned(&mut self) {
        self.cut = Cut::default();
        self.world.ports.motion(motion::Motion::stop);
        self.world.ports.heat(|heat| heat.drop_effects());
        self.features.riding_lights.clear();
    }

    fn thermal_z(&self) -> f64 {
        self.thermal.offset()
    }
}

/// Stalls at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: StallHands<'c>> Moments<M> for Feature {
    fn each_250_us(hands: &mut M, now: Micros) {
        if hands.is_under_way() {
            recovery::watch(hands);
        }
        if !hands.watch_in_world().0.is_due(now) {
            return;
        }
        let counts = hands.counts_stalls();
        let (watch, world) = hands.watch_in_world();
        let Some(motor) = look(world, watch, counts, now) else { return };
        let wanted = hands.world().config.on_stall(motor);
        if wanted.keeps_job() && recovery::brake(hands, motor) {
            return hands.watch_in_world().0.rest(now, TOLD);
        }
        hands.axes().lose_place(motor);
        let letter = Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter());
        let what = format_args!("motor {letter} stalls: it hit something, or its load is too high");
        if wanted == OnStall::Tell {
            hands.watch_in_world().0.rest(now, TOLD);
            hands.announce(format_args!("WARNING: {what}; home it\n"));
        } else {
            hands.halt(Alarm::Abort, format_args!("ERROR: {what}; home after M999\n"));
        }
    }

    fn each_10_ms(hands: &mut M, _now: Micros) {
        recovery::begin(hands);
    }

    fn job_begins(hands: &mut M, from: JobBegins) {
        if matches!(from, JobBegins::Whole | JobBegins::FurtherOn) {
            recovery::job_begins(hands);
        }
    }

    fn job_goes_on(hands: &mut M, beginning: [u8; BEGINNING_BYTES]) {
        recovery::job_goes_on(hands, beginning);
    }

    fn explains_stop(hands: &M) -> bool {
        hands.is_under_way()
    }

    fn before_going_back(hands: &mut M) -> Result<(), Failure> {
        recovery::rehome(hands)
    }

    fn arrives(hands: &mut M, stall: &StalledJob) -> Result<(), Failure> {
        recovery::arrive(hands, stall)
    }

    fn job_is_dropped(hands: &mut M) {
        hands.stalls().rest();
    }

    fn work_ends(hands: &mut M) {
        hands.stalls().rest();
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
