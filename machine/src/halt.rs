//! Halting and coming back.
//!
//! A halt is one act: heat off, switches to their halt states, motion brought to rest along its path, the job dropped,
//! one message. When the motors stand still (or after [`STOP_TIMEOUT`], without waiting further) they lose their current.
//! No halt is left by itself: M999, `$X`, Ctrl-Y or the kill button release it.

use units::{Axis, Micros};

use crate::console::Target;
use crate::controller::Controller;
use crate::ports::Ports;
use crate::splines::Splines;
use crate::state::{Event, State};

/// Motion must have come to rest by then, else it is cut.
const STOP_TIMEOUT: Micros = Micros::from_seconds(1);
/// How long the kill button is held to clear a halt.
const UNKILL_HOLD: Micros = Micros::from_seconds(2);

/// What a halt still has to finish, and the kill button's memory.
#[derive(Clone, Copy, Debug, Default)]
pub struct HaltWatch {
    /// Motion is being brought to rest since then.
    stopping_since: Option<Micros>,
    /// Release as soon as everything stands still.
    release_wanted: bool,
    /// The kill button has been down since then.
    kill_down_since: Option<Micros>,
    /// The button already did what this press means.
    kill_used: bool,
}

impl<P: Ports> Controller<P> {
    /// Halts, saying why on every console. While halted already: nothing.
    pub(crate) fn halt(&mut self, why: core::fmt::Arguments<'_>) {
        if self.state == State::Halt {
            return;
        }
        self.ports.heat(crate::heat::HeatControl::halt);
        self.ports.supervisor(|supervisor| supervisor.expect_fet_supply(false));
        self.ports.motion(motion::Motion::stop);
        self.apply(Event::Halt);
        self.switches_to_halt_state();
        self.halt_watch.stopping_since = Some(self.ports.now());
        self.halt_watch.release_wanted = false;
        self.modal.power = 0.0;
        self.modal.machine_next = false;
        self.announce(why);
        self.drop_job();
    }

    /// Ends a halt, as soon as the motors stand still.
    pub(crate) fn release(&mut self) {
        self.halt_watch.release_wanted = true;
        let now = self.ports.now();
        self.watch_halt(now);
        self.finish_release();
    }

    /// `$X` and Ctrl-Y on a halted machine. One whose configuration cannot be used stays locked.
    pub(crate) fn unlock(&mut self, target: Target) {
        if self.crippled {
            self.consoles
                .write(target, format_args!("error:the configuration has errors: mend config.ini and reset\n"));
            return;
        }
        self.release();
        self.consoles.write(target, format_args!("[Caution: Unlocked]\n"));
    }

    /// Waits for a release that was asked for while motion still came to rest.
    pub(crate) async fn wait_release(&mut self) {
        // Ends: motion rests within STOP_TIMEOUT or is cut.
        while self.halt_watch.release_wanted && !self.crippled {
            self.serve();
            crate::wait::yield_once().await;
        }
    }

    fn finish_release(&mut self) {
        if self.halt_watch.stopping_since.is_some() || !self.halt_watch.release_wanted || self.crippled {
            return;
        }
        self.halt_watch.release_wanted = false;
        self.ports.heat(crate::heat::HeatControl::release);
        self.ports.supervisor(|supervisor| supervisor.expect_fet_supply(true));
        self.ports.set_motor_power(true);
        self.apply(Event::Release);
    }

    /// Brings a halt to its end: motors without current once they stand still.
    pub(crate) fn watch_halt(&mut self, now: Micros) {
        let Some(since) = self.halt_watch.stopping_since else { return };
        let idle = self.ports.motion(|motion| motion.is_idle());
        if !idle {
            if now.since(since) > STOP_TIMEOUT {
                // Repeating an abort is harmless; the feed answers within its period, if it lives.
                self.ports.motion(motion::Motion::abort);
                self.homed = 0;
            }
            if now.since(since) <= STOP_TIMEOUT.plus(STOP_TIMEOUT) {
                return;
            }
        }
        self.halt_watch.stopping_since = None;
        self.motors_off();
        self.ports.set_motor_power(false);
        self.resync();
        self.finish_release();
    }

    /// Takes the position over from the planner, after a stop that ended somewhere else than commanded.
    pub(crate) fn resync(&mut self) {
        self.position = self.ports.motion(|motion| motion.commanded_position());
    }

    /// A file being played and a suspended job end with a halt.
    fn drop_job(&mut self) {
        self.stop_player();
        if self.player.cancel_suspend() {
            self.announce(format_args!("// NOTE Suspend cleared due to HALT\n"));
        }
        self.spoil_upload();
    }

    /// The kill button, at each poll.
    pub(crate) fn kill_button(&mut self, pressed: bool, now: Micros) {
        let config = self.config.kill_button;
        let watch = &mut self.halt_watch;
        if !pressed {
            let was_down = watch.kill_down_since.take().is_some();
            watch.kill_used = false;
            if was_down && config.toggle && config.unkill && self.state == State::Halt {
                self.unkill();
            }
            return;
        }
        let since = *watch.kill_down_since.get_or_insert(now);
        match self.state {
            State::Halt if config.toggle || !config.unkill || watch.kill_used => {}
            State::Halt => {
                if now.since(since) >= UNKILL_HOLD {
                    self.halt_watch.kill_used = true;
                    self.unkill();
                }
            }
            _ if watch.kill_used && !config.toggle => {}
            _ if watch.kill_used => {
                self.halt(format_args!("WARNING: ESTOP is still latched, unlatch ESTOP to clear HALT\n"))
            }
            _ => {
                // This press has halted; only a new one, or one held on a halted machine, may clear.
                self.halt_watch.kill_used = true;
                self.halt(format_args!("ALARM: Kill button pressed - reset, $X or M999 to clear HALT\n"));
            }
        }
    }

    fn unkill(&mut self) {
        self.release();
        self.announce(format_args!("UnKill button pressed Halt cleared\n"));
    }

    /// M999.
    pub(crate) async fn clear_halt(&mut self) {
        self.splines = Splines::default();
        self.release();
        self.wait_release().await;
        self.say(format_args!("WARNING: After HALT you should HOME as position is currently unknown\n"));
    }

    /// Whether every axis that can be homed has been.
    pub(crate) fn all_homed(&self) -> bool {
        Axis::ALL
            .into_iter()
            .filter(|axis| self.config.homing_endstop(*axis).is_some())
            .all(|axis| self.homed & (1 << axis as u8) != 0)
    }

    /// The answer to commands while halted.
    pub(crate) fn say_locked(&mut self) {
        let text = if self.config.general.grbl_mode { "error:Alarm lock\n" } else { "!!\n" };
        self.say(format_args!("{text}"));
    }

    /// Halts because a command asked for what must not be.
    pub(crate) fn alarm(&mut self, text: &str) {
        let word = if self.config.general.grbl_mode { "error" } else { "Error" };
        let target = self.target;
        self.consoles.write(target, format_args!("{word}: {text}\n"));
        // Others must learn why the machine stands.
        if target == Target::Nobody {
            self.announce(format_args!("{word}: {text}\n"));
        }
        self.halt(format_args!("Entering Alarm/Halt state\n"));
    }
}
