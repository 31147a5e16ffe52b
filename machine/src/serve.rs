//! What happens at every waiting point, however deep in a sequence: consoles are heard, faults seen, outputs flushed.

use units::{Axis, Micros};

use crate::console::Target;
use crate::controller::Controller;
use crate::failure::message;
use crate::heat::{HeatCause, HeatFault};
use crate::ports::{ConsoleId, Input, Ports, Realtime};
use crate::state::{Event, State};
use crate::supervisor::SupervisorEvent;

/// How often inputs and faults are looked at.
const POLL_PERIOD: Micros = Micros::from_millis(10);
/// Half period of the life LED.
const LED_PERIOD: Micros = Micros::from_millis(100);
/// A status report is only written when the console has this much less than a full buffer waiting.
const STATUS_BACKLOG: usize = 1_024;

impl<P: Ports> Controller<P> {
    /// Serves everything once. Never waits.
    pub(crate) fn serve(&mut self) {
        let now = self.ports.now();
        self.ports.report_alive();
        self.ports.heat(|heat| heat.dispatcher_alive(now));
        for console in 0..self.consoles.count() {
            self.serve_requests(console);
            self.serve_bytes(console);
        }
        if now >= self.poll_due {
            self.poll_due = now.plus(POLL_PERIOD);
            self.watch_heat();
            self.watch_supervisor();
            self.watch_limits();
            self.watch_step_times(now);
            self.watch_kill_button(now);
            self.watch_halt(now);
            self.watch_input_switches(now);
            self.follow_motion();
            self.watch_standstill(now);
            self.blink(now);
        }
        self.consoles.flush(&mut self.ports);
    }

    fn serve_requests(&mut self, console: u8) {
        while self.consoles.backlog(Target::Console(console)) < STATUS_BACKLOG {
            let Some(request) = self.ports.inbox(ConsoleId(console)).take_request() else { return };
            match request {
                Realtime::Status => self.report_status(Target::Console(console)),
                Realtime::Abort => {
                    self.consoles.clear_line(console);
                    self.halt(format_args!("ALARM: Abort during cycle\n"));
                }
                Realtime::Stop if self.state == State::Halt => self.unlock(Target::Console(console)),
                Realtime::Stop => {
                    if let Some(console) = self.consoles.get_mut(console) {
                        console.stop_requested = true;
                    }
                }
                Realtime::Hold => self.feed_hold(),
                Realtime::Resume => self.feed_resume(),
            }
        }
    }

    fn serve_bytes(&mut self, console: u8) {
        if self.consoles.gather(console, self.ports.inbox(ConsoleId(console))) {
            self.consoles.write(Target::Console(console), format_args!("error:Discarding long line\n"));
        }
        let target = Target::Console(console);
        let ok = if self.config.general.grbl_mode { "" } else { "ok\n" };
        while self.consoles.take_lost(console) {
            self.consoles.write(target, format_args!("error:line lost, wait for ok before sending more\n{ok}"));
        }
        match self.consoles.waiting(console).map(<[u8]>::trim_ascii) {
            Some(b"$X") => {
                if self.state == State::Halt {
                    self.unlock(target);
                }
                self.consoles.write(target, format_args!("ok\n"));
            }
            Some(b"$I") => self.report_modal(target),
            Some(b"$S") => self.report_switches(target),
            _ => return,
        }
        self.consoles.take_from(console);
    }

    fn feed_hold(&mut self) {
        self.follow_motion();
        if self.apply(Event::Hold) {
            self.ports.motion(motion::Motion::hold);
        }
    }

    fn feed_resume(&mut self) {
        if self.apply(Event::Resume) {
            self.ports.motion(motion::Motion::resume);
        }
    }

    /// Run and Idle follow from what the planner does.
    fn follow_motion(&mut self) {
        let idle = self.ports.motion(|motion| motion.is_idle());
        let _changed = self.apply(if idle { Event::Drained } else { Event::Started });
    }

    fn watch_heat(&mut self) {
        let Some(fault) = self.ports.heat(crate::heat::HeatControl::take_fault) else { return };
        let text = self.heat_fault_text(fault);
        if self.state == State::Halt {
            // The outputs are off already; that it goes on all the same a person must hear.
            return self.announce(format_args!("ERROR: {text}\n"));
        }
        self.halt(format_args!("ERROR: {text}\nHALT asserted - reset or M999 required\n"));
    }

    fn heat_fault_text(&self, fault: HeatFault) -> crate::failure::Message {
        let heater = self.config.heater(fault.heater);
        let name = heater.map_or("?", |heater| heater.designator.as_str());
        match fault.cause {
            HeatCause::NoReading => message(format_args!(
                "MINTEMP or MAXTEMP triggered on {name}. Check your temperature sensors! (no reading: open or shorted)"
            )),
            HeatCause::BelowMinimum(celsius) | HeatCause::AboveMaximum(celsius) => message(format_args!(
                "MINTEMP or MAXTEMP triggered on {name}. Check your temperature sensors! (reads {:.1})",
                celsius.0
            )),
            HeatCause::HeatingTooSlow | HeatCause::CoolingTooSlow => message(format_args!(
                "Temperature took too long to be reached on {name}, HALT asserted, TURN POWER OFF IMMEDIATELY"
            )),
            HeatCause::Runaway(by) => message(format_args!(
                "Temperature runaway on {name} (delta temp {:.6}), HALT asserted, TURN POWER OFF IMMEDIATELY",
                by.0
            )),
            HeatCause::StuckOn(by) => message(format_args!(
                "{name} is switched off and has warmed by {:.0} C: its MOSFET or relay conducts. TURN POWER OFF \
                 IMMEDIATELY",
                by.0
            )),
            HeatCause::DispatcherSilent => message(format_args!(
                "the controller did not answer for {} s while {name} was on",
                crate::heat::DISPATCHER_TIMEOUT.seconds()
            )),
        }
    }

    fn watch_supervisor(&mut self) {
        while let Some(event) = self.ports.supervisor(crate::supervisor::Supervisor::take_event) {
            match event {
                SupervisorEvent::MotorSupplyLost => self.motor_supply_lost(),
                SupervisorEvent::MotorSupplyReturned => {
                    self.announce(format_args!("// NOTICE motor supply is on, HOME before moving\n"));
                }
                SupervisorEvent::FetSupplyLost => self.fet_supply_lost(),
                SupervisorEvent::FetSupplyReturned => {
                    self.announce(format_args!("// NOTICE heater supply is on\n"));
                }
                SupervisorEvent::Driver(motor, trouble) => {
                    let letter = Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter());
                    let text = trouble.text();
                    let halts = trouble.is_fatal() && self.config.motors.halt_on_driver_alarm;
                    if halts && self.state != State::Halt {
                        self.halt(format_args!("ERROR: motor driver {letter}: {text}\n"));
                    } else {
                        self.announce(format_args!("WARNING: {letter}: {text}\n"));
                    }
                }
            }
        }
    }

    /// Without supply a motor holds nothing: positions are no longer known.
    fn motor_supply_lost(&mut self) {
        let moving = !matches!(self.state, State::Idle | State::Halt);
        self.homed = 0;
        self.motors_on = 0;
        if moving {
            self.halt(format_args!("ERROR: motor supply lost while moving\n"));
        } else {
            self.announce(format_args!("WARNING: motor supply is off (vmotor below 6 V), axes are no longer homed\n"));
        }
    }

    /// Without its supply a heater would only be missed by its guard, minutes later.
    fn fet_supply_lost(&mut self) {
        if self.ports.heat(|heat| heat.any_on()) {
            self.halt(format_args!("ERROR: heater supply lost while heating (vfet below 6 V)\n"));
        } else {
            self.announce(format_args!(
                "WARNING: heater supply is off (vfet below 6 V), heaters and fans do nothing\n"
            ));
        }
    }

    fn watch_kill_button(&mut self, now: Micros) {
        let button = self.config.kill_button;
        if !button.enable || button.pin.is_none() {
            return;
        }
        let pressed = self.ports.inputs().is_active(Input::Kill);
        self.kill_button(pressed, now);
    }

    fn blink(&mut self, now: Micros) {
        if now < self.led_due {
            return;
        }
        self.led_due = now.plus(LED_PERIOD);
        self.led_phase = self.led_phase.wrapping_add(1);
        let (phase, state) = (self.led_phase, self.state);
        self.ports.set_led(0, phase & 1 == 0);
        let playing = match state {
            // About 300 ms a change.
            State::Halt => (phase / 3) & 1 == 0,
            State::Idle => false,
            _ => true,
        };
        self.ports.set_led(1, playing);
    }
}
