//! Commands of end stops, triggers, buttons and counters.

use super::state::{Controller, Outcome, object};
use crate::args::Args;
use crate::board::{Board, Pull};
use crate::objects::Object;
use crate::objects::buttons::Buttons;
use crate::objects::counter::Counter;
use crate::objects::endstop::{Due, Endstop, Search, Seen, Trigger};
use crate::reason::Reason;
use crate::table::Response;

/// Resistor of a pin as hosts have it: 1 up, 0 none, -1 down, in eight bits.
const fn pull(value: u32) -> Pull {
    match value as i8 {
        0 => Pull::None,
        1.. => Pull::Up,
        _ => Pull::Down,
    }
}

impl<B: Board> Controller<B> {
    pub(super) fn config_endstop(&mut self, args: &Args<'_>) -> Outcome {
        self.may_configure(args.oid())?;
        let pin = self.board.input(args.at(1), pull(args.at(2))).ok_or(Reason::NotAPin)?;
        self.configure(args.oid(), Object::Endstop(Endstop::new(pin)))
    }

    pub(super) fn endstop_home(&mut self, args: &Args<'_>) -> Outcome {
        let search = Search {
            sample_ticks: args.at(2),
            sample_count: args.at(3) as u8,
            rest_ticks: args.at(4),
            level: args.at(5) != 0,
            trigger: args.at(6) as u8,
            reason: args.at(7) as u8,
        };
        if search.sample_count != 0 {
            let _is_one = object!(self, search.trigger, Trigger);
        }
        let due = object!(self, args.oid(), Endstop).begin(search, args.at(1));
        self.timers.set_or_clear(args.oid(), due);
        Ok(())
    }

    pub(super) fn endstop_query_state(&mut self, args: &Args<'_>) -> Outcome {
        let [homing, next, level] = object!(self, args.oid(), Endstop).state();
        self.out.send(Response::EndstopState, &[args.at(0), homing, next, level]);
        Ok(())
    }

    pub(super) fn read_endstop(&mut self, oid: u8, due: u32, now: u32) -> Outcome {
        match object!(self, oid, Endstop).read(due) {
            Seen::Later(next) => self.timers.set(oid, next),
            Seen::Found(trigger, reason) => self.fire(trigger, reason, now)?,
        }
        Ok(())
    }

    pub(super) fn config_trsync(&mut self, args: &Args<'_>) -> Outcome {
        self.configure(args.oid(), Object::Trigger(Trigger::default()))
    }

    pub(super) fn trsync_start(&mut self, args: &Args<'_>) -> Outcome {
        let trigger = object!(self, args.oid(), Trigger);
        trigger.start(args.at(1), args.at(2), args.at(3) as u8);
        self.timers.set_or_clear(args.oid(), trigger.due());
        Ok(())
    }

    pub(super) fn trsync_set_timeout(&mut self, args: &Args<'_>) -> Outcome {
        let trigger = object!(self, args.oid(), Trigger);
        trigger.set_timeout(args.at(1));
        self.timers.set_or_clear(args.oid(), trigger.due());
        Ok(())
    }

    /// The host fires a trigger, and wants its state in any case.
    pub(super) fn trsync_trigger(&mut self, args: &Args<'_>) -> Outcome {
        let trigger = object!(self, args.oid(), Trigger);
        let motors = trigger.fire(args.at(1) as u8);
        trigger.rest();
        let [can_trigger, reason] = trigger.state();
        self.timers.clear(args.oid());
        self.steppers.stop(motors.unwrap_or(0), &mut self.pool);
        self.out.send(Response::TrsyncState, &[args.at(0), can_trigger, reason, 0]);
        Ok(())
    }

    /// Stops the motors of a trigger, and tells the host.
    fn fire(&mut self, oid: u8, reason: u8, now: u32) -> Outcome {
        let trigger = object!(self, oid, Trigger);
        let Some(motors) = trigger.fire(reason) else { return Ok(()) };
        let [can_trigger, reason] = trigger.state();
        trigger.rest();
        self.timers.clear(oid);
        self.steppers.stop(motors, &mut self.pool);
        self.out.send(Response::TrsyncState, &[u32::from(oid), can_trigger, reason, now]);
        Ok(())
    }

    pub(super) fn look_at_trigger(&mut self, oid: u8, now: u32) -> Outcome {
        let trigger = object!(self, oid, Trigger);
        match trigger.on_timer(now) {
            Due::Expired(reason) => return self.fire(oid, reason, now),
            Due::Report => {
                let [can_trigger, reason] = trigger.state();
                self.out.send(Response::TrsyncState, &[u32::from(oid), can_trigger, reason, now]);
            }
            Due::Nothing => {}
        }
        self.timers.set_or_clear(oid, object!(self, oid, Trigger).due());
        Ok(())
    }

    pub(super) fn config_buttons(&mut self, args: &Args<'_>) -> Outcome {
        self.configure(args.oid(), Object::Buttons(Buttons::new(args.at(1))?))
    }

    pub(super) fn buttons_add(&mut self, args: &Args<'_>) -> Outcome {
        let pin = self.board.input(args.at(2), pull(args.at(3))).ok_or(Reason::NotAPin)?;
        object!(self, args.oid(), Buttons).add(args.at(1), pin)
    }

    pub(super) fn buttons_query(&mut self, args: &Args<'_>) -> Outcome {
        let buttons = object!(self, args.oid(), Buttons);
        let due = buttons.ask(args.at(1), args.at(2), args.at(3) as u8, args.at(4) as u8)?;
        self.timers.set_or_clear(args.oid(), due);
        Ok(())
    }

    pub(super) fn buttons_ack(&mut self, args: &Args<'_>) -> Outcome {
        object!(self, args.oid(), Buttons).acknowledge(args.at(1));
        Ok(())
    }

    pub(super) fn look_at_buttons(&mut self, oid: u8, due: u32) -> Outcome {
        let buttons = object!(self, oid, Buttons);
        let (next, tells) = buttons.look(due);
        self.timers.set(oid, next);
        if tells {
            let (acknowledged, changes) = buttons.state();
            self.out.send_bytes(Response::ButtonsState, &[u32::from(oid), acknowledged], Some(changes));
        }
        Ok(())
    }

    pub(super) fn config_counter(&mut self, args: &Args<'_>) -> Outcome {
        self.may_configure(args.oid())?;
        let pin = self.board.input(args.at(1), pull(args.at(2))).ok_or(Reason::NotAPin)?;
        self.configure(args.oid(), Object::Counter(Counter::new(pin)))
    }

    pub(super) fn query_counter(&mut self, args: &Args<'_>) -> Outcome {
        let due = object!(self, args.oid(), Counter).ask(args.at(1), args.at(2), args.at(3));
        self.timers.set_or_clear(args.oid(), due);
        Ok(())
    }

    pub(super) fn look_at_counter(&mut self, oid: u8, due: u32) -> Outcome {
        let (next, report) = object!(self, oid, Counter).look(due);
        self.timers.set(oid, next);
        if let Some([next_report, count, counted_at]) = report {
            self.out.send(Response::CounterState, &[u32::from(oid), next_report, count, counted_at]);
        }
        Ok(())
    }
}
