//! Idle: blocks of the host into the controller, its work on buses, its answers to the host.
//!
//! Each lock is held for one command block, or one copy of bytes. What takes longer, the work on a bus, is
//! done between two locks.

use bsp_prime::time;
use klipper::{Controller, Incoming};
use rtic::Mutex;
use units::Micros;

use crate::board::PrimeBoard;
use crate::lines::Lines;
use crate::update::Updates;
use crate::{fault, usb, wake};

/// Most bytes of answers copied under one lock.
const ANSWER_BYTES: usize = 128;
/// Silence after which nobody speaks to the board: a host asks for the clock every second.
const SILENCE: Micros = Micros::from_seconds(5);
/// Longest wait for the last answers before a reset.
const LAST_ANSWERS: Micros = Micros::from_millis(50);

/// The controller, behind the lock of its tasks.
pub type Shared = &'static mut Controller<PrimeBoard>;

/// State of the idle task.
pub struct Service {
    lines: Lines,
    updates: Updates,
    /// Time of the last block, if it is not long ago.
    spoken: Option<Micros>,
    /// Time since which a reset is wanted.
    leaves: Option<Micros>,
}

impl Service {
    /// Creates the service before the first turn.
    pub const fn new(lines: Lines, updates: Updates) -> Self {
        Self { lines, updates, spoken: None, leaves: None }
    }

    /// Serves the host for ever.
    pub fn run(&mut self, mut controller: impl Mutex<T = Shared>) -> ! {
        if self.updates.look_at_card() {
            fault::reset_as_asked();
        }
        let mut has_work = true;
        loop {
            if !has_work {
                wake::rest();
            }
            wake::note_turn();
            let begun = time::step_ticks();
            has_work = self.turn(&mut controller);
            self.look(&mut controller);
            let ticks = time::step_ticks().wrapping_sub(begun);
            controller.lock(|controller| controller.note_turn(ticks));
        }
    }

    /// Does one piece of each kind of work. Returns whether there was any, and so may be more.
    fn turn(&mut self, controller: &mut impl Mutex<T = Shared>) -> bool {
        let took = self.take_block(controller);
        let worked = work(controller);
        if took || worked {
            wake::run_timers();
        }
        took | worked | self.answer(controller)
    }

    /// Hands a block to the controller, unless it is busy with the one before.
    fn take_block(&mut self, controller: &mut impl Mutex<T = Shared>) -> bool {
        if controller.lock(|controller| controller.is_busy()) {
            return false;
        }
        let Some(incoming) = self.lines.next() else { return false };
        usb::look_for_room();
        match incoming {
            Incoming::Block(block) => {
                self.spoken = Some(time::now());
                controller.lock(|controller| controller.receive(&block));
            }
            Incoming::Damaged => controller.lock(|controller| controller.damaged()),
        }
        true
    }

    /// Sends answers, as many as there is room for.
    fn answer(&mut self, controller: &mut impl Mutex<T = Shared>) -> bool {
        let mut bytes = [0; ANSWER_BYTES];
        let Some(place) = bytes.get_mut(..self.lines.room().min(ANSWER_BYTES)) else { return false };
        let count = controller.lock(|controller| controller.fetch(place));
        let answers = place.get(..count).unwrap_or_default();
        self.lines.write(answers);
        !answers.is_empty()
    }

    /// Does what is due besides: updates, and a reset that was asked for, once the answers are out.
    fn look(&mut self, controller: &mut impl Mutex<T = Shared>) {
        let now = time::now();
        usb::look_for_room();
        self.spoken = self.spoken.filter(|spoken| now.since(*spoken) < SILENCE);
        if self.updates.wants_rest() && controller.lock(|controller| controller.is_at_rest()) {
            self.updates.confirm();
        }
        if self.updates.look(self.spoken.is_none()) {
            fault::reset_as_asked();
        }
        if !controller.lock(|controller| controller.wants_reset()) {
            return;
        }
        self.updates.confirm();
        let since = *self.leaves.get_or_insert(now);
        if self.lines.is_drained() || now.since(since) > LAST_ANSWERS {
            fault::reset_as_asked();
        }
    }
}

/// Does the work on a bus that waits, without the lock.
fn work(controller: &mut impl Mutex<T = Shared>) -> bool {
    let Some(mut job) = controller.lock(|controller| controller.take_job()) else { return false };
    job.run(time::step_ticks);
    controller.lock(|controller| controller.finish(job));
    true
}
