//! `suspend` and `resume`, M600 and M601: pause a job, let a person change filament, go on where it was.

use config::HeaterId;
use gcode::Code;
use motion::Mode;
use units::{Axis, Celsius, PerAxis};

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome, message};
use crate::modal::Modal;
use crate::ports::{MAX_HEATERS, Ports};
use crate::state::State;

/// What is restored by `resume`.
#[derive(Debug)]
pub struct Suspended {
    position: PerAxis<f64>,
    modal: Modal,
    e: f64,
    targets: [Celsius; MAX_HEATERS],
}

impl<P: Ports> Controller<P> {
    /// M600 (`.1` keeps heaters on) and M601; `suspend` and `resume`.
    pub(crate) async fn suspend_code(&mut self, code: Code) -> Outcome {
        if code.number == 600 { self.suspend(code.subcode == 1).await } else { self.resume().await }
    }

    pub(crate) async fn suspend(&mut self, leave_heaters: bool) -> Outcome {
        if self.player.suspended.is_some() {
            self.say(format_args!("Already suspended\n"));
            return Ok(Answer::Ok);
        }
        self.announce(format_args!("// Suspending print, waiting for queue to empty...\n"));
        if !self.player.set_paused(true) {
            self.announce(format_args!("// action:pause\n"));
        }
        self.wait_idle().await?;
        let mut targets = [Celsius(0.0); MAX_HEATERS];
        self.ports.heat(|heat| {
            targets.iter_mut().zip(heat.heaters()).for_each(|(target, (_, heater))| *target = heater.target())
        });
        let e = self.tools.active().map_or(0.0, |tool| tool.e);
        self.player.suspended = Some(Suspended { position: self.position, modal: self.modal.clone(), e, targets });
        if !(leave_heaters || self.config.player.leave_heaters_on_suspend) {
            HeaterId::all().for_each(|id| self.switch_heater_off(id));
        }
        let after = self.config.player.after_suspend_gcode.clone();
        self.run_configured(&after).await?;
        self.announce(format_args!("// Print Suspended, enter resume to continue printing\n"));
        Ok(Answer::Ok)
    }

    pub(crate) async fn resume(&mut self) -> Outcome {
        let Some(suspended) = self.player.suspended.take() else {
            self.say(format_args!("Not suspended\n"));
            return Ok(Answer::Ok);
        };
        for (id, target) in HeaterId::all().zip(suspended.targets).filter(|(_, target)| target.0 > 0.0) {
            self.set_temperature(id, target)?;
        }
        for (id, _) in HeaterId::all().zip(suspended.targets).filter(|(_, target)| target.0 > 0.0) {
            self.wait_for_temperature(id).await?;
        }
        let before = self.config.player.before_resume_gcode.clone();
        self.run_configured(&before).await?;
        let rate = suspended.modal.seek_rate;
        let mut target = self.position;
        Axis::PRIMARY.into_iter().for_each(|axis| target[axis] = suspended.position[axis]);
        self.modal = suspended.modal;
        self.go(target, rate, Mode::Rapid).await?;
        if let Some(tool) = self.tools.active_mut() {
            tool.e = suspended.e;
        }
        if !self.player.set_paused(false) {
            self.announce(format_args!("// action:resume\n"));
        }
        Ok(Answer::Ok)
    }

    /// Runs the commands of a line of G-code from the configuration.
    pub(crate) async fn run_configured(&mut self, line: &str) -> Result<(), Failure> {
        for block in gcode::Blocks::new(line.as_bytes()) {
            let block = block.map_err(|error| Failure::Refused(message(format_args!("{line}: {error}"))))?;
            // A suspension within a suspension has no meaning.
            if matches!(block.code, Some(code) if code.number == 600 || code.number == 601) {
                continue;
            }
            self.run_simple(&block).await?;
        }
        Ok(())
    }

    /// The codes that make sense around a suspension: moves, waits and heat.
    async fn run_simple(&mut self, block: &gcode::Block<'_>) -> Result<(), Failure> {
        use gcode::Letter::{G, M};
        if self.state == State::Halt {
            return Err(Failure::Halted);
        }
        let _by_switch = self.switch_code(block).await?;
        match block.code {
            None => self.motion_words(block).await?,
            Some(code @ Code { letter: G, number: 0..=3, .. }) => self.motion_code(code, block).await?,
            Some(Code { letter: G, number: 4, .. }) => self.dwell_code(block).await?,
            Some(Code { letter: G, number: 10, .. }) => self.retract().await?,
            Some(Code { letter: G, number: 11, .. }) => self.recover().await?,
            Some(code @ Code { letter: G, .. }) => self.modal_code(code, block).await?,
            Some(Code { letter: M, number: number @ (82 | 83), .. }) => {
                self.modal.e_absolute = number == 82;
                Answer::Ok
            }
            Some(Code { letter: M, number, .. }) => self.heat_code(number, block).await?.unwrap_or(Answer::Unknown),
            Some(_) => Answer::Unknown,
        };
        Ok(())
    }
}
