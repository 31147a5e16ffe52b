//! The dispatcher: boots the machine, then reads lines and runs them, for ever.
//!
//! One object holds what only the dispatcher touches. Its abilities are spread over files by topic, each an `impl` of
//! this type: `boot`, `serve` (what happens at every waiting point), `halt`, `dispatch` and the codes it leads to,
//! `homing`, `player`, `shell`.

use config::MachineConfig;
use heapless::{String, Vec};
use units::{Micros, MmPerSecond, PerAxis};

use crate::arms::MotorSpace;
use crate::console::{Consoles, Target};
use crate::failure::Failure;
use crate::files::{CARD, Upload};
use crate::halt::HaltWatch;
use crate::levelling::Levelling;
use crate::limits::LimitWatch;
use crate::modal::{Modal, Saved};
use crate::overrides::Overrides;
use crate::park::ParkPosition;
use crate::player::Player;
use crate::ports::{PATH_BYTES, Ports};
use crate::probing::Probing;
use crate::punctuality::PunctualityWatch;
use crate::splines::Splines;
use crate::state::{Event, State};
use crate::switches::SwitchBank;
use crate::tools::Tools;
use crate::wait::yield_once;

/// How deep M120 saves.
const SAVED_STATES: usize = 8;
/// A console that takes nothing for this long has no listener; its output is dropped.
const LISTENER_TIMEOUT: Micros = Micros::from_seconds(2);
/// Output may run this far ahead of a console before its producer waits.
const OUTPUT_AHEAD: usize = 512;

/// The machine's controller. Owns all state that only the dispatcher touches.
#[derive(Debug)]
pub struct Controller<P: Ports> {
    pub(crate) ports: P,
    pub(crate) config: MachineConfig,
    /// How long reading it took, from the card's mounting on.
    pub(crate) config_took: Micros,
    pub(crate) consoles: Consoles,
    /// Where replies of the line being run go.
    pub(crate) target: Target,
    pub(crate) state: State,
    pub(crate) modal: Modal,
    pub(crate) splines: Splines,
    pub(crate) saved: Vec<Saved, SAVED_STATES>,
    /// Machine position where the last accepted move ends.
    pub(crate) position: PerAxis<f64>,
    pub(crate) tools: Tools,
    pub(crate) switches: SwitchBank,
    pub(crate) player: Player,
    /// Saved settings.
    pub(crate) overrides: Overrides,
    /// File being uploaded (M28).
    pub(crate) upload: Option<Upload>,
    /// Directory that relative names start from.
    pub(crate) directory: String<PATH_BYTES>,
    /// Homed axes, one bit each.
    pub(crate) homed: u8,
    pub(crate) park_position: ParkPosition,
    /// Correction of homing positions (M206), mm.
    pub(crate) home_offset: PerAxis<f64>,
    /// Set while X, Y and Z are motors (homing of towers and arms).
    pub(crate) motor_space: Option<MotorSpace>,
    pub(crate) probing: Probing,
    /// What probing a bed starts from.
    pub(crate) levelling: Levelling,
    /// Motors with current, one bit each.
    pub(crate) motors_on: u8,
    /// Motors at their standstill current, one bit each.
    pub(crate) resting_motors: u8,
    /// Nothing has moved since then.
    pub(crate) standing_since: Micros,
    /// The configuration could not be used: nothing may move or heat.
    pub(crate) crippled: bool,
    pub(crate) halt_watch: HaltWatch,
    pub(crate) limits: LimitWatch,
    pub(crate) punctuality: PunctualityWatch,
    pub(crate) poll_due: Micros,
    pub(crate) led_due: Micros,
    pub(crate) led_phase: u8,
}

impl<P: Ports> Controller<P> {
    /// A controller that has not booted.
    #[must_use]
    pub fn new(ports: P) -> Self {
        Self {
            ports,
            config: MachineConfig::default(),
            config_took: Micros(0),
            consoles: Consoles::new(),
            target: Target::Nobody,
            state: State::Idle,
            modal: Modal::new(MmPerSecond(0.0), MmPerSecond(0.0)),
            splines: Splines::default(),
            saved: Vec::new(),
            position: PerAxis([0.0; units::MAX_AXES]),
            tools: Tools::default(),
            switches: SwitchBank::default(),
            player: Player::default(),
            overrides: Overrides::default(),
            upload: None,
            // The card's name fits.
            directory: String::try_from(CARD).unwrap_or_default(),
            homed: 0,
            park_position: ParkPosition::default(),
            home_offset: PerAxis([0.0; units::MAX_AXES]),
            motor_space: None,
            probing: Probing::default(),
            levelling: Levelling::default(),
            motors_on: 0,
            resting_motors: 0,
            standing_since: Micros(0),
            crippled: false,
            halt_watch: HaltWatch::default(),
            limits: LimitWatch::default(),
            punctuality: PunctualityWatch::default(),
            poll_due: Micros(0),
            led_due: Micros(0),
            led_phase: 0,
        }
    }

    /// The world, for a host that shares it.
    pub const fn ports(&mut self) -> &mut P {
        &mut self.ports
    }

    /// What the machine is doing.
    #[must_use]
    pub const fn state(&self) -> State {
        self.state
    }

    /// The machine as configured.
    #[must_use]
    pub const fn config(&self) -> &MachineConfig {
        &self.config
    }

    /// Boots and serves. The board polls this in `idle`, the host runner in virtual time; it yields at every wait.
    pub async fn run(&mut self) -> ! {
        self.boot().await;
        loop {
            self.serve();
            if self.overrides.is_loading() {
                self.replay_settings().await;
            } else if let Some((console, line)) = self.consoles.take_line() {
                self.target = Target::Console(console);
                self.run_console_line(console, &line).await;
                self.consoles.answered(console);
                self.drain().await;
            } else if !self.run_next_job().await {
                yield_once().await;
            }
        }
    }

    /// Everything that runs without a line from a console: a file, an input switch. False when there was nothing.
    async fn run_next_job(&mut self) -> bool {
        if let Some(command) = self.take_switch_command() {
            self.target = Target::Nobody;
            self.run_line(command.as_bytes()).await;
            return true;
        }
        self.play_next_line().await
    }

    // --- replies ---

    /// Writes to whoever sent the present line.
    pub(crate) fn say(&mut self, text: core::fmt::Arguments<'_>) {
        self.consoles.write(self.target, text);
    }

    /// Writes to every console.
    pub(crate) fn announce(&mut self, text: core::fmt::Arguments<'_>) {
        self.consoles.write(Target::All, text);
    }

    /// Waits until the listener has taken most of what was said.
    pub(crate) async fn drain(&mut self) {
        let since = self.ports.now();
        while self.consoles.backlog(self.target) > OUTPUT_AHEAD {
            self.serve();
            if self.ports.now().since(since) > LISTENER_TIMEOUT {
                self.consoles.forget_output(self.target);
                return;
            }
            yield_once().await;
        }
    }

    // --- waiting ---

    /// One turn of a wait: serves consoles, yields, and ends the wait when the machine is halted.
    pub(crate) async fn pause(&mut self) -> Result<(), Failure> {
        self.serve();
        if self.state == State::Halt {
            return Err(Failure::Halted);
        }
        yield_once().await;
        Ok(())
    }

    /// Waits until everything queued has been executed.
    pub(crate) async fn wait_idle(&mut self) -> Result<(), Failure> {
        self.ports.motion(motion::Motion::flush);
        while !self.ports.motion(|motion| motion.is_idle()) {
            self.pause().await?;
        }
        self.apply(Event::Drained);
        if self.state == State::Halt { Err(Failure::Halted) } else { Ok(()) }
    }

    /// Waits for a length of time, once everything queued has been executed.
    pub(crate) async fn dwell(&mut self, time: Micros) -> Result<(), Failure> {
        self.wait_idle().await?;
        self.wait_for(time).await
    }

    /// Waits for a length of time, whatever moves.
    pub(crate) async fn wait_for(&mut self, time: Micros) -> Result<(), Failure> {
        let since = self.ports.now();
        while self.ports.now().since(since) < time {
            self.pause().await?;
        }
        Ok(())
    }

    /// Applies an event to the state table; an event without an arm changes nothing. True when it was accepted.
    pub(crate) const fn apply(&mut self, event: Event) -> bool {
        match self.state.next(event) {
            Some(next) => {
                self.state = next;
                true
            }
            None => false,
        }
    }
}
