//! The executor: the one loop over the whole machine. It takes lines from sessions, files and scripts, has the program say what
//! they mean, carries that out, waits where it must, and serves everybody at each waiting point.
//!
//! Nothing outside this folder sees the whole machine. Sequences that take time are handed [`Hands`]; everything else gets the
//! owners it needs as arguments.

mod actions;
mod boot;
mod commands;
mod frames;
mod functions;
mod halt;
mod hands;
mod lines;
mod serve;
mod shapes;
mod suspend;

use config::MachineConfig;
use motion::{Refusal, Tag};
use program::{Facts, Interpreter, State, States};
use units::{Axis, AxisSet, Micros};

pub use hands::Hands;

use crate::arms::halts_out_of_reach;
use crate::axes::Axes;
use crate::bed::Bed;
use crate::failure::{Failure, message};
use crate::files::Files;
use crate::jobs::Jobs;
use crate::outputs::Outputs;
use crate::ports::Ports;
use crate::safety::{Event, Safety};
use crate::sessions::{Recipient, Sessions};
use crate::tuning::Tuning;
use crate::wait::yield_once;
use frames::Frames;
use serve::Polls;

/// The machine: who owns what.
pub(crate) struct Machine<'c, P: Ports> {
    ports: P,
    /// As it was read.
    config: &'c MachineConfig,
    /// How long reading it took, from the card's mounting on.
    config_took: Micros,
    /// What the lines mean.
    program: Interpreter,
    /// Who talks to it.
    sessions: Sessions,
    /// Whether it may move.
    safety: Safety,
    axes: Axes,
    bed: Bed,
    outputs: Outputs,
    jobs: Jobs,
    files: Files,
    tuning: Tuning,
    /// What lines have started that is to be done before anything else.
    frames: Frames<'c>,
    /// What moves are made for at present.
    tag: Tag,
    /// Axes that have a switch to home with.
    can_home: AxisSet,
    polls: Polls,
    /// Saved settings were loaded since boot.
    settings_loaded: bool,
}

/// Boots and serves, for ever. The board polls this in `idle`, the host runner in virtual time; it yields at every wait.
pub async fn run<P: Ports>(mut ports: P) -> ! {
    let mut config = MachineConfig::default();
    let mut sessions = Sessions::new();
    let read = boot::read_config(&mut ports, &mut sessions, &mut config).await;
    let mut machine = Machine::new(ports, &config, sessions, read.took);
    boot::start(&mut machine, read).await;
    loop {
        machine.serve();
        if !lines::run_next(&mut machine).await {
            yield_once().await;
        }
    }
}

impl<'c, P: Ports> Machine<'c, P> {
    fn new(ports: P, config: &'c MachineConfig, sessions: Sessions, config_took: Micros) -> Self {
        let homes = |axis: &Axis| config.homing_endstop(*axis).is_some();
        Self {
            ports,
            config,
            config_took,
            program: Interpreter::new(crate::program_setup::setup(config)),
            sessions,
            safety: Safety::default(),
            axes: Axes::new(config),
            bed: Bed::new(&config.leveling),
            outputs: Outputs::new(&config.switches),
            jobs: Jobs::default(),
            files: Files::default(),
            tuning: Tuning::new(config),
            frames: Frames::default(),
            tag: Tag::NONE,
            can_home: AxisSet::collect(Axis::ALL.into_iter().filter(homes)),
            polls: Polls::default(),
            settings_loaded: false,
        }
    }

    /// What the program must know of the machine.
    const fn facts(&self) -> Facts {
        Facts { homed: self.axes.homed(), can_home: self.can_home }
    }

    /// Says something to one recipient.
    fn say(&mut self, to: Recipient, text: core::fmt::Arguments<'_>) {
        self.sessions.say(to, text);
    }

    /// Says something to every session.
    fn announce(&mut self, text: core::fmt::Arguments<'_>) {
        self.sessions.say(Recipient::All, text);
    }

    // --- waiting ---

    /// One turn of a wait: serves everybody, yields, and ends the wait when the machine halts.
    async fn pause(&mut self) -> Result<(), Failure> {
        self.serve();
        if self.safety.is_halted() {
            return Err(Failure::Halted);
        }
        yield_once().await;
        Ok(())
    }

    /// Waits while the safety door is open. What a halted machine may do too needs not wait: ends and reports.
    async fn wait_for_door(&mut self, allowed: States) -> Result<(), Failure> {
        while self.safety.state() == State::Door && !allowed.has(State::Alarm) {
            self.pause().await?;
        }
        Ok(())
    }

    /// Waits until everything queued has been executed. In homing, probing and jogging the state stays what it is.
    async fn standstill(&mut self) -> Result<(), Failure> {
        self.ports.motion(motion::Motion::flush);
        while !self.ports.motion(|motion| motion.is_idle()) {
            self.pause().await?;
        }
        if matches!(self.safety.state(), State::Run | State::Jog) {
            self.safety.apply(Event::Drained);
        }
        if self.safety.is_halted() { Err(Failure::Halted) } else { Ok(()) }
    }

    /// Waits for a length of time, whatever moves.
    async fn wait(&mut self, time: Micros) -> Result<(), Failure> {
        let since = self.ports.now();
        while self.ports.now().since(since) < time {
            self.pause().await?;
        }
        Ok(())
    }

    /// Waits until whoever listens has taken most of what was said. One that does not take anything is forgotten by the sessions.
    async fn drain(&mut self, who: Recipient) {
        while !self.sessions.have_taken_most(who) {
            self.serve();
            yield_once().await;
        }
    }

    // --- moving ---

    fn enable_motors(&mut self) -> Result<(), Failure> {
        let now = self.ports.now();
        self.axes.enable(&mut self.ports, self.config, &self.tuning, now)
    }

    /// Submits a move, waiting while the look-ahead queue is full.
    async fn submit(&mut self, request: &motion::Move) -> Result<(), Failure> {
        if !self.axes.are_enabled() {
            self.enable_motors()?;
        }
        loop {
            match self.ports.motion(|motion| motion.submit(request)) {
                Ok(()) => break,
                Err(Refusal::Full | Refusal::Stopping) => self.pause().await?,
                Err(Refusal::NoFeedRate) => return Err(Failure::alarm("Undefined feed rate")),
                Err(refusal @ Refusal::Unreachable) if !halts_out_of_reach(self.config) => {
                    return Err(Failure::Refused(message(format_args!("{refusal}"))));
                }
                Err(refusal) => return Err(Failure::Alarm(message(format_args!("{refusal}")))),
            }
        }
        self.safety.apply(Event::Started);
        Ok(())
    }
}
