//! Service at every waiting point, however deep in a sequence: sessions are heard, questions answered, faults
//! seen, outputs flushed. Never waits.

use base::failure::Outcome;
use base::own_frame::apart;
use base::ports::{Disk, InputLevels};
use base::reason::Alarm;
use base::safety::{Event, Hit};
use base::sessions::{Listing, Recipient, Rights, SessionId, Visitor};
use base::supervisor::{DriverTrouble, Supervisor, SupervisorEvent};
use base::{Ports, World};
use config::HomingDirection;
use events::{Event as Happened, Text};
use gcode::{Line, realtime::Realtime};
use jobs::files::listings;
use parts::heat_codes::{HeatFaultText, TargetRefusal};
use program::{Dialect, State};
use thermal::HeatControl;
use units::{Actuator, Axis, Micros, PerAxis};

use super::out_of_turn;
use crate::features::{commands, functions};
use crate::machine::end_requests::Requester;
use crate::machine::moments::{Features, Moments as _, Served};
use crate::machine::source::Source;
use crate::machine::{Machine, feed_hold, jogging, long_answers, program_io, supplies};

/// Period of the looks at inputs and faults.
const POLL_PERIOD: Micros = Micros::from_millis(10);
/// Period of the looks at the kill button and the filament's wheel: the button is to be as fast as M112, and
/// a look at all inputs is dear for every turn.
const KILL_PERIOD: Micros = Micros(250);
/// The one question that begins with a G.
const G_QUESTION: &[u8] = b"G28.6";
/// Half period of the life LED.
const LED_PERIOD: Micros = Micros::from_millis(100);

impl<P: Ports> Served for P {
    fn serve(machine: &mut Machine<'_, P>) {
        serve(machine);
    }

    fn run_text(machine: &mut Machine<'_, P>, text: &str, dialect: Dialect, to: Recipient) -> Outcome {
        super::actions::run_text(machine, text, dialect, to)
    }

    fn run_line(machine: &mut Machine<'_, P>, line: &[u8], source: Source) {
        super::lines::run_own_line(machine, line, source);
    }
}

/// Serves sessions, inputs and outputs once.
fn serve<P: Ports>(machine: &mut Machine<'_, P>) {
    let now = machine.world.ports.now();
    machine.world.ports.report_alive();
    machine.world.ports.heat(|heat| heat.executor_alive(now));
    if machine.world.sessions.want_service(&machine.world.ports) {
        machine.serve_sessions();
    }
    if now >= machine.polls.kill_due {
        machine.polls.kill_due = now.plus(KILL_PERIOD);
        machine.watch_kill_button(now);
        Features::<P>::each_250_us(machine, now);
        if machine.safety.is_halted() {
            // A halted machine's place has to be on the card before a falling supply is gone.
            machine.watch_halt(now);
        }
    }
    if now >= machine.polls.due {
        machine.polls.due = now.plus(POLL_PERIOD);
        apart(|| machine.watch(now));
    }
    Features::<P>::each_turn(machine);
    out_of_turn::follow(machine);
    machine.world.sessions.flush(&mut machine.world.ports, now);
}

impl<P: Ports> Machine<'_, P> {
    fn serve_sessions(&mut self) {
        for id in self.world.sessions.ids() {
            self.serve_session(id);
        }
    }

    fn serve_session(&mut self, id: SessionId) {
        // Mostly nothing is new.
        let session = self.world.sessions.get(id);
        if !session.is_some_and(|session| session.wants_service(self.world.ports.inbox(id))) {
            return;
        }
        if self.world.sessions.is_visited_anew(&self.world.ports, id) {
            apart(|| self.follow_visitor(id));
        }
        if self.world.ports.inbox(id).has_news() {
            self.serve_requests(id);
            self.gather(id);
        }
        self.answer_lost(id);
        self.answer_question(id);
        long_answers::go_on(self, id);
    }

    /// Follows sessions that come and go: a newcomer has asked for nothing of the one before.
    fn follow_visitor(&mut self, id: SessionId) {
        let Self { files, jobs, world: World { sessions, ports, .. }, .. } = self;
        let (visitor, listing) = sessions.follow_visitor(ports, id);
        let has_left = match visitor {
            Visitor::Left => true,
            Visitor::Waits => return,
            Visitor::Came => false,
        };
        let sent_file = matches!(listing, Some(Listing::Transfer)) || files.takes_lines_of(id);
        // The rest of a file is no lines to be carried out, and nothing in it acts.
        if let Some(session) = sessions.get_mut(id).filter(|_| has_left && sent_file) {
            session.forget_visit(ports.inbox(id));
            session.broke_off_file = true;
        }
        if let Some(listing) = listing {
            if matches!(listing, Listing::Transfer) {
                ports.inbox(id).set_raw(false);
                files.transfers.break_off(ports);
            }
            listings::close(&listing, ports);
        }
        ports.inbox(id).set_text(false);
        files.session_ended(id, ports);
        jobs.session_ended(id);
        let session = id.0;
        self.record(&if has_left { Happened::SessionClosed { session } } else { Happened::SessionOpened { session } });
    }

    /// Serves requests of a session. Seldom: kept out of the code that every line passes through.
    #[inline(never)]
    fn serve_requests(&mut self, id: SessionId) {
        let to = Recipient::Session(id);
        loop {
            // A question needs room for its answer; requests that stop the machine need none.
            let request = self.world.ports.inbox(id).take_request();
            let Some(request) = request else { return };
            match request {
                Realtime::Status
                    if !self.world.sessions.get(id).is_some_and(base::sessions::Session::has_room_for_status) =>
                {
                    // A status request is the least urgent, so nothing else waits behind it.
                    self.world.ports.inbox(id).request(Realtime::Status);
                    return;
                }
                request if Features::<P>::take_request(self, request, id) => {}
                Realtime::Status => functions::report_status(self, to),
                Realtime::Emergency => self.halt(Alarm::Abort, format_args!("ALARM: Emergency stop (M112)\n")),
                Realtime::Abort => {
                    if let Some(session) = self.world.sessions.get_mut(id) {
                        session.clear_line();
                    }
                    self.abort();
                }
                Realtime::QuickStop => out_of_turn::quick_stop(self),
                // A session that only watches may stop the machine, and not set it going again.
                Realtime::Stop | Realtime::Resume | Realtime::EndWait if !self.may_operate(id) => {}
                Realtime::Stop if self.safety.is_halted() => self.unlock(to),
                Realtime::Stop | Realtime::JogCancel => {
                    if let Some(session) = self.world.sessions.get_mut(id) {
                        session.stop_requested = true;
                    }
                    jogging::cancel(&mut self.world, &mut self.safety, id);
                }
                Realtime::Hold => {
                    feed_hold::hold(self, Event::Hold);
                }
                Realtime::Resume => feed_hold::resume(self),
                Realtime::EndWait if self.urgent.awaits_operator => feed_hold::resume(self),
                Realtime::EndWait => out_of_turn::end_wait(self),
                // A byte that no feature takes asks for nothing here.
                _ => {}
            }
        }
    }

    fn may_operate(&self, id: SessionId) -> bool {
        self.world.sessions.get(id).is_some_and(|session| session.rights >= Rights::Operate)
    }

    fn gather(&mut self, id: SessionId) {
        let Self { world: World { sessions, ports, .. }, .. } = self;
        let Some(session) = sessions.get_mut(id) else { return };
        session.gather(ports.inbox(id));
        // The web server hands over a line when the one before is done: the profile has the rights of who
        // sent it.
        if session.is_shared() {
            session.rights = ports.profile(id).rights;
        }
    }

    /// Answers each line that was lost, so that a sender that counts answers stays in step.
    fn answer_lost(&mut self, id: SessionId) {
        let Some(session) = self.world.sessions.get_mut(id) else { return };
        while let Some((error, why)) = session.take_lost() {
            let asked = gcode::Refusal::Resend { expected: session.decoder.expected() };
            match session.decoder.can_resend() && !session.numbers_refusals() {
                true => session.say(format_args!("{asked}\n")),
                false => session.refuse(error, format_args!("{why}")),
            }
        }
    }

    /// Answers a line that is a question now, whatever the machine waits for.
    fn answer_question(&mut self, id: SessionId) {
        let Some(session) = self.world.sessions.get_mut(id) else { return };
        let may_operate = session.rights >= Rights::Operate;
        // A copy: only the line of a question is read here.
        let mut decoder = session.decoder;
        let Some(line) = session.line_to_look_at() else { return };
        // Most lines are moves, and need no closer look.
        if matches!(line.first(), Some(b'G' | b'X' | b'Y' | b'Z')) && !line.starts_with(G_QUESTION) {
            return;
        }
        // `$X` is answered as fast as a question, and is none.
        if self.files.takes_lines_of(id) || !may_operate && line.starts_with(b"$X") {
            return;
        }
        let line = line.clone();
        let (to, mut asks) = (Recipient::Session(id), None);
        let dialect = self.world.sessions.dialect_of(to);
        let is_answered = apart(|| {
            let decoded = decoder.decode(&line).ok();
            asks = decoded.as_ref().and_then(|line| out_of_turn::of_line(line, dialect));
            match decoded {
                Some(Line::Console(command)) => commands::answer(self, command, to),
                Some(Line::Code(blocks)) => functions::answer(self, blocks, to),
                _ => false,
            }
        });
        out_of_turn::ask(&mut self.urgent, &self.jobs, Requester::Session(id), asks.filter(|_| may_operate));
        if let Some(session) = self.world.sessions.get_mut(id).filter(|_| is_answered) {
            session.decoder = decoder;
            session.drop_line();
        }
    }

    // --- watching ---

    fn watch(&mut self, now: Micros) {
        self.world.sessions.stir();
        self.watch_heat();
        self.watch_supervisor();
        self.watch_limits(now);
        self.watch_step_times(now);
        self.watch_reset(now);
        self.watch_halt(now);
        crate::machine::card::watch(&mut self.world);
        let levels = self.world.ports.inputs();
        if self.safety.state() != State::Invalid {
            let has_lines = self.outputs.look(levels, self.world.config, now) | self.watch_buttons(levels, now);
            if has_lines || Features::<P>::line(self).is_some() {
                out_of_turn::ask_for_inputs(self);
            }
        }
        self.follow_motion();
        self.follow_job();
        Features::<P>::each_10_ms(self, now);
        program_io::say_spindle(&mut self.world, &mut self.outputs);
        let is_idle = self.safety.state() == State::Idle;
        self.axes.watch_standstill(&mut self.world.ports, self.world.config, is_idle, now);
        self.watch_frame();
        self.watch_flow(now);
        self.watch_turning(now);
        self.blink(now);
    }

    /// Watches the button box: urgent lines act now, others wait for their turn. Returns whether one has
    /// come.
    fn watch_buttons(&mut self, levels: InputLevels, now: Micros) -> bool {
        let urgent = self.buttons.look(levels, self.world.config, now);
        if urgent.kill {
            self.halt(Alarm::Abort, format_args!("ALARM: Kill button pressed - reset, $X or M999 to clear HALT\n"));
        }
        if urgent.stop_jog
            && let Some(stop) = &mut self.world.sessions.button_stop
        {
            *stop = true;
        }
        urgent.line
    }

    /// Tells the watch over drivers which motors turn slowly.
    fn watch_turning(&mut self, now: Micros) {
        let made = self.world.ports.motion(|motion| motion.steps_made(&motion.steps()));
        let microsteps = |motor: Actuator| self.world.config.actuators[motor].microsteps;
        if let Some(slow) = self.polls.slow_turning.look(now, &made, microsteps) {
            self.world.ports.supervisor(|supervisor| supervisor.set_slow(slow, now));
        }
    }

    /// Tells heaters the flow of filament.
    fn watch_flow(&mut self, now: Micros) {
        if now < self.polls.flow.due() || !self.world.ports.heat(|heat| heat.wants_flow()) {
            return;
        }
        let Some(tool) = self.program.tools().active().map(|tool| &tool.settings) else { return };
        let pushed = self.world.ports.motion(|motion| motion.live_position())[tool.axis];
        let flow = self.polls.flow.look(now, (tool.id, pushed), tool.filament_diameter);
        self.world.ports.heat(|heat| heat.set_flow(tool.id, flow, now));
    }

    /// Reads the frame's temperature, and sets the Z offset for it.
    fn watch_frame(&mut self) {
        let Some(sensor) = self.thermal.sensor() else { return };
        let is_homed = self.axes.homed().has(Axis::Z);
        let reading = self.world.ports.heat(|heat| heat.heater(sensor).and_then(|heater| heater.reading()));
        let celsius = reading.map(|celsius| f64::from(celsius.0));
        let offset = self.thermal.read(celsius, POLL_PERIOD.seconds(), is_homed);
        // On the way back to a job the offset is as it was there.
        if let Some(offset) = offset.filter(|_| !Features::<P>::keeps_thermal_z(self)) {
            self.program.set_thermal_z(offset);
        }
    }

    fn watch_heat(&mut self) {
        if let Some((heater, target, why)) = self.world.ports.heat(HeatControl::take_refusal) {
            let text = TargetRefusal { config: self.world.config, heater, target, why };
            self.announce(format_args!("error:{text}\n"));
        }
        if let Some((sensor, words)) = self.world.ports.heat(HeatControl::take_chip_fault) {
            let name =
                self.world.config.temperatures.get(sensor.index()).map_or("", |controller| controller.name.as_str());
            self.announce(format_args!("WARNING: {name}: {words}\n"));
            self.record(&Happened::Warned(Text::new(format_args!("{name}: {words}"))));
        }
        let Some(fault) = self.world.ports.heat(HeatControl::take_fault) else { return };
        let text = HeatFaultText { config: self.world.config, fault };
        if self.safety.is_halted() {
            // The outputs are off already; a person must hear that the fault persists.
            self.record(&Happened::Warned(Text::new(format_args!("{text}"))));
            return self.announce(format_args!("ERROR: {text}\n"));
        }
        self.halt(Alarm::Abort, format_args!("ERROR: {text}\nHALT asserted - reset or M999 required\n"));
    }

    fn watch_supervisor(&mut self) {
        while let Some(event) = self.world.ports.supervisor(Supervisor::take_event) {
            match event {
                SupervisorEvent::MotorSupplyLost => {
                    let Self { world, axes, phases, safety, .. } = self;
                    if let Some(why) = supplies::motor_supply_lost(world, axes, phases, safety) {
                        self.halt(Alarm::Abort, format_args!("{why}"));
                    }
                }
                SupervisorEvent::MotorSupplyReturned => {
                    self.announce(format_args!("// NOTICE motor supply is on, HOME before moving\n"));
                }
                SupervisorEvent::FetSupplyLost => {
                    if let Some(why) = supplies::fet_supply_lost(&mut self.world) {
                        self.halt(Alarm::Abort, format_args!("{why}"));
                    }
                }
                SupervisorEvent::FetSupplyReturned => self.announce(format_args!("// NOTICE heater supply is on\n")),
                SupervisorEvent::Driver(motor, trouble) => {
                    let letter = Axis::ALL.get(motor as usize).map_or('?', |axis| axis.letter());
                    let text = trouble.text();
                    if trouble.is_off() {
                        // A driver without current may have let its motor turn.
                        self.axes.lose_place(motor);
                    }
                    if trouble == DriverTrouble::Reset {
                        self.axes.lose_current(motor);
                    }
                    let halts = trouble.is_fatal() && self.world.config.motors.halt_on_driver_alarm;
                    if halts && !self.safety.is_halted() {
                        self.halt(Alarm::Abort, format_args!("ERROR: motor driver {letter}: {text}\n"));
                    } else {
                        self.announce(format_args!("WARNING: {letter}: {text}\n"));
                    }
                }
            }
        }
    }

    fn watch_limits(&mut self, now: Micros) {
        let is_homing = self.safety.mode().is_in(State::Homing);
        if !self.safety.limits.exist() || is_homing || self.safety.is_halted() {
            return;
        }
        let moving = !matches!(self.safety.state(), State::Idle | State::Suspended | State::Check);
        let levels = self.world.ports.inputs();
        // Only a search uses the machine's place, so it is read only then.
        let is_searching = self.safety.limits.is_searching();
        let here =
            if is_searching { self.world.ports.motion(|motion| motion.live_position()) } else { PerAxis::default() };
        let Self { safety, world: World { ports, .. }, .. } = self;
        let hit = safety.limits.poll(levels, moving, ports.latch(), now, || here);
        if safety.limits.take_all_clear() {
            self.announce(format_args!("// NOTICE hard limits are now enabled\n"));
        }
        let Some(Hit(index)) = hit else { return };
        let stop = self.world.config.endstops.get(index);
        let name = stop.map_or("?", |stop| stop.name.as_str());
        let letter = stop.and_then(|stop| stop.axis).map_or('?', |axis| axis.letter());
        let end = match stop.map(|stop| stop.homing_direction) {
            Some(HomingDirection::ToMin) => "-",
            Some(HomingDirection::ToMax) => "+",
            _ => "",
        };
        self.halt(
            Alarm::HardLimit,
            format_args!(
                "ALARM: Hard limit {end}{letter} was hit ({name})\n// WARNING hard limits are disabled until all have been \
                 cleared\n"
            ),
        );
    }

    fn watch_step_times(&mut self, now: Micros) {
        let feed_late = self.world.ports.motion(|motion| motion.counters().late);
        let times = self.world.ports.step_times();
        let Some(news) = self.safety.step_times.poll(times, feed_late, now) else { return };
        if news.halts() {
            self.halt(Alarm::Abort, format_args!("{news}\n"));
        } else {
            self.record(&Happened::Warned(Text::new(format_args!("{news}"))));
            self.announce(format_args!("{news}\n"));
        }
    }

    fn blink(&mut self, now: Micros) {
        if now < self.polls.led_due {
            return;
        }
        self.polls.led_due = now.plus(LED_PERIOD);
        self.polls.led_phase = self.polls.led_phase.wrapping_add(1);
        let phase = self.polls.led_phase;
        self.world.ports.set_led(0, phase & 1 == 0);
        let playing = match self.safety.state() {
            // The light changes about every 300 ms.
            State::Alarm | State::Invalid | State::Sleep => (phase / 3) & 1 == 0,
            State::Idle => false,
            _ => true,
        };
        self.world.ports.set_led(1, playing);
        let hot = self.world.ports.heat(|heat| heat.any_hot());
        self.world.ports.set_led(2, hot);
        self.world.ports.set_led(3, self.jobs.is_open());
        // The disk's lamp blinks as often.
        let is_lent = self.world.ports.disk() == Disk::Lent;
        self.world.ports.set_disk_lamp(is_lent && (phase / 3) & 1 == 0);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use program::{Waits, codes};

    #[test]
    fn one_question_begins_with_a_g() {
        let questions = codes::all().filter(|row| row.waits == Waits::Question && row.code.letter == gcode::Letter::G);
        let questions: std::vec::Vec<_> = questions.map(|row| std::format!("{}", row.code)).collect();
        assert_eq!(questions, ["G28.6"], "another one waits for its turn as long as G_QUESTION does not know it");
        assert_eq!(G_QUESTION, b"G28.6");
    }
}
