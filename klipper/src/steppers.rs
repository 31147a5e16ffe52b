//! Motors: the host's moves to events of the step queue.
//!
//! A move is a number of steps whose distances change by the same amount: step k of it falls at
//! `last + k interval + add k (k - 1) / 2`, modulo 2^32. Steps are written ahead of time in the order of
//! their times, for all motors together; a trigger cuts the queue, and what other motors had in it is put
//! back.

use motion::queue::{StepEvent, StepQueue};
use units::MAX_ACTUATORS;

use crate::board::{Board, MotorSettings};
use crate::moves::{Move, Pool, Queue};
use crate::reason::Reason;

/// Time ahead for which events are written: 0.5 ms.
const HORIZON: i32 = 100_000;
/// The first event of a motor at rest, be it a turn or a step, is so far from now at the least: behind all
/// that has been written, and 5 us more for the way there. Hosts keep 100 ms.
const LEAST_LEAD: i32 = HORIZON + 1000;
/// A direction is set so long before the step, if there is room: 2 us.
const TURN_AHEAD: u32 = 400;
/// A step that is to be written so late is a host that asks for too much: 1 ms, as in Klipper's own firmware.
const MOST_LATE: i32 = 200_000;
/// Time until the queue is looked at again when it was full: the time in which the fastest motors empty a
/// quarter of it.
const FULL_WAIT: u32 = 10_000;

/// Steps of a motor that are written one after the other without a look at anything else.
#[derive(Clone, Copy)]
struct Pace {
    /// Ticks to the next event.
    ahead: i32,
    /// Ticks from the next step to the one behind it.
    interval: u32,
    add: u32,
    /// Steps before the last one of the move. Zero: that is due next, or a turn.
    left: u32,
    /// Word of its steps' events: the motor's number.
    word: u32,
}

impl Pace {
    /// Pace of a motor that has nothing to do.
    const AT_REST: Self = Self { ahead: i32::MAX, interval: 0, add: 0, left: 0, word: 0 };
}

/// Steps of the move that is under way, and what is known of a motor.
#[derive(Debug)]
struct Stepper {
    /// Time of the last step, or of the last `reset_step_clock`.
    last: u32,
    /// Time of the next event.
    next: u32,
    /// Time of the step behind a turn.
    step_behind: u32,
    interval: u32,
    add: u32,
    /// Steps of the move that are still to be written. Zero: the motor is at rest.
    count: u32,
    /// The next event is a turn.
    turns: bool,
    /// Direction of the pin behind all that is written. The pin is low at first, which is direction 0, and
    /// which motion calls forward.
    direction: bool,
    /// Direction of the moves to come.
    direction_to_come: bool,
    /// After a trigger moves are dropped until the host says when time begins anew.
    needs_reset: bool,
    /// Position behind the move that is under way: steps of direction 1 less those of direction 0.
    end: i32,
    pulse_ticks: u32,
    queue: Queue,
}

impl Stepper {
    const fn new(pulse_ticks: u32) -> Self {
        Self {
            last: 0,
            next: 0,
            step_behind: 0,
            interval: 0,
            add: 0,
            count: 0,
            turns: false,
            direction: false,
            direction_to_come: false,
            needs_reset: false,
            end: 0,
            pulse_ticks,
            queue: Queue::EMPTY,
        }
    }

    /// The pace at which its steps are written, with times in ticks from now.
    const fn pace(&self, number: u32, now: u32) -> Pace {
        if self.count == 0 {
            return Pace::AT_REST;
        }
        let left = if self.turns { 0 } else { self.count - 1 };
        Pace { ahead: self.next.wrapping_sub(now) as i32, interval: self.interval, add: self.add, left, word: number }
    }

    /// Takes over how far its steps have been written.
    const fn keep(&mut self, pace: &Pace, now: u32) {
        if self.count == 0 {
            return;
        }
        self.next = now.wrapping_add(pace.ahead as u32);
        if !self.turns {
            (self.interval, self.count) = (pace.interval, pace.left + 1);
        }
    }

    /// Goes on behind the last step of a move, or behind a turn, which was due at `clock`: what that was.
    #[inline(never)]
    fn pass(&mut self, clock: u32, number: u32, pool: &mut Pool) -> StepEvent {
        if self.turns {
            self.turns = false;
            self.next = self.step_behind;
            let forward = if self.direction { 0 } else { StepEvent::FORWARD };
            return StepEvent { at: clock, word: number | StepEvent::TURN | forward };
        }
        self.count = 0;
        self.last = clock;
        if let Some(queued) = pool.pop(&mut self.queue) {
            self.begin(queued);
        }
        StepEvent { at: clock, word: number }
    }

    fn begin(&mut self, queued: Move) {
        let direction = queued.flag != 0;
        self.count = queued.value >> 16;
        let steps = self.count as i32;
        self.end = self.end.wrapping_add(if direction { steps } else { -steps });
        // The addend has sixteen bits and a sign.
        self.add = queued.value as i16 as u32;
        let step = self.last.wrapping_add(queued.time);
        self.interval = queued.time.wrapping_add(self.add);
        self.next = step;
        self.turns = self.direction != direction;
        if self.turns {
            self.direction = direction;
            self.step_behind = step;
            self.next = step.wrapping_sub((queued.time / 2).min(self.pulse_ticks.max(TURN_AHEAD)));
        }
    }

    /// Position behind the steps that are written.
    const fn position(&self) -> i32 {
        let left = self.count as i32;
        self.end.wrapping_sub(if self.direction { left } else { -left })
    }
}

/// All motors, and the step queue, of which this is the only writer.
pub struct Steppers {
    list: heapless::Vec<Stepper, MAX_ACTUATORS>,
    queue: &'static StepQueue,
}

impl Steppers {
    /// No motors yet, and a queue of which this is the only writer.
    pub const fn new(queue: &'static StepQueue) -> Self {
        Self { list: heapless::Vec::new(), queue }
    }

    /// Gives the step queue back, with nothing in it.
    pub fn into_queue(self) -> &'static StepQueue {
        self.queue.cut();
        self.queue.go_on_with(|_| false);
        self.queue
    }

    /// Adds a motor. Returns its number.
    ///
    /// # Errors
    /// The reason why it cannot.
    pub fn add(&mut self, board: &mut impl Board, settings: MotorSettings) -> Result<u8, Reason> {
        let number = self.list.len();
        if number >= MAX_ACTUATORS {
            return Err(Reason::TooManyMotors);
        }
        board.motor(number, settings).ok_or(Reason::NotAPin)?;
        // There is room: see above.
        let _added = self.list.push(Stepper::new(settings.pulse_ticks));
        Ok(number as u8)
    }

    /// Queues steps of a motor, and begins with them if it is at rest.
    ///
    /// # Errors
    /// No steps, no room, or steps that would come too late.
    pub fn queue_steps(
        &mut self,
        motor: u8,
        (interval, count, add): (u32, u32, u32),
        pool: &mut Pool,
        now: u32,
    ) -> Result<(), Reason> {
        let Some(stepper) = self.list.get_mut(usize::from(motor)) else { return Ok(()) };
        let count = count & 0xFFFF;
        if count == 0 {
            return Err(Reason::InvalidCount);
        }
        if stepper.needs_reset {
            return Ok(());
        }
        let flag = u16::from(stepper.direction_to_come);
        let queued = Move { time: interval, value: count << 16 | add & 0xFFFF, flag };
        if stepper.count > 0 {
            return pool.push(&mut stepper.queue, queued).ok_or(Reason::MoveQueueOverflow);
        }
        stepper.begin(queued);
        // The shutdown that follows takes the move back.
        let is_late = (stepper.next.wrapping_sub(now) as i32) < LEAST_LEAD;
        if is_late { Err(Reason::TimerTooClose) } else { Ok(()) }
    }

    /// Sets the direction of the moves to come.
    pub fn set_direction(&mut self, motor: u8, direction: bool) {
        if let Some(stepper) = self.list.get_mut(usize::from(motor)) {
            stepper.direction_to_come = direction;
        }
    }

    /// Sets the time that the next move's interval counts from.
    ///
    /// # Errors
    /// The motor moves.
    pub fn reset_clock(&mut self, motor: u8, clock: u32) -> Result<(), Reason> {
        let Some(stepper) = self.list.get_mut(usize::from(motor)) else { return Ok(()) };
        if stepper.count > 0 {
            return Err(Reason::ResetWhileActive);
        }
        stepper.last = clock;
        stepper.needs_reset = false;
        Ok(())
    }

    /// Returns the steps that a motor has made, those of direction 1 less those of direction 0.
    pub fn position(&self, motor: u8) -> i32 {
        let Some(stepper) = self.list.get(usize::from(motor)) else { return 0 };
        let mut ahead = Ahead::of(stepper);
        ahead.undo_unplayed(self.queue, usize::from(motor));
        ahead.position
    }

    /// Whether the step interrupt has something to play.
    pub fn has_steps_to_play(&self) -> bool {
        !self.queue.is_empty()
    }

    /// Whether no motor has a step to make.
    pub fn are_at_rest(&self) -> bool {
        self.queue.is_empty() && self.list.iter().all(|stepper| stepper.count == 0)
    }

    /// Stops motors at once, one bit each: what they had still to make is dropped, and moves to come are
    /// dropped until [`Self::reset_clock`].
    pub fn stop(&mut self, motors: u8, pool: &mut Pool) {
        if motors == 0 {
            return;
        }
        self.queue.cut();
        for (number, stepper) in self.list.iter_mut().enumerate().filter(|(number, _)| motors & 1 << number != 0) {
            let mut ahead = Ahead::of(stepper);
            ahead.undo_unplayed(self.queue, number);
            stepper.end = ahead.position;
            stepper.direction = ahead.direction;
            stepper.count = 0;
            stepper.needs_reset = true;
            pool.clear(&mut stepper.queue);
        }
        self.queue.go_on_with(|event| motors & 1 << event.motor() == 0);
    }

    /// Stops all motors at once.
    pub fn stop_all(&mut self, pool: &mut Pool) {
        self.stop(((1_u16 << self.list.len()) - 1) as u8, pool);
    }

    /// Writes events up to the horizon. Returns in how many ticks it wants to write again; `None` when every
    /// motor is at rest.
    ///
    /// # Errors
    /// Steps are asked for faster than they can be made: the next one is a millisecond late.
    pub fn write(&mut self, now: u32, pool: &mut Pool) -> Result<Option<u32>, Reason> {
        let Self { list, queue } = self;
        // What is done for every step is done on these.
        let mut paces = [Pace::AT_REST; MAX_ACTUATORS];
        for ((number, stepper), pace) in list.iter().enumerate().zip(&mut paces) {
            *pace = stepper.pace(number as u32, now);
        }
        let paces = paces.get_mut(..list.len()).unwrap_or_default();
        let mut writer = queue.writer(u32::MAX);
        let mut times_left = writer.room() / MAX_ACTUATORS as u32;
        let mut least = paces.iter().map(|pace| pace.ahead).fold(i32::MAX, i32::min);
        if least < -MOST_LATE {
            return Err(Reason::StepperTooLate);
        }
        while least <= HORIZON && times_left > 0 {
            times_left -= 1;
            // Whatever is due at the earliest time is written, and the next time is found, in one pass.
            let clock = now.wrapping_add(least as u32);
            let mut next = i32::MAX;
            for pace in paces.iter_mut() {
                if pace.ahead == least {
                    if pace.left > 0 {
                        writer.push_into_room(StepEvent { at: clock, word: pace.word });
                        pace.left -= 1;
                        pace.ahead = least.wrapping_add(pace.interval as i32);
                        pace.interval = pace.interval.wrapping_add(pace.add);
                    } else if let Some(stepper) = list.get_mut(pace.word as usize) {
                        let number = pace.word;
                        writer.push_into_room(stepper.pass(clock, number, pool));
                        *pace = stepper.pace(number, now);
                    }
                }
                next = next.min(pace.ahead);
            }
            least = next;
        }
        for (stepper, pace) in list.iter_mut().zip(paces) {
            stepper.keep(pace, now);
        }
        Ok(match least {
            i32::MAX => None,
            _ if least <= HORIZON => Some(FULL_WAIT),
            _ => Some((least as u32).wrapping_sub(HORIZON as u32 / 2)),
        })
    }
}

/// A motor behind all that is written, from which events that were not played are taken back, newest first.
struct Ahead {
    position: i32,
    direction: bool,
}

impl Ahead {
    const fn of(stepper: &Stepper) -> Self {
        // A turn that is not written yet has not changed the pin.
        let direction = stepper.direction != (stepper.turns && stepper.count > 0);
        Self { position: stepper.position(), direction }
    }

    /// Takes back the motor's events that wait in the queue.
    fn undo_unplayed(&mut self, queue: &StepQueue, motor: usize) {
        let (played, length) = (queue.played(), queue.len() as u32);
        let waiting = (0..length).rev().map(|index| queue.event(played.wrapping_add(index)));
        for event in waiting.filter(|event| event.motor() == motor) {
            if event.is_turn() {
                self.direction = event.is_forward();
            } else {
                self.position = self.position.wrapping_add(if self.direction { -1 } else { 1 });
            }
        }
    }
}
