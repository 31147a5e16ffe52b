//! The native runner: the same machine code as on the board, against the same simulated machine, in virtual
//! time and without an emulator. For long jobs and for tests of behaviour; the image itself is proven on the
//! virtual board.
//!
//! Time advances in slots of half a millisecond, the period of the board's fastest periodic tasks. In each
//! slot the tasks run in the order of their priorities on the board, then the step events due in the slot
//! are played at their exact ticks. So step times are those of the board; only the moments at which
//! the executor sees something, and at which holds and overrides take effect, differ.

mod bank;
pub mod curves;
mod job;
mod network;
mod pins;
mod ports;
mod sensors;
mod setup;
mod shared;
mod simulation;
mod storage;
mod tasks;
mod verify;

use std::convert::Infallible;
use std::rc::Rc;

use base::motion_config::motion_config;
use base::ports::{StepTimes, Wake};
use base::sessions::SessionId;
use config::MachineConfig;
use corosensei::stack::DefaultStack;
use corosensei::{Coroutine, CoroutineResult};
use machine::{MACRO_CODE_BYTES, MACRO_LINES_BYTES, MacroMemory, MacroStore, MacroText, MacroVariables};
use thermal::HeatControl;

use crate::output::StepError;
use crate::world::{World, WorldConfig};
pub use job::{Job, plan, run, verify};
pub use network::SimulatedNetwork;
pub use ports::HostPorts;
pub use setup::Setup;
use setup::describe;
use shared::Shared;
pub use storage::CardState;
pub use tasks::FeedPhase;
use tasks::{Inputs, SLOT_NS, Tasks};
use verify::Watch;
pub use verify::other_board::{InSearches, Mismatch};
pub use verify::plan::{Plan, PlannedMotion};

/// The executor, on a stack of its own: it waits by a call, which comes back here.
type Executor = Coroutine<(), Wake, Infallible, DefaultStack>;

/// Stack of the executor. Unused pages take no memory; without optimisation the executor needs ten times as
/// many as on the board.
const STACK_BYTES: usize = 8 << 20;

/// Turns of the executor in a slot: on the board it runs whenever nothing else does.
const TURNS_PER_SLOT: u32 = 16;

/// A machine that runs on the host.
pub struct Runner {
    /// The machine's side of everything the executor and the tasks share.
    shared: Rc<Shared>,
    executor: Executor,
    tasks: Tasks,
    machine: MachineConfig,
    slot_ns: u64,
    turns: u32,
}

impl std::fmt::Debug for Runner {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Runner").field("now_ns", &self.now_ns()).finish_non_exhaustive()
    }
}

impl Runner {
    /// Makes the machine at power-on.
    ///
    /// # Errors
    /// When a fault names something the machine does not have.
    pub fn new(setup: &Setup) -> Result<Self, String> {
        let (machine, board_id) = describe(setup);
        let built = setup.built_as.as_ref().map(|text| config::parse(text.as_bytes(), board_id, &mut ()).0);
        let mut config = WorldConfig::of(built.as_ref().unwrap_or(&machine), setup.chip);
        for (actuator, place) in config.actuators.iter_mut().zip(&setup.carriages) {
            actuator.start_mm = *place;
        }
        let mut world = World::new(config);
        for fault in &setup.faults {
            // A fault at power-on is in force before the first grid point of the physics.
            if fault.at_ns == 0 { world.inject(&fault.fault)? } else { world.schedule(fault.clone())? }
        }
        let inputs = Inputs::of(&machine, &world);
        let shared = Rc::new(Shared::new(world, setup, board_id));
        let stack = DefaultStack::new(STACK_BYTES).map_err(|error| format!("no stack for the executor: {error}"))?;
        let of_executor = Rc::clone(&shared);
        let executor = Coroutine::with_stack(stack, move |yielder, ()| {
            let (mut code, mut lines) = (vec![0; MACRO_CODE_BYTES], vec![0; MACRO_LINES_BYTES]);
            let (mut store, mut text) = (Box::new(MacroStore::new()), Box::new(MacroText::new()));
            let mut variables = Box::new(MacroVariables::new());
            let macros = MacroMemory {
                code: &mut code,
                lines: &mut lines,
                text: &mut text,
                variables: &mut variables,
                store: &mut store,
            };
            machine::run(HostPorts::new(of_executor, yielder), &mut Box::new(machine::Lasting::new()), macros)
        });
        let tasks = Tasks::new(inputs);
        Ok(Self { tasks, shared, executor, machine, slot_ns: 0, turns: TURNS_PER_SLOT })
    }

    /// Returns the virtual time since power-on, nanoseconds.
    #[must_use]
    pub fn now_ns(&self) -> u64 {
        self.shared.simulation.now_ns.get()
    }

    /// Gives access to the simulated machine.
    pub fn world<R>(&self, f: impl FnOnce(&mut World) -> R) -> R {
        f(&mut self.shared.simulation.world.borrow_mut())
    }

    /// Gives a checker access to the motion object.
    pub fn motion<R>(&self, f: impl FnOnce(&mut motion::Motion) -> R) -> R {
        f(&mut self.shared.motion.borrow_mut())
    }

    /// Gives a checker access to heat control.
    pub fn heat<R>(&self, f: impl FnOnce(&HeatControl) -> R) -> R {
        f(&self.shared.heat.borrow())
    }

    /// Returns whether an input is armed that stops the motors at once, without braking.
    #[must_use]
    pub fn hard_stop_is_armed(&self) -> bool {
        self.shared.latch.armed() != 0 && self.shared.latch.is_hard()
    }

    /// Returns the configuration from which the simulated machine was built.
    #[must_use]
    pub const fn machine(&self) -> &MachineConfig {
        &self.machine
    }

    /// Types on a console. False when the inbox could not take all of it.
    pub fn type_on(&self, session: SessionId, text: &str) -> bool {
        self.send_on(session, text.as_bytes())
    }

    /// Sends bytes on a session. False when its inbox could not take all of them.
    pub fn send_on(&self, session: SessionId, bytes: &[u8]) -> bool {
        let place = usize::from(session.0);
        let mut intakes = self.shared.intakes.borrow_mut();
        let (Some(inbox), Some(intake)) = (self.shared.inboxes.get(place), intakes.get_mut(place)) else {
            return false;
        };
        self.shared.news.set(true);
        // Every byte is offered: the machine itself reports losses.
        inbox.receive_all(intake, bytes)
    }

    /// Runs `work` with the network.
    pub fn network<R>(&self, work: impl FnOnce(&mut SimulatedNetwork) -> R) -> R {
        work(&mut self.shared.network.borrow_mut())
    }

    /// Connects somebody to the other end of a session, or disconnects.
    pub fn set_open(&self, session: SessionId, open: bool) {
        let place = usize::from(session.0);
        let mut intakes = self.shared.intakes.borrow_mut();
        let (Some(inbox), Some(intake)) = (self.shared.inboxes.get(place), intakes.get_mut(place)) else { return };
        self.shared.news.set(true);
        if open {
            inbox.open(intake);
        } else {
            inbox.set_open(false);
        }
    }

    /// Reconnects whoever had gone from the other end of a session, perhaps in the middle of a line.
    pub fn come_back(&self, session: SessionId) {
        let place = usize::from(session.0);
        let mut intakes = self.shared.intakes.borrow_mut();
        if let (Some(inbox), Some(intake)) = (self.shared.inboxes.get(place), intakes.get_mut(place)) {
            inbox.open_again(intake);
            self.shared.news.set(true);
        }
    }

    /// Limits the unread bytes of a session from now on.
    pub fn set_room(&self, session: SessionId, bytes: usize) {
        if let Some(sent) = self.shared.sent.borrow_mut().get_mut(usize::from(session.0)) {
            sent.room = bytes;
        }
    }

    /// Returns the bytes that a console has sent since the last call.
    #[must_use]
    pub fn read_from(&self, session: SessionId) -> Vec<u8> {
        let mut consoles = self.shared.sent.borrow_mut();
        consoles.get_mut(usize::from(session.0)).map(|sent| std::mem::take(&mut sent.bytes)).unwrap_or_default()
    }

    /// Returns the number of block writes of the card so far, and whether the power went at one.
    #[must_use]
    pub fn block_writes(&self) -> (u32, bool) {
        self.shared.block_writes()
    }

    /// Returns the most block writes of the card between two reports of the machine to its watchdog.
    #[must_use]
    pub fn most_unseen_writes(&self) -> u32 {
        self.shared.most_unseen_writes()
    }

    /// Pulls the card out, or puts it in again.
    pub fn set_card_state(&self, state: CardState) {
        self.shared.set_card_state(state);
    }

    /// Returns whether the machine asked for a reset.
    #[must_use]
    pub fn reset_requested(&self) -> bool {
        self.shared.reset_requested.get()
    }

    /// Runs one slot of half a millisecond.
    pub fn step(&mut self) {
        self.tasks.periodic(&self.shared);
        let mut rests = false;
        for _ in 0..self.turns {
            // Nothing arrives within a slot, so an executor that waits for time would do so again.
            if !rests {
                rests = match self.executor.resume(()) {
                    CoroutineResult::Yield(wake) => wake == Wake::Time,
                    CoroutineResult::Return(never) => match never {},
                };
            }
            self.shared.motion.borrow_mut().plan();
        }
        self.slot_ns += SLOT_NS;
        self.tasks.play_until(&self.shared, self.slot_ns);
        self.shared.simulation.now_ns.set(self.slot_ns);
    }

    /// Runs until the time `until_ns`.
    pub fn run_until(&mut self, until_ns: u64) {
        while self.now_ns() < until_ns {
            self.step();
        }
    }

    /// Compares every step edge with the oracle from now on.
    ///
    /// # Errors
    /// When the configuration describes no machine that can move.
    pub fn verify(&mut self) -> Result<(), String> {
        self.tasks.watch = Some(Watch::comparing(self.motion_config()?));
        Ok(())
    }

    /// Records the ideal motion from now on, to compare another board's edges with it; with the feed in
    /// these phases while switches are searched for.
    ///
    /// # Errors
    /// When the configuration describes no machine that can move.
    pub fn record(&mut self, phases: &[FeedPhase]) -> Result<(), String> {
        self.tasks.phases = phases.to_vec();
        self.tasks.watch = Some(Watch::recording(self.motion_config()?));
        Ok(())
    }

    fn motion_config(&self) -> Result<motion::MotionConfig, String> {
        motion_config(&self.machine).map_err(|_| "the configuration describes nothing that can move".to_owned())
    }

    /// Returns the number of motions recorded so far.
    #[must_use]
    pub fn recorded_motions(&self) -> usize {
        self.tasks.watch.as_ref().and_then(Watch::plan).map_or(0, |plan| plan.motions().count())
    }

    /// Returns the motion recorded since [`Self::record`].
    #[must_use]
    pub fn take_plan(&mut self) -> Option<Plan> {
        self.tasks.watch.take()?.into_plan()
    }

    /// Sets the executor's number of turns in a slot from now on.
    pub const fn set_turns(&mut self, turns: u32) {
        self.turns = turns;
    }

    /// Keeps the step feed from its next so many runs.
    pub fn block_feed(&mut self, runs: u32) {
        self.tasks.missed_runs = runs;
    }

    /// Stops the task that reads the converter chips of sensors, or lets it run again.
    pub fn hold_sensors(&mut self, stand: bool) {
        self.shared.sensors.borrow_mut().stand = stand;
    }

    /// Sets the board's report of its step times from now on.
    pub fn pretend_step_times(&mut self, times: StepTimes) {
        self.shared.step_times.set(times);
    }

    /// Returns the distances of the edges, when [`Self::verify`] was asked for; an edge without an ideal
    /// crossing is an error.
    #[must_use]
    pub fn step_error(&self) -> Option<Result<StepError, String>> {
        let (error, strays) = self.tasks.watch.as_ref()?.result()?;
        Some(if strays == 0 {
            Ok(error.into())
        } else {
            Err(format!("{strays} step edges are more than a millisecond from where they belong"))
        })
    }

    /// Types a line on the debug console and runs until `ok`, an error or the deadline comes; returns the
    /// text sent.
    pub fn command(&mut self, line: &str, deadline_ns: u64) -> String {
        self.command_on(SessionId(0), line, deadline_ns)
    }

    /// Does the same as [`Self::command`] on any console.
    pub fn command_on(&mut self, session: SessionId, line: &str, deadline_ns: u64) -> String {
        self.type_on(session, line);
        self.type_on(session, "\n");
        let mut text = String::new();
        let end = self.now_ns() + deadline_ns;
        while self.now_ns() < end && !is_answered(&text) {
            self.step();
            text.push_str(&String::from_utf8_lossy(&self.read_from(session)));
        }
        text
    }
}

fn is_answered(text: &str) -> bool {
    text.ends_with('\n')
        && text.lines().next_back().is_some_and(|line| {
            line == "ok"
                || line.starts_with("ok ")
                || line.starts_with("error")
                || line.starts_with("Error")
                || line.starts_with("rs N")
                || line.starts_with("Entering Alarm/Halt state")
                || line == "!!"
        })
}
