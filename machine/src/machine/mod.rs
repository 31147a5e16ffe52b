//! The machine: the owners of its parts, and the services that all work needs: waiting, moving, saying.
//!
//! Nothing here names a feature or the executor: both are called through the traits of [`moments`].

pub(crate) mod abort;
pub(crate) mod card;
pub(crate) mod effects;
pub(crate) mod end_requests;
pub(crate) mod fast_forward;
pub(crate) mod fast_forward_record;
pub(crate) mod feed_hold;
pub(crate) mod frames;
pub(crate) mod halt;
pub(crate) mod hands;
pub(crate) mod heat_restoring;
pub(crate) mod hold;
pub(crate) mod homing;
pub(crate) mod ignored_codes;
pub(crate) mod job_control;
pub(crate) mod jogging;
pub(crate) mod long_answers;
pub(crate) mod moments;
pub(crate) mod move_dropping;
pub(crate) mod moves;
pub(crate) mod operator_pauses;
pub(crate) mod poll_state;
pub(crate) mod probe_script;
pub(crate) mod probe_strategy;
pub(crate) mod program_files;
pub(crate) mod program_io;
pub(crate) mod program_logs;
pub(crate) mod saved_settings;
pub(crate) mod settings_file;
pub(crate) mod source;
pub(crate) mod supplies;
pub(crate) mod suspend;
pub(crate) mod work_hands;

use base::axes::Axes;
use base::bed::Bed;
use base::failure::{Answer, Failure, Outcome, Texts};
use base::motion_config::halts_out_of_reach;
use base::ports::Wake;
use base::reason::Reason;
use base::safety::travel::Travel;
use base::safety::{Event, Safety};
use base::sessions::{Recipient, SessionId, Sessions};
use base::taken_codes::TakenCodes;
use base::tuning::Tuning;
use base::wait::Waited;
use base::{Ports, World};
use config::MachineConfig;
use events::Event as Happened;
use jobs::files::Files;
use jobs::files::logs::Logs;
use jobs::player::Jobs;
use motion::{Refusal, Tag};
use parts::buttons::Buttons;
use parts::outputs::Outputs;
use parts::z_thermal::Thermal;
use preflight::forecast::{ForecastFiles, Forecaster, SharedForecast};
use printer_cfg::Memory;
use procedures::endstop_phase::EndstopPhases;
use procedures::probing::{DeltaRecords, Deployment};
use program::{Facts, Interpreter, State, States};
use units::{Axis, AxisSet, Micros, PerAxis};

use crate::machine::end_requests::Asked;
use crate::machine::fast_forward_record::Passed;
use crate::machine::frames::Frames;
use crate::machine::hold::Hold;
use crate::machine::moments::{Featured, Served};
use crate::machine::move_dropping::Cut;
use crate::machine::poll_state::Polls;

/// The machine, as the owners of its parts.
pub(crate) struct Machine<'c, P: Ports> {
    /// Ports, configuration, texts of failures and sessions.
    pub(crate) world: World<'c, P>,
    /// Time of reading the configuration, from the card's mounting on.
    pub(crate) config_took: Micros,
    /// Interpreter of codes and modes.
    pub(crate) program: Interpreter,
    /// Whether the machine may move.
    pub(crate) safety: Safety,
    pub(crate) axes: Axes,
    pub(crate) phases: EndstopPhases,
    pub(crate) bed: Bed,
    /// Measurements made of a delta.
    delta: DeltaRecords,
    /// State of the probe, out or stowed.
    deployment: Deployment,
    /// Compensation of a frame that grows with heat.
    pub(crate) thermal: Thermal,
    pub(crate) outputs: Outputs,
    pub(crate) buttons: Buttons,
    /// State of the features.
    pub(crate) features: <P as Featured>::States<'c>,
    /// Codes that a feature has taken for its own.
    pub(crate) taken_codes: TakenCodes,
    pub(crate) jobs: Jobs,
    pub(crate) files: Files,
    /// Files that programs write.
    pub(crate) logs: Logs,
    pub(crate) tuning: Tuning,
    /// Work that lines have started and that comes before anything else.
    pub(crate) frames: Frames<'c, <P as Featured>::Step>,
    /// Record of the lines that a fast-forward reads over, until somebody takes it.
    pub(crate) passed: Option<Passed>,
    /// Limits, steps and filters as they were before a file was read over, until its job goes on.
    set_before: Option<motion::MotionConfig>,
    /// The forecast that goes on beside the executor.
    pub(crate) forecast: &'c SharedForecast,
    /// Files that the forecast reads.
    pub(crate) forecast_files: ForecastFiles,
    /// Tag of the moves made at present.
    pub(crate) tag: Tag,
    /// Axes that have a switch to home with.
    can_home: AxisSet,
    pub(crate) polls: Polls,
    /// Operator's factor of feed rates, while the program does not let it count (M49, M50 P0).
    pub(crate) feed_waits: Option<f64>,
    /// Delay of feed holds.
    pub(crate) hold: Hold,
    /// Progress of dropping planned moves that are to be left out.
    pub(crate) cut: Cut,
    /// Requests that do not wait for the line in work.
    pub(crate) urgent: Asked,
    /// Saved settings were loaded since boot.
    pub(crate) settings_loaded: bool,
    /// The look ahead at a file, which goes on in the turns of waits.
    pub(crate) forecaster: &'c mut dyn Forecaster,
}

impl<'c, P: Ports> Machine<'c, P> {
    /// Never inlined: the parts are on the stack meanwhile, and would stay there below all that is polled.
    #[inline(never)]
    pub(crate) fn new(
        ports: P,
        config: &'c MachineConfig,
        texts: &'c Texts,
        sessions: &'c mut Sessions,
        config_took: Micros,
        macros: Memory<'c>,
        (forecast, forecaster): (&'c SharedForecast, &'c mut dyn Forecaster),
    ) -> Self {
        let homes = |axis: &Axis| config.homing_endstop(*axis).is_some();
        Self {
            world: World { ports, config, texts, sessions },
            config_took,
            program: Interpreter::new(base::program_setup::setup(config)),
            safety: Safety::default(),
            axes: Axes::new(config),
            phases: EndstopPhases::default(),
            bed: Bed::new(config),
            delta: DeltaRecords::default(),
            deployment: Deployment::default(),
            thermal: Thermal::new(config),
            outputs: Outputs::new(&config.switches),
            buttons: Buttons::new(config),
            features: P::states(config, macros),
            taken_codes: TakenCodes::None,
            jobs: Jobs::new(config.player.dialect),
            files: Files::default(),
            logs: Logs::default(),
            tuning: Tuning::new(config),
            frames: Frames::default(),
            passed: None,
            set_before: None,
            forecast,
            forecast_files: ForecastFiles::default(),
            tag: Tag::NONE,
            can_home: AxisSet::collect(Axis::ALL.into_iter().filter(homes)),
            polls: Polls::default(),
            feed_waits: None,
            hold: Hold::default(),
            cut: Cut::default(),
            urgent: Asked::default(),
            settings_loaded: false,
            forecaster,
        }
    }

    /// Returns the facts about the machine that the program must know.
    pub(crate) const fn facts(&self) -> Facts {
        let [.., probe_height] = self.bed.probe_offsets;
        Facts { homed: self.axes.homed(), can_home: self.can_home, probe_height }
    }

    /// Says something to one recipient.
    pub(crate) fn say(&mut self, to: Recipient, text: core::fmt::Arguments<'_>) {
        self.world.say(to, text);
    }

    /// Says something to every session.
    pub(crate) fn announce(&mut self, text: core::fmt::Arguments<'_>) {
        self.world.announce(text);
    }

    /// Refuses a recipient's request, with the text of a failure.
    pub(crate) fn refuse(&mut self, to: Recipient, why: Failure) {
        self.world.refuse(to, why);
    }

    /// Notes that a line of a session has been answered.
    pub(crate) fn answered(&mut self, id: SessionId) {
        if let Some(session) = self.world.sessions.get_mut(id) {
            session.answered();
        }
    }

    /// Keeps an event, in the ring that survives a reset.
    pub(crate) fn record(&self, event: &Happened) {
        self.world.record(event);
    }

    // --- waiting ---

    /// Serves everybody once: sessions, faults, everything that follows time.
    pub(crate) fn serve(&mut self) {
        <P as Served>::serve(self);
    }

    /// Gives the processor to everybody else: the look ahead has its turn, and then there is rest.
    pub(crate) fn rest(&mut self, wake: Wake) {
        let has_more = self.forecaster.take_turn();
        self.world.ports.rest(if has_more { Wake::AtOnce } else { wake });
    }

    /// Makes one turn of a wait: serves everybody, and rests. All waiting is made of such turns.
    pub(crate) fn wait(&mut self, wake: Wake) -> Waited {
        self.serve();
        let waited = match self.safety.state() {
            _ if self.safety.is_halted() || self.urgent.ends_everything() => Waited::Halted,
            State::Hold | State::Door => Waited::Held,
            _ => Waited::Free,
        };
        self.rest(match wake {
            // A halt ends most waits.
            _ if waited == Waited::Halted => Wake::AtOnce,
            // The look ahead at a file waits for the card.
            Wake::Time if self.forecast_files.is_open() => Wake::Any,
            wake => wake,
        });
        waited
    }

    /// Waits while the safety door is open. Commands that a halted machine may do too, ends and reports, need
    /// not wait.
    pub(crate) fn wait_for_door(&mut self, allowed: States) -> Result<(), Failure> {
        while self.safety.state() == State::Door && !allowed.has(State::Alarm) {
            self.wait(Wake::Time).unless_halted()?;
        }
        Ok(())
    }

    /// Waits until everything queued has been executed. Homing, probing and jogging keep their state.
    pub(crate) fn standstill(&mut self) -> Result<(), Failure> {
        self.world.ports.motion(motion::Motion::flush);
        while !self.world.ports.motion(|motion| motion.is_idle()) {
            self.wait(Wake::Time).unless_halted()?;
        }
        self.drained();
        if self.safety.is_halted() || self.urgent.ends_everything() { Err(Failure::HALTED) } else { Ok(()) }
    }

    /// Waits for a length of time, whatever moves.
    pub(crate) fn wait_for(&mut self, time: Micros) -> Result<(), Failure> {
        let since = self.world.ports.now();
        while self.world.ports.now().since(since) < time {
            self.wait(Wake::Time).unless_halted()?;
        }
        Ok(())
    }

    /// Waits until a recipient has taken most of what was said. A session that takes nothing is forgotten.
    pub(crate) fn drain(&mut self, who: Recipient) {
        while !self.world.sessions.have_taken_most(who) {
            self.wait(Wake::Any).whatever_happens();
        }
    }

    /// Switches check mode (`$C`), in which programs are read and nothing is carried out.
    pub(crate) fn check_mode(&mut self, to: Recipient) -> Outcome {
        if self.safety.apply(Event::CheckEnds) {
            self.resynchronise();
            self.say(to, format_args!("[MSG:Disabled]\n"));
        } else if self.safety.apply(Event::CheckBegins) {
            self.say(to, format_args!("[MSG:Enabled]\n"));
        } else {
            return Err(Failure::refused(&"check mode begins from standstill, without a suspended job"));
        }
        Ok(Answer::Ok)
    }

    // --- moving ---

    pub(crate) fn enable_motors(&mut self) -> Result<(), Failure> {
        let now = self.world.ports.now();
        self.axes.enable(self.world.texts, &mut self.world.ports, self.world.config, &self.tuning, now)
    }

    /// Returns the travel that axes may be commanded within.
    pub(crate) fn travel(&mut self) -> &Travel {
        self.safety.travel.up_to_date(self.world.config, &self.tuning)
    }

    /// Whether a straight move stays within the travel.
    pub(crate) fn stays_within(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Failure> {
        let homed = self.axes.homed();
        self.travel().check(from, to, homed).map_err(|out| out.failure(self.world.texts, self.world.config))
    }

    /// Submits a move, waiting while the look-ahead queue is full.
    pub(crate) fn submit(&mut self, request: &motion::Move) -> Result<(), Failure> {
        if self.urgent.ends_everything() {
            return Err(Failure::HALTED);
        }
        if !self.axes.are_enabled() {
            self.enable_motors()?;
        }
        loop {
            match self.world.ports.motion(|motion| motion.submit(request)) {
                Ok(()) => break,
                Err(Refusal::Full | Refusal::Stopping) => {
                    self.cut.has_line_behind = true;
                    let waited = self.wait(Wake::Any);
                    self.cut.has_line_behind = false;
                    waited.unless_halted()?;
                }
                Err(Refusal::NoFeedRate) => {
                    return Err(self
                        .world
                        .texts
                        .alarm(format_args!("Undefined feed rate"))
                        .with_reason(Reason::FeedRate));
                }
                Err(refusal @ Refusal::Unreachable) if !halts_out_of_reach(self.world.config) => {
                    return Err(self.world.texts.refused(format_args!("{refusal}")).with_reason(Reason::Target));
                }
                Err(refusal) => {
                    return Err(self.world.texts.alarm(format_args!("{refusal}")).with_reason(Reason::Target));
                }
            }
        }
        self.safety.apply(Event::Started);
        Ok(())
    }

    /// Marks these axes as homed: Z's shift for the frame's temperature counts from here.
    pub(crate) fn mark_homed(&mut self, axes: AxisSet) {
        self.axes.mark_homed(axes);
        if axes.has(Axis::Z) {
            self.thermal.homed();
            self.program.set_thermal_z(0.0);
        }
    }

    /// Marks axes as homed on somebody's word for their places.
    pub(crate) fn declare_homed(&mut self, axes: AxisSet) {
        self.mark_homed(axes);
        self.axes.stray(axes);
    }

    // --- following ---

    /// Has the program go on from where the machine is, after a stop that ended somewhere else than
    /// commanded.
    pub(crate) fn resynchronise(&mut self) {
        let position = self.world.ports.motion(|motion| motion.commanded_position());
        self.program.resynchronise(position);
    }

    /// Has the program go on from where the machine is, after something that ends from standstill.
    pub(crate) fn resynchronise_if_still(&mut self) {
        if self.world.ports.motion(|motion| motion.is_idle()) {
            self.resynchronise();
        }
    }

    /// Follows the end of the last move.
    fn drained(&mut self) {
        let state = self.safety.state();
        if matches!(state, State::Run | State::Jog) {
            self.safety.apply(Event::Drained);
        }
        if state == State::Jog {
            // A jog may have been cancelled on its way.
            self.resynchronise();
        }
    }

    /// Follows the planner's state where nothing else says the machine's.
    pub(crate) fn follow_motion(&mut self) {
        let idle = self.world.ports.motion(|motion| motion.is_idle());
        let state = self.safety.state();
        if idle {
            self.drained();
        } else if matches!(state, State::Idle | State::Suspended) {
            self.safety.apply(Event::Started);
        }
    }

    /// Tells the jobs which of their moves the motors make: none while they rest.
    pub(crate) fn follow_job(&mut self) {
        let executing = self.world.ports.motion(|motion| (!motion.is_idle()).then(|| motion.passed().tag));
        self.jobs.executing(executing);
    }
}
