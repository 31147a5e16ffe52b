//! Halting and coming back.
//!
//! A halt is one act: heat off, switches to their halt states, motion brought to rest along its path, the job
//! dropped, one message. Motors lose their current when they stand still (or after a second, without waiting
//! further). No halt is left by itself: M999, `$X`, Ctrl-Y or the kill button release it.

use core::fmt::Arguments;

use base::Ports;
use base::failure::Failure;
use base::ports::Wake;
use base::reason::{Alarm, Reason};
use base::safety::{Event, Press, Stopping};
use base::sessions::Recipient;
use events::{Event as Happened, Text};
use program::{Dialect, State};
use thermal::HeatControl;
use units::Micros;

use crate::machine::moments::{Features, Moments as _};
use crate::machine::program_io::OverrideHands as _;
use crate::machine::work_hands::HaltHands;
use crate::machine::{Machine, program_io, program_logs};

impl<P: Ports> Machine<'_, P> {
    /// Halts, saying why to every session, and by number to those of GRBL's dialect. Does nothing while
    /// halted.
    pub(crate) fn halt(&mut self, alarm: Alarm, why: Arguments<'_>) {
        if self.safety.rests_held() {
            self.release_motors();
        }
        self.safety.hold_motors(false);
        self.halt_at_once(alarm, why);
    }

    fn release_motors(&mut self) {
        self.axes.disable_all(&mut self.world.ports, self.world.config);
        self.world.ports.set_motor_power(false);
    }

    /// Halts, but lets standing motors keep their current: an axis that would fall without it stays.
    pub(crate) fn halt_holding(&mut self, alarm: Alarm, why: Arguments<'_>) {
        self.safety.hold_motors(true);
        self.halt_at_once(alarm, why);
    }

    fn halt_at_once(&mut self, alarm: Alarm, why: Arguments<'_>) {
        let now = self.world.ports.now();
        if self.safety.halt(now) {
            self.record(&Happened::Halted(Text::new(why)));
            self.stop_everything();
            self.announce(why);
            Features::<P>::halts(self);
            self.world.sessions.alarm(alarm);
            self.drop_job();
        }
    }

    /// Switches everything off until a reset.
    pub(crate) fn sleep(&mut self) -> Result<(), Failure> {
        let now = self.world.ports.now();
        if !self.safety.sleep(now) {
            return Err(Failure::refused(&"the machine sleeps from standstill only: wait, or stop it"));
        }
        self.stop_everything();
        self.drop_job();
        Ok(())
    }

    /// Drops a held job (Ctrl-X in a complete hold): the motors stand and keep their current and place, so
    /// the rest is dropped without an alarm. The machine is halted for a moment, to end all waits.
    pub(crate) fn drop_held(&mut self) {
        let now = self.world.ports.now();
        if self.safety.begin_reset(now) {
            self.stop_everything();
            self.drop_job();
        }
    }

    /// Ends the reset of a held job.
    pub(crate) fn watch_reset(&mut self, now: Micros) {
        if !self.safety.is_resetting() || !self.frames.is_empty() {
            return;
        }
        if self.world.ports.motion(|motion| motion.is_idle()) && self.safety.finish_reset(now) {
            self.world.ports.heat(HeatControl::release);
            self.world.ports.supervisor(|supervisor| supervisor.expect_fet_supply(true));
            Features::<P>::rests(self);
            self.resynchronise();
        }
    }

    fn stop_everything(&mut self) {
        self.world.ports.heat(HeatControl::halt);
        Features::<P>::drop_effects(self);
        self.world.ports.supervisor(|supervisor| supervisor.expect_fet_supply(false));
        self.world.ports.motion(motion::Motion::stop);
        for output in self.outputs.halt(self.world.config) {
            // A switch takes any value.
            let _ = self.world.ports.heat(|heat| heat.apply(output));
        }
        self.world.ports.run_heat_now();
        Features::<P>::stops(self);
        self.program.halt();
    }

    /// Switches heaters and outputs off, on a machine that stands and is not halted.
    pub(crate) fn stop_outputs(&mut self) {
        if self.safety.is_halted() {
            return;
        }
        self.world.ports.heat(HeatControl::halt);
        Features::<P>::drop_effects(self);
        for output in self.outputs.halt(self.world.config) {
            // A switch takes any value.
            let _ = self.world.ports.heat(|heat| heat.apply(output));
        }
        self.world.ports.heat(HeatControl::release);
    }

    /// Ends a file being played and a suspended job at a halt.
    fn drop_job(&mut self) {
        Features::<P>::job_is_dropped(self);
        program_logs::close(&mut self.logs, &mut self.world);
        program_io::overrides_count_again(self.overrides());
        if self.jobs.is_open() {
            self.record(&Happened::JobEnded { complete: false, line: self.jobs.line() });
        }
        self.jobs.close(&mut self.world.ports);
        if self.jobs.cancel_suspend() {
            self.announce(format_args!("// NOTE Suspend cleared due to HALT\n"));
        }
        self.files.spoil_upload(&mut self.world.ports);
    }

    /// Ends an alarm, as soon as the motors stand still.
    pub(crate) fn release(&mut self) {
        self.safety.want_release();
        let now = self.world.ports.now();
        self.watch_halt(now);
        self.finish_release();
    }

    /// Releases a halted machine (`$X` and Ctrl-Y), unless its configuration cannot be used or the machine
    /// sleeps.
    pub(crate) fn unlock(&mut self, to: Recipient) {
        let locked = match self.safety.state() {
            State::Invalid => "the configuration has errors: mend config.ini and reset",
            State::Sleep => "the machine sleeps: Ctrl-X wakes it",
            _ => {
                self.release();
                let is_grbl = self.world.sessions.dialect_of(to) == Dialect::Grbl;
                return self.say(to, format_args!("[{}Caution: Unlocked]\n", if is_grbl { "MSG:" } else { "" }));
            }
        };
        self.world.sessions.refuse(to, Reason::Locked, format_args!("{locked}"));
    }

    /// Waits for a release that was asked for while motion still came to rest.
    pub(crate) fn wait_release(&mut self) {
        // The loop ends: motion rests within a second, or is cut.
        while self.safety.release_is_pending() {
            self.wait(Wake::Any).whatever_happens();
        }
    }

    fn finish_release(&mut self) {
        if !self.safety.finish_release() {
            return;
        }
        self.record(&Happened::Released);
        self.world.ports.heat(HeatControl::release);
        self.world.ports.supervisor(|supervisor| supervisor.expect_fet_supply(true));
        self.world.ports.set_motor_power(true);
    }

    /// Brings a halt to its end: motors without current once they stand still.
    pub(crate) fn watch_halt(&mut self, now: Micros) {
        let idle = self.world.ports.motion(|motion| motion.is_idle());
        match self.safety.watch_stop(now, idle) {
            Stopping::Wait => return,
            Stopping::Cut => {
                self.world.ports.motion(motion::Motion::abort);
                self.axes.forget_all_homed();
                Features::<P>::rests(self);
                return;
            }
            Stopping::Over => {}
        }
        Features::<P>::rests(self);
        if !self.safety.holds_motors() {
            self.release_motors();
        }
        self.resynchronise();
        self.finish_release();
    }

    /// Looks at the kill button.
    pub(crate) fn watch_kill_button(&mut self, now: Micros) {
        let settings = self.world.config.kill_button;
        if !settings.enable || settings.pin.is_none() {
            return;
        }
        let pressed = self.world.ports.inputs().is_active(base::ports::Input::Kill);
        let is_halted = self.safety.is_halted();
        match self.safety.kill_button.look(&settings, pressed, is_halted, now) {
            Press::Nothing => {}
            Press::Kill => {
                self.halt(Alarm::Abort, format_args!("ALARM: Kill button pressed - reset, $X or M999 to clear HALT\n"));
            }
            Press::StillLatched => {
                self.halt(Alarm::Abort, format_args!("WARNING: ESTOP is still latched, unlatch ESTOP to clear HALT\n"));
            }
            Press::Clear => {
                self.release();
                self.announce(format_args!("UnKill button pressed Halt cleared\n"));
            }
        }
    }

    /// Halts, or wakes a machine that sleeps, into an alarm (Ctrl-X).
    pub(crate) fn abort(&mut self) {
        if self.safety.state() == State::Sleep {
            self.safety.apply(Event::Wake);
            return self.announce(format_args!("ALARM: awake, $X or M999 to clear HALT\n"));
        }
        let alarm = if self.safety.mode().is_in(State::Homing) { Alarm::HomingReset } else { Alarm::Abort };
        self.halt(alarm, format_args!("ALARM: Abort during cycle\n"));
    }
}

/// The machine for coming back from a halt.
pub(crate) trait ReleaseHands<'c>: HaltHands<'c> {
    /// Ends an alarm, as soon as the motors stand still, and waits for that.
    fn release(&mut self);
}

impl<'c, P: Ports> ReleaseHands<'c> for Machine<'c, P> {
    fn release(&mut self) {
        self.release();
        self.wait_release();
    }
}

/// Halts at M112.
pub(crate) fn emergency_stop<'c>(hands: &mut impl HaltHands<'c>) {
    hands.halt(Alarm::Abort, format_args!("ALARM: Emergency stop (M112)\n"));
}

/// Releases a halt, and waits until that is done (M999).
pub(crate) fn clear_halt<'c>(hands: &mut impl ReleaseHands<'c>, to: Recipient) {
    if hands.state() != State::Alarm {
        return;
    }
    hands.release();
    hands.say(to, format_args!("WARNING: After HALT you should HOME as position is currently unknown\n"));
}
