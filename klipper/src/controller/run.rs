//! Timers of all objects, and steps ahead of time.

use super::state::{Controller, Outcome, STATISTICS_TICKS, Turns};
use crate::board::Board;
use crate::numbers::CLOCK_HZ;
use crate::objects::Object;
use crate::reason::Reason;
use crate::table::Response;
use crate::timers::{MAX_OBJECTS, SILENCE, STATISTICS};

/// Time between two looks whether the host speaks: 50 ms.
const SILENCE_LOOK_TICKS: u32 = CLOCK_HZ / 20;
/// Heaters are off when nothing has come for so long: 950 ms, so that they are within a second. A host asks
/// for the clock every 984 ms, and a heater that it heats has changes in between.
const SILENCE_TICKS: u32 = CLOCK_HZ / 20 * 19;
/// A timer that is later than this is a firmware that cannot keep up: 1 ms.
const MOST_LATE_TICKS: i32 = CLOCK_HZ as i32 / 1000;
/// Commands have no time left for so long: steps take it all. 0.3 s, before the watchdog resets the board.
const MOST_WITHOUT_TURN: u32 = CLOCK_HZ / 10 * 3;
/// Timers of one call of [`Controller::run`] at most: then whoever waits for the lock has a turn.
const MOST_TIMERS: usize = 32;

impl<B: Board> Controller<B> {
    /// Does what is due, writes steps ahead, and returns the ticks until it wants to be called again.
    pub fn run(&mut self) -> u32 {
        for _ in 0..MOST_TIMERS {
            let now = self.board.clock();
            let Some((object, ahead)) = self.timers.first(now) else { break };
            if ahead > 0 {
                break;
            }
            // The controller's own timers may be late: they are set before the board has come up.
            if ahead < -MOST_LATE_TICKS && usize::from(object) < MAX_OBJECTS {
                self.shut_down(Reason::RescheduledInPast);
            }
            let due = now.wrapping_add(ahead as u32);
            self.timers.clear(object);
            if let Err(reason) = self.on_timer(object, due, now) {
                self.shut_down(reason);
            }
        }
        let now = self.board.clock();
        if now.wrapping_sub(self.turned_at) > MOST_WITHOUT_TURN && !self.steppers.are_at_rest() {
            self.shut_down(Reason::StepperTooLate);
        }
        let steps = self.steppers.write(now, &mut self.pool).unwrap_or_else(|reason| {
            self.shut_down(reason);
            None
        });
        // Also behind the last step of all, when nothing more is to be written.
        if self.steppers.has_steps_to_play() {
            self.board.wake_steps();
        }
        let timer = self.timers.first(now).map_or(u32::MAX, |(_, ahead)| ahead.max(0) as u32);
        timer.min(steps.unwrap_or(u32::MAX)).min(CLOCK_HZ / 10)
    }

    fn on_timer(&mut self, object: u8, due: u32, now: u32) -> Outcome {
        match object {
            STATISTICS => {
                let Turns { count, sum, sum_of_squares } = core::mem::take(&mut self.turns);
                self.out.send(Response::Stats, &[count, sum, sum_of_squares]);
                self.timers.set(STATISTICS, due.wrapping_add(STATISTICS_TICKS));
                Ok(())
            }
            SILENCE => {
                if !self.is_silent && now.wrapping_sub(self.heard_at) >= SILENCE_TICKS {
                    self.is_silent = true;
                    self.hold_heaters(true);
                }
                self.timers.set(SILENCE, due.wrapping_add(SILENCE_LOOK_TICKS));
                Ok(())
            }
            _ => self.on_object_timer(object, due, now),
        }
    }

    fn on_object_timer(&mut self, oid: u8, due: u32, now: u32) -> Outcome {
        let Some(object) = self.objects.get_mut(usize::from(oid)) else { return Ok(()) };
        let next = match object {
            Object::DigitalOut(output) => output.on_timer(now, &mut self.pool)?,
            Object::Pwm(channel) => channel.on_timer(now, &mut self.pool, &mut self.board)?,
            Object::Analog(_) => return self.take_conversion(oid, due),
            Object::Endstop(_) => return self.read_endstop(oid, due, now),
            Object::Trigger(_) => return self.look_at_trigger(oid, now),
            Object::Buttons(_) => return self.look_at_buttons(oid, due),
            Object::Counter(_) => return self.look_at_counter(oid, due),
            Object::Accelerometer(_) => return self.look_at_accelerometer(oid),
            Object::TmcUart(_) => return self.look_at_tmcuart(oid, due),
            Object::None
            | Object::Stepper(_)
            | Object::Spi(_)
            | Object::SpiShutdown(_)
            | Object::I2c(_)
            | Object::Lights(_) => None,
        };
        self.timers.set_or_clear(oid, next);
        Ok(())
    }
}
