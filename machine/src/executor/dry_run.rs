//! Actions in check mode (`$C`), and those that a fast-forward reads over: nothing moves, heats or waits.
//!
//! Check mode keeps what concerns only the program and its files. A fast-forward also keeps what a job that
//! begins in the middle of its file needs of the lines before: places, limits, and requests to heaters and
//! switches, which are carried out later ([`crate::machine::fast_forward_record`]).

use base::Ports;
use base::failure::{Answer, Outcome};
use base::sessions::Recipient;
use base::tuning::Tuning;
use config::MachineConfig;
use parts::motion_codes;
use procedures::homing;
use program::dry_run::{self, DryRun};
use program::{Action, Effect, Function, Move, Words};
use units::{Axis, AxisSet, Celsius, HeaterId, PerAxis};

use super::program_flow::{self, FlowHands as _};
use crate::features::functions;
use crate::machine::fast_forward_record::Passed;
use crate::machine::{Machine, fast_forward, halt, program_io};

/// Carries out an action in check mode, or reads it over. Never inlined: lines of a print do not come here.
#[cold]
#[inline(never)]
pub(crate) fn carry_out<P: Ports>(machine: &mut Machine<'_, P>, action: &Action<'_>, to: Recipient) -> Outcome {
    dry_run::carry_out(&mut Checked { machine, to }, action)
}

/// A machine that is only to check, or to read over.
struct Checked<'a, 'm, P: Ports> {
    machine: &'a mut Machine<'m, P>,
    to: Recipient,
}

impl<P: Ports> Checked<'_, '_, P> {
    /// Notes something in the record of a fast-forward, if there is one.
    fn note(&mut self, note: impl FnOnce(&mut Passed)) -> Outcome {
        self.machine.passed.as_mut().map(note);
        Ok(Answer::Ok)
    }

    /// Places the program, in a fast-forward.
    fn place(&mut self, place: impl FnOnce(&MachineConfig, &Tuning, &PerAxis<f64>) -> PerAxis<f64>) {
        if self.machine.passed.is_some() {
            let Machine { world, tuning, program, .. } = &mut *self.machine;
            let place = place(world.config, tuning, program.position());
            program.resynchronise(place);
        }
    }
}

impl<P: Ports> DryRun for Checked<'_, '_, P> {
    type Outcome = Outcome;

    fn nothing(&mut self) -> Outcome {
        Ok(Answer::Ok)
    }

    fn moves(&mut self, request: &Move) -> Outcome {
        self.note(|passed| passed.go(request))
    }

    fn changes(&mut self, effect: Effect) -> Outcome {
        fast_forward::follow(self.machine, effect);
        Ok(Answer::Ok)
    }

    fn heats(&mut self, heater: HeaterId, target: Celsius) -> Outcome {
        self.note(|passed| passed.note_target(heater, target))
    }

    fn homes(&mut self, axes: AxisSet) {
        self.place(|config, tuning, here| homing::ends_at(config, tuning, axes, here));
    }

    fn stands_at(&mut self, to: &PerAxis<Option<f64>>, _homed: bool) {
        self.place(|_, _, here| PerAxis(Axis::ALL.map(|axis| to[axis].unwrap_or(here[axis]))));
    }

    fn asks(&mut self) {
        let _noted = self.note(|passed| passed.has_asked = true);
    }

    fn accelerates(&mut self, value: f64) -> Outcome {
        match self.machine.passed {
            Some(_) => motion_codes::acceleration(self.machine.world.texts, &mut self.machine.world.ports, value),
            None => Ok(Answer::Ok),
        }
    }

    fn overrides(&mut self, feed: bool, spindle: bool, hold: bool) -> Outcome {
        if self.machine.passed.is_some() {
            program_io::enable_overrides(self.machine, feed, spindle, hold)?;
        }
        Ok(Answer::Ok)
    }

    fn runs(&mut self, function: Function, words: &Words<'_>) -> Outcome {
        match self.machine.passed {
            // Nobody hears of lines that are read over.
            Some(_) if function.counts_in_fast_forward(words) => {
                functions::run(self.machine, function, *words, Recipient::Nobody)
            }
            None if function.counts_in_check_mode(words) => functions::run(self.machine, function, *words, self.to),
            _ => Ok(Answer::Ok),
        }
    }

    fn calls(&mut self, number: u32, times: u32) -> Outcome {
        program_flow::call(self.machine.flow(), (number, times))
    }

    fn returns(&mut self) -> Outcome {
        program_flow::end_call(self.machine)
    }

    fn ends(&mut self) -> Outcome {
        program_flow::end_program(self.machine)
    }

    fn halts(&mut self) -> Outcome {
        halt::emergency_stop(self.machine);
        Ok(Answer::Ok)
    }

    fn notes(&mut self, text: &'static str) {
        if self.machine.passed.is_none() {
            self.machine.say(self.to, format_args!("{text}\n"));
        }
    }
}
