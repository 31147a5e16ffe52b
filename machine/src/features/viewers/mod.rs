//! Viewers of the machine, in browsers and at displays: they are shown a snapshot of it as often as they ask.

use base::axes::Axes;
use base::bed::Bed;
use base::ports::{Clock as _, Factors, HeatPort as _, MotionPort as _, Viewers as _};
use base::safety::Mode;
use base::safety::travel::Travel;
use base::sessions::Recipient;
use base::snapshot::{FanShown, HeaterShown, JobEnd, JobShown, Snapshot};
use base::tuning::Tuning;
use base::{Ports, World};
use config::MachineConfig;
use jobs::player::Jobs;
use motion::{Motion, MoveEnd};
use parts::fans::Fans;
use parts::laser::Beam;
use parts::outputs::Outputs;
use parts::reports::is_live;
use program::Interpreter;
use thermal::HeatControl;
use units::Micros;

use crate::features::forecast::{self, ForecastHands};
use crate::features::laser;
use crate::machine::moments::{JobBegins, Moments};
use crate::machine::{Machine, program_io};

mod equipment;
mod mesh;

/// Parts of the machine that viewers see.
pub(crate) struct Viewed<'m, 'c, P> {
    world: &'m mut World<'c, P>,
    program: &'m Interpreter,
    mode: Mode,
    axes: &'m Axes,
    fans: &'m Fans,
    jobs: &'m Jobs,
    travel: &'m mut Travel,
    tuning: &'m Tuning,
    outputs: &'m Outputs,
    bed: &'m Bed,
    beam: &'m Beam,
    /// Number of the list of macros.
    macros: u32,
    /// The job that has ended last.
    last_job: &'m mut Option<JobShown>,
}

/// The machine for its viewers.
pub(crate) trait ViewedHands<'c>: ForecastHands<'c> {
    /// Returns what viewers see.
    fn viewed(&mut self) -> Viewed<'_, 'c, Self::Ports>;

    /// Notes which moves of the job the motors make.
    fn follow_moves(&mut self);

    /// Puts an operator's factors in force, unless the machine is halted.
    fn set_factors(&mut self, factors: Factors);
}

impl<'c, P: Ports> ViewedHands<'c> for Machine<'c, P> {
    fn viewed(&mut self) -> Viewed<'_, 'c, P> {
        let Self { world, program, safety, axes, features, jobs, tuning, outputs, bed, .. } = self;
        Viewed {
            world,
            program,
            mode: safety.told_mode(),
            axes,
            fans: &features.fans,
            jobs,
            travel: &mut safety.travel,
            tuning,
            outputs,
            bed,
            beam: &features.beam,
            macros: features.macros.readings,
            last_job: &mut features.last_job,
        }
    }

    fn follow_moves(&mut self) {
        self.follow_job();
    }

    fn set_factors(&mut self, Factors { rapid, spindle }: Factors) {
        if self.safety.is_halted() {
            return;
        }
        if let Some(rapid) = rapid {
            self.world.ports.motion(|motion| motion.set_overrides(motion.overrides().feed, rapid));
        }
        if let Some(factor) = spindle {
            self.outputs.override_spindle((factor * 100.0) as f32);
            program_io::say_spindle(&mut self.world, &mut self.outputs);
        }
    }
}

/// Most ends of moves that are told at a look.
const MOST_ENDS: usize = 64;

/// Viewers, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: ViewedHands<'c>> Moments<M> for Feature {
    fn each_10_ms(hands: &mut M, now: Micros) {
        if hands.world().ports.wants_snapshot() {
            show(hands, now);
        }
        if let Some(factors) = hands.world().ports.take_factors() {
            hands.set_factors(factors);
        }
        if let Some(is_drawn) = hands.world().ports.follows_path() {
            follow_path(hands, is_drawn);
        }
    }

    fn job_begins(hands: &mut M, from: JobBegins) {
        match from {
            JobBegins::Whole | JobBegins::FurtherOn | JobBegins::Elsewhere => {
                let ports = &mut hands.world().ports;
                ports.motion(Motion::begin_path);
                ports.begin_path();
            }
            // The same job, on the way back to where it was.
            JobBegins::Again => {}
        }
    }

    fn job_ends(hands: &mut M, is_done: bool, _to: Recipient) {
        keep_job(hands, if is_done { JobEnd::Complete } else { JobEnd::Cancelled });
    }

    fn job_is_dropped(hands: &mut M) {
        keep_job(hands, JobEnd::Halted);
    }
}

/// Tells which places on the path the motors have come to since the last look.
#[inline(never)]
fn follow_path<'c, H: ViewedHands<'c>>(hands: &mut H, is_drawn: bool) {
    let World { ports, config, .. } = hands.viewed().world;
    // A printer lays material with its extruder; other machines cut it with moves of work.
    let is_printer = config.heaters().next().is_some();
    let add = |ports: &mut H::Ports, end: MoveEnd| {
        ports.add_to_path(end.at, if is_printer { end.extrudes } else { end.is_work });
    };
    for _ in 0..MOST_ENDS {
        let Some(end) = ports.motion(Motion::take_end_of_move) else { break };
        add(ports, end);
    }
    ports.motion(|motion| motion.watch_path(is_drawn));
    if let Some(end) = ports.motion(|motion| motion.place_on_curve()) {
        add(ports, end);
    }
}

/// Never inlined: a snapshot takes a kilobyte of the stack, which every wait would have below it.
#[inline(never)]
fn show<'c>(hands: &mut impl ViewedHands<'c>, now: Micros) {
    let snapshot = snapshot(hands, now);
    hands.world().ports.show(&snapshot);
}

/// Returns the machine as it is now.
pub(crate) fn snapshot<'c>(hands: &mut impl ViewedHands<'c>, now: Micros) -> Snapshot {
    let job = job(hands, now);
    let Viewed { world, program, mode, axes, fans, travel, tuning, outputs, bed, beam, macros, last_job, .. } =
        hands.viewed();
    let config = world.config;
    let modal = program.modal();
    let is_live = is_live(mode.state());
    let (position, speed, factors, most) = world.ports.motion(|motion| {
        let at = if is_live { motion.live_position() } else { motion.commanded_position() };
        let most = motion.config().map(|config| &config.limits);
        let most = most.map(|most| (most.max_speed.map(|speed| speed.0), most.acceleration.get()));
        (at, motion.speed(), motion.overrides(), most.unwrap_or_default())
    });
    let mut snapshot = Snapshot {
        state: mode.state(),
        is_suspended: mode.is_suspended(),
        position,
        work: modal.work(&position),
        ends: travel.up_to_date(config, tuning).ends(),
        system: modal.system as u8,
        systems: core::array::from_fn(|system| modal.systems.get(system).copied().unwrap_or_default()),
        shift: modal.shift,
        absolute: [modal.absolute, modal.e_absolute],
        flow_factor: program.tools().active().map_or(1.0, |tool| tool.flow),
        speed,
        feed_rate: modal.feed_rate,
        feed_factor: factors.feed * modal.speed_factor,
        rapid_factor: factors.rapid,
        homed: axes.homed(),
        job: job.or_else(|| last_job.clone()),
        most,
        macros,
        ..Snapshot::default()
    };
    equipment::add(&mut snapshot, world, program, tuning, outputs);
    snapshot.laser = laser::shown(world, program, beam, mode.state());
    world.ports.heat(|heat| add_heat(&mut snapshot, config, heat, fans));
    snapshot.mesh = mesh::shown(bed, &mut world.ports);
    snapshot
}

/// Keeps the job that ends, for viewers to come.
fn keep_job<'c>(hands: &mut impl ViewedHands<'c>, end: JobEnd) {
    let now = hands.world().ports.now();
    if let Some(job) = job(hands, now) {
        *hands.viewed().last_job = Some(JobShown { end: Some(end), left_s: None, is_heating: false, ..job });
    }
}

fn job<'c>(hands: &mut impl ViewedHands<'c>, now: Micros) -> Option<JobShown> {
    hands.follow_moves();
    let time_left = forecast::time_left(&mut hands.forecast());
    hands.viewed().jobs.shown(now, &time_left)
}

fn add_heat(snapshot: &mut Snapshot, config: &MachineConfig, heat: &HeatControl, fans: &Fans) {
    snapshot.heaters = config
        .heaters()
        .zip(heat.heaters())
        .map(|((_, described), (_, heater))| HeaterShown {
            reading: heater.reading(),
            target: heater.target(),
            power: f32::from(heater.duty().0) / 255.0,
            ..HeaterShown::named(described)
        })
        .collect();
    let powers = fans.powers(|switch| heat.switch_duty(switch.0));
    snapshot.fans = config
        .fans
        .iter()
        .zip(powers)
        .enumerate()
        .map(|(place, (fan, power))| FanShown {
            name: fan.name.clone(),
            power,
            rpm: fan.tachometer.pin.map(|_| fans.rpm(place)),
        })
        .collect();
}
