//! Commands of digital outputs and hardware PWM.

use super::state::{Controller, Outcome, object};
use crate::args::Args;
use crate::board::{Board, Output};
use crate::objects::Object;
use crate::objects::output::{DigitalOut, Limits};
use crate::objects::pwm::PwmOut;
use crate::reason::Reason;

impl<B: Board> Controller<B> {
    pub(super) fn config_digital_out(&mut self, args: &Args<'_>) -> Outcome {
        self.may_configure(args.oid())?;
        let is_high = args.at(2) != 0;
        let limits = Limits { default_high: args.at(3) != 0, most_ticks: args.at(4) };
        // A heater must not begin away from its default level: nobody has to renew that.
        if limits.most_ticks != 0 && is_high != limits.default_high {
            return Err(Reason::DigitalOutDuration);
        }
        let pin = self.board.output(args.at(1), is_high).ok_or(Reason::NotAPin)?;
        self.configure(args.oid(), Object::DigitalOut(DigitalOut::new(pin, is_high, limits)))
    }

    pub(super) fn set_digital_out_pwm_cycle(&mut self, args: &Args<'_>) -> Outcome {
        object!(self, args.oid(), DigitalOut).set_cycle(args.at(1))
    }

    pub(super) fn queue_digital_out(&mut self, args: &Args<'_>) -> Outcome {
        let now = self.board.clock();
        let output = object!(self, args.oid(), DigitalOut);
        let due = output.queue(args.at(1), args.at(2), &mut self.pool, now)?;
        self.timers.set_or_clear(args.oid(), due);
        Ok(())
    }

    pub(super) fn update_digital_out(&mut self, args: &Args<'_>) -> Outcome {
        let now = self.board.clock();
        let due = object!(self, args.oid(), DigitalOut).update(args.at(1) != 0, now, &self.pool)?;
        self.timers.set_or_clear(args.oid(), due);
        Ok(())
    }

    /// Sets a pin that is no object: for good, as the handle is dropped.
    pub(super) fn set_digital_out(&mut self, args: &Args<'_>) -> Outcome {
        let is_high = args.at(1) != 0;
        self.board.output(args.at(0), is_high).ok_or(Reason::NotAPin)?.set(is_high);
        Ok(())
    }

    pub(super) fn config_pwm_out(&mut self, args: &Args<'_>) -> Outcome {
        self.may_configure(args.oid())?;
        let (value, default_value, most_ticks) = (args.at(3) as u16, args.at(4) as u16, args.at(5));
        if most_ticks != 0 && value != default_value {
            return Err(Reason::PwmDuration);
        }
        let channel = self.board.pwm(args.at(1), args.at(2), value)?;
        self.configure(args.oid(), Object::Pwm(PwmOut::new(channel, value, default_value, most_ticks)))
    }

    pub(super) fn queue_pwm_out(&mut self, args: &Args<'_>) -> Outcome {
        let now = self.board.clock();
        let channel = object!(self, args.oid(), Pwm);
        let due = channel.queue(args.at(1), args.at(2) as u16, &mut self.pool, now)?;
        self.timers.set_or_clear(args.oid(), due);
        Ok(())
    }

    /// Sets a channel that is no object, for good.
    pub(super) fn set_pwm_out(&mut self, args: &Args<'_>) -> Outcome {
        self.board.pwm(args.at(0), args.at(1), args.at(2) as u16).map(drop)
    }
}
