//! State that the executor, the tasks and the runner share.

use std::rc::Rc;
use std::sync::atomic::AtomicU32;

use base::ports::{DateTime, InputLevels, StepTimes};
use base::sessions::SessionProfile;
use base::sessions::{ConsoleKind, INBOX_BYTES, Inbox, InboxOf, Intake, NETWORK_INBOX_BYTES};
use base::supervisor::Supervisor;
use config::{BoardId, MachineConfig};
use events::{Cause, Event, EventRing, Slots};
use motion::queue::StepQueue;
use motion::{Latch, Motion};
use thermal::HeatControl;
use units::Micros;

use super::bank::Bank;
use super::network::SimulatedNetwork;
use super::sensors::Sensors;
use super::setup::Setup;
use super::simulation::{Flag, Simulation, Turns};
use super::storage::{Card, CardState};
use crate::world::World;

/// Consoles of the host: the debug UART and UART 0.
const CONSOLES: usize = 2;

/// Bytes that a session has sent and nobody has read.
pub struct Sent {
    /// Bytes that nobody has read.
    pub bytes: Vec<u8>,
    /// Greatest number of unread bytes that the session takes.
    pub room: usize,
}

impl Default for Sent {
    fn default() -> Self {
        Self { bytes: Vec::new(), room: usize::MAX }
    }
}

impl Sent {
    /// Takes as many of the bytes as there is room for; returns their number.
    pub fn take(&mut self, bytes: &[u8]) -> usize {
        let taken = bytes.len().min(self.room.saturating_sub(self.bytes.len()));
        self.bytes.extend_from_slice(&bytes[..taken]);
        taken
    }
}

/// State that the controller, the tasks and the runner use in turns.
pub struct Shared {
    pub simulation: Rc<Simulation>,
    pub motion: Turns<Motion>,
    pub heat: Turns<HeatControl>,
    pub supervisor: Turns<Supervisor>,
    pub bank: Turns<Bank>,
    pub sensors: Turns<Sensors>,
    pub queue: StepQueue,
    pub latch: Latch,
    pub reached: base::tasks::ReachedMark,
    pub profiles: Vec<SessionProfile>,
    pub inboxes: Vec<Box<Inbox>>,
    pub intakes: Turns<Vec<Intake>>,
    /// Whether an inbox may have changed since the controller last asked.
    pub news: Flag<bool>,
    pub sent: Turns<Vec<Sent>>,
    pub levels: Flag<InputLevels>,
    pub wired: Turns<Option<MachineConfig>>,
    pub reset_requested: Flag<bool>,
    /// Value set on the clock, and the time of setting.
    pub date: Flag<(DateTime, u64)>,
    /// Step times that a test reports: the host has no interrupts that could be late.
    pub step_times: Flag<StepTimes>,
    /// Slots of events, kept over a reset, which a runner never has.
    events: Box<(Slots, AtomicU32)>,
    pub card: Turns<Card>,
    pub network: Turns<SimulatedNetwork>,
    pub board_id: u8,
}

impl Shared {
    /// Makes the state at power-on.
    pub fn new(world: World, setup: &Setup, board_id: BoardId) -> Self {
        let consoles = [SessionProfile::SERIAL; CONSOLES];
        let profiles: Vec<SessionProfile> = consoles.into_iter().chain(setup.visitors.iter().copied()).collect();
        let inbox = |(place, profile): (usize, &SessionProfile)| {
            let inbox: Box<Inbox> = match profile.kind {
                ConsoleKind::Network | ConsoleKind::Web => Box::<InboxOf<NETWORK_INBOX_BYTES>>::default(),
                ConsoleKind::Serial | ConsoleKind::Usb | ConsoleKind::Memory => Box::<InboxOf<INBOX_BYTES>>::default(),
            };
            // Visitors connect only later.
            inbox.set_open(place < CONSOLES);
            inbox
        };
        let shared = Self {
            simulation: Rc::new(Simulation::new(world)),
            motion: Turns::new(Motion::new()),
            heat: Turns::new(HeatControl::new()),
            supervisor: Turns::new(Supervisor::new()),
            bank: Turns::new(Bank::default()),
            sensors: Turns::new(Sensors::default()),
            queue: StepQueue::new(),
            latch: Latch::new(),
            reached: base::tasks::ReachedMark::new(),
            inboxes: profiles.iter().enumerate().map(inbox).collect(),
            intakes: Turns::new(vec![Intake::new(); profiles.len()]),
            sent: Turns::new(profiles.iter().map(|_| Sent::default()).collect()),
            profiles,
            levels: Flag::default(),
            wired: Turns::new(None),
            news: Flag::new(true),
            reset_requested: Flag::new(false),
            date: Flag::new((DateTime::UNSET, 0)),
            step_times: Flag::default(),
            card: Turns::new(Card::new(&setup.card, setup.card_state, setup.writes)),
            network: Turns::new(SimulatedNetwork::default()),
            board_id: u8::from(board_id == BoardId::Prime2660),
            events: Box::new((Slots::new(), AtomicU32::new(1))),
        };
        shared.events().record(Micros(0), &Event::Started { cause: Cause::PowerOn, date: None });
        shared
    }

    /// Returns the ring of recent events.
    pub fn events(&self) -> EventRing<'_> {
        EventRing::new(&self.events.0, &self.events.1)
    }
}

impl Shared {
    /// Returns the most block writes between two reports to the watchdog.
    pub fn most_unseen_writes(&self) -> u32 {
        self.card.borrow().most_unseen_writes()
    }

    /// Returns the number of block writes so far, and whether the power went at one.
    pub fn block_writes(&self) -> (u32, bool) {
        self.card.borrow().block_writes()
    }

    /// Pulls the card out, or puts it in again.
    pub fn set_card_state(&self, state: CardState) {
        self.card.borrow_mut().set_state(state);
    }
}
