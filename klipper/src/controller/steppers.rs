//! Commands that configure and move motors.

use super::state::{Controller, Outcome, object};
use crate::args::Args;
use crate::board::{Board, MotorSettings, StepEdge};
use crate::objects::Object;
use crate::table::Response;

impl<B: Board> Controller<B> {
    pub(super) fn config_stepper(&mut self, args: &Args<'_>) -> Outcome {
        self.may_configure(args.oid())?;
        let edge = match args.at(3) as i8 {
            0 => StepEdge::Rising,
            1.. => StepEdge::Falling,
            _ => StepEdge::Both,
        };
        let settings = MotorSettings { step_pin: args.at(1), dir_pin: args.at(2), edge, pulse_ticks: args.at(4) };
        let motor = self.steppers.add(&mut self.board, settings)?;
        self.configure(args.oid(), Object::Stepper(motor))
    }

    pub(super) fn queue_step(&mut self, args: &Args<'_>) -> Outcome {
        let motor = *object!(self, args.oid(), Stepper);
        let now = self.board.clock();
        self.steppers.queue_steps(motor, (args.at(1), args.at(2), args.at(3)), &mut self.pool, now)
    }

    pub(super) fn set_next_step_dir(&mut self, args: &Args<'_>) -> Outcome {
        let motor = *object!(self, args.oid(), Stepper);
        self.steppers.set_direction(motor, args.at(1) != 0);
        Ok(())
    }

    pub(super) fn reset_step_clock(&mut self, args: &Args<'_>) -> Outcome {
        let motor = *object!(self, args.oid(), Stepper);
        self.steppers.reset_clock(motor, args.at(1))
    }

    pub(super) fn stepper_get_position(&mut self, args: &Args<'_>) -> Outcome {
        let motor = *object!(self, args.oid(), Stepper);
        let position = self.steppers.position(motor);
        self.out.send(Response::StepperPosition, &[args.at(0), position as u32]);
        Ok(())
    }

    pub(super) fn stepper_stop_on_trigger(&mut self, args: &Args<'_>) -> Outcome {
        let motor = *object!(self, args.oid(), Stepper);
        let trigger = object!(self, args.at(1) as u8, Trigger);
        trigger.motors |= 1 << motor;
        Ok(())
    }
}
