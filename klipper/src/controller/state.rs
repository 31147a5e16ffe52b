//! State of the controller, and the two things that concern all of it: configuration and shutdown.

use motion::queue::StepQueue;

use super::job::Job;
use crate::board::Board;
use crate::moves::{Moves, Pool};
use crate::numbers::CLOCK_HZ;
use crate::objects::Object;
use crate::objects::lights::{Lights, MOST_STRIPS};
use crate::outbox::Outbox;
use crate::reason::Reason;
use crate::steppers::Steppers;
use crate::table::Response;
use crate::timers::{MAX_OBJECTS, SILENCE, STATISTICS, Timers};
use crate::wire::Block;

/// Outcome of a command.
pub(super) type Outcome = Result<(), Reason>;

/// Time between two messages of statistics: 5 s.
pub(super) const STATISTICS_TICKS: u32 = 5 * CLOCK_HZ;

/// Configuration by the host, as far as it has come.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Configuration {
    /// Number of objects; zero before there are some.
    pub(super) oids: u8,
    /// Number that the host has given the configuration, once it is whole.
    pub(super) crc: Option<u32>,
}

/// Statistics of the turns of the task that executes commands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turns {
    pub(super) count: u32,
    pub(super) sum: u32,
    pub(super) sum_of_squares: u32,
}

/// Commands of a block that wait for a bus.
pub(super) struct Rest {
    pub(super) block: Block,
    /// Bytes of its content that are done.
    pub(super) done: usize,
}

/// The board as a micro-controller of a Klipper host.
pub struct Controller<B: Board> {
    pub(super) board: B,
    pub(super) objects: [Object<B>; MAX_OBJECTS],
    pub(super) configuration: Configuration,
    pub(super) steppers: Steppers,
    pub(super) pool: Pool,
    pub(super) timers: Timers,
    pub(super) out: Outbox,
    /// First reason of the shutdown that the board is in.
    pub(super) shutdown: Option<Reason>,
    pub(super) turns: Turns,
    /// Time of the last turn of that task.
    pub(super) turned_at: u32,
    pub(super) heard_at: u32,
    pub(super) is_silent: bool,
    pub(super) strips: heapless::Vec<Lights<B::Strip>, MOST_STRIPS>,
    /// An accelerometer is to be asked.
    pub(super) wants_measurement: bool,
    pub(super) job: Option<Job<B>>,
    pub(super) job_is_out: bool,
    pub(super) rest: Option<Rest>,
    pub(super) wants_reset: bool,
    pub(super) has_told_damage: bool,
}

impl<B: Board> Controller<B> {
    /// Creates a controller that nobody has configured.
    pub fn new(board: B, moves: &'static mut Moves, queue: &'static StepQueue) -> Self {
        let now = board.clock();
        let mut timers = Timers::new();
        timers.set(STATISTICS, now.wrapping_add(STATISTICS_TICKS));
        timers.set(SILENCE, now);
        let mut out = Outbox::new();
        out.send(Response::Starting, &[]);
        Self {
            board,
            objects: [const { Object::None }; MAX_OBJECTS],
            configuration: Configuration::default(),
            steppers: Steppers::new(queue),
            pool: Pool::new(moves),
            timers,
            out,
            shutdown: None,
            turns: Turns::default(),
            turned_at: now,
            heard_at: now,
            is_silent: false,
            strips: heapless::Vec::new(),
            wants_measurement: false,
            job: None,
            job_is_out: false,
            rest: None,
            wants_reset: false,
            has_told_damage: false,
        }
    }

    /// Ends the controller, and gives its memory back: moves, and the step queue, which is empty then.
    #[must_use]
    pub fn into_memory(self) -> (&'static mut Moves, &'static StepQueue) {
        (self.pool.into_moves(), self.steppers.into_queue())
    }

    /// Stops everything, and says why. Of several reasons the first one counts.
    pub fn shut_down(&mut self, reason: Reason) {
        if self.shutdown.is_some() {
            return;
        }
        self.shutdown = Some(reason);
        let clock = self.board.clock();
        self.steppers.stop_all(&mut self.pool);
        for (oid, object) in self.objects.iter_mut().enumerate() {
            match object {
                Object::DigitalOut(output) => output.shut_down(&mut self.pool),
                Object::Pwm(channel) => channel.shut_down(&mut self.pool, &mut self.board),
                Object::Endstop(endstop) => endstop.stop(),
                Object::Trigger(trigger) => trigger.shut_down(),
                // Inputs go on reporting, so that the host sees temperatures.
                Object::Analog(_) | Object::Buttons(_) | Object::Counter(_) => continue,
                Object::TmcUart(uart) => uart.shut_down(),
                Object::None
                | Object::Stepper(_)
                | Object::Spi(_)
                | Object::SpiShutdown(_)
                | Object::I2c(_)
                | Object::Accelerometer(_)
                | Object::Lights(_) => {}
            }
            self.timers.clear(oid as u8);
        }
        self.out.send(Response::Shutdown, &[clock, u32::from(reason.number())]);
    }

    /// Holds heaters off while the host is silent, or lets them go on.
    pub(super) fn hold_heaters(&mut self, is_held: bool) {
        for object in &mut self.objects {
            match object {
                Object::DigitalOut(output) => output.hold(is_held),
                Object::Pwm(channel) => channel.hold(is_held, &mut self.board),
                _ => {}
            }
        }
    }

    /// Puts a new object at a number that is free, before the configuration is whole.
    pub(super) fn configure(&mut self, oid: u8, object: Object<B>) -> Outcome {
        self.may_configure(oid)?;
        if let Some(place) = self.objects.get_mut(usize::from(oid)) {
            *place = object;
        }
        Ok(())
    }

    /// Whether a new object may have this number.
    pub(super) fn may_configure(&self, oid: u8) -> Outcome {
        if self.configuration.crc.is_some() {
            return Err(Reason::AlreadyFinalized);
        }
        match self.objects.get(usize::from(oid)) {
            Some(Object::None) if oid < self.configuration.oids => Ok(()),
            _ => Err(Reason::CannotAssignOid),
        }
    }
}

/// The object of a number, if it is of the kind that the command is for.
macro_rules! object {
    ($self:ident, $oid:expr, $kind:ident) => {
        match $self.objects.get_mut(usize::from($oid)) {
            Some($crate::objects::Object::$kind(object)) => object,
            _ => return Err($crate::Reason::InvalidOid),
        }
    };
}
pub(super) use object;
