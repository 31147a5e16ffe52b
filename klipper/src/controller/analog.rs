//! Commands of analog inputs.

use super::state::{Controller, Outcome, object};
use crate::args::Args;
use crate::board::Board;
use crate::objects::Object;
use crate::objects::analog::{AnalogIn, Query};
use crate::reason::Reason;
use crate::table::Response;

impl<B: Board> Controller<B> {
    pub(super) fn config_analog_in(&mut self, args: &Args<'_>) -> Outcome {
        self.may_configure(args.oid())?;
        let input = self.board.analog(args.at(1)).ok_or(Reason::NotAnAnalogPin)?;
        self.configure(args.oid(), Object::Analog(AnalogIn::new(input)))
    }

    pub(super) fn query_analog_in(&mut self, args: &Args<'_>) -> Outcome {
        let query = Query {
            sample_ticks: args.at(2),
            sample_count: args.at(3) as u8,
            rest_ticks: args.at(4),
            report_bytes: args.at(5) as u8,
            least: args.at(6) as u16,
            most: args.at(7) as u16,
            range_checks: args.at(8) as u8,
        };
        let due = object!(self, args.oid(), Analog).ask(query, args.at(1))?;
        self.timers.set_or_clear(args.oid(), due);
        Ok(())
    }

    pub(super) fn take_conversion(&mut self, oid: u8, due: u32) -> Outcome {
        let input = object!(self, oid, Analog);
        let conversion = self.board.read_analog(input.input);
        match input.take(conversion, due) {
            Ok(taken) => {
                self.timers.set(oid, taken.due);
                if let Some((next, sums)) = taken.report {
                    self.out.send_bytes(Response::AnalogInState, &[u32::from(oid), next], Some(&sums));
                }
                Ok(())
            }
            // Readings go on, also after a shutdown: of its reasons the first one counts.
            Err(reason) => {
                let due = object!(self, oid, Analog).skip(due);
                self.timers.set(oid, due);
                Err(reason)
            }
        }
    }
}
