//! The laser beside the path: locked while the machine is halted, behind an open door and while an interlock
//! is open; the beam at rest of `fire`; the operator's factor on every power.

use core::fmt::Arguments;

use base::failure::{Answer, Outcome};
use base::ports::{Clock as _, Input, MotionPort as _};
use base::safety::Event;
use base::sessions::{Recipient, SessionId};
use base::snapshot::LaserShown;
use base::tuning::Tuning;
use base::{Ports, World};
use config::{LaserInHold, MachineConfig};
use gcode::realtime::Realtime;
use heapless::String;
use jobs::player::Jobs;
use parts::laser::{self, Beam};
use parts::outputs::Outputs;
use program::{BEGINNING_BYTES, Interpreter, State};
use units::Micros;

use crate::features::state::States;
use crate::machine::feed_hold::FeedHoldHands;
use crate::machine::moments::{JobStart, Moments};
use crate::machine::{Machine, feed_hold};

/// Laser, and what decides on it.
pub(crate) struct Lased<'m, 'c, P> {
    beam: &'m mut Beam,
    outputs: &'m Outputs,
    tuning: &'m Tuning,
    program: &'m mut Interpreter,
    jobs: &'m mut Jobs,
    state: State,
    world: &'m mut World<'c, P>,
}

/// The machine for its laser.
pub(crate) trait LaserHands<'c>: FeedHoldHands<'c> {
    /// Returns the laser.
    fn laser(&mut self) -> Lased<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> LaserHands<'c> for Machine<'c, P> {
    fn laser(&mut self) -> Lased<'_, 'c, P> {
        let state = self.safety.state();
        let Self { world, outputs, tuning, program, jobs, features: States { beam, .. }, .. } = self;
        Lased { beam, outputs, tuning, program, jobs, state, world }
    }
}

/// The laser at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: LaserHands<'c>> Moments<M> for Feature {
    fn wired(hands: &mut M) {
        let Lased { tuning, world, .. } = hands.laser();
        let laser = tuning.laser.in_motions_terms(world.config);
        if let Err(error) = world.ports.motion(|motion| motion.configure_laser(laser)) {
            world.announce(format_args!("WARNING: the laser stays off: {error}\n"));
        }
    }

    fn each_250_us(hands: &mut M, now: Micros) {
        if !has_laser(hands.world().config) {
            return;
        }
        let open = open_interlock(hands.world());
        let Lased { beam, tuning, program, state, world, .. } = hands.laser();
        let rests = world.ports.motion(|motion| motion.is_idle());
        let lapses = beam.lapses(&mut world.ports, rests);
        let is_locked = laser::locks(state) || open.is_some() || is_door_open(world) || beam.has_lapsed();
        let is_held = state == State::Hold;
        beam.shut(&mut world.ports, is_locked, is_held && world.config.laser.hold == LaserInHold::Off);
        let asked = laser::asked_at_rest(program, &tuning.laser, world.config);
        beam.look(&mut world.ports, now, rests && !is_held, asked);
        if open.is_some() != core::mem::replace(&mut beam.told_open, open.is_some())
            && let Some(name) = open
        {
            opens(hands, name);
        }
        if lapses {
            has_gone_off(hands);
        }
    }

    fn each_10_ms(hands: &mut M, _now: Micros) {
        let Lased { outputs, world, .. } = hands.laser();
        if has_laser(world.config) {
            let factor = outputs.spindle_percent() / 100.0;
            world.ports.motion(|motion| {
                if motion.power_override() != factor {
                    motion.set_power_override(factor);
                }
            });
        }
    }

    fn take_request(hands: &mut M, request: Realtime, _id: SessionId) -> bool {
        if !matches!(request, Realtime::Status | Realtime::StatusInFull) {
            end(hands);
        }
        false
    }

    fn session_line_begins(hands: &mut M) {
        end(hands);
    }

    fn job_may_start(hands: &mut M) -> JobStart {
        let open = if has_laser(hands.world().config) { open_interlock(hands.world()) } else { None };
        let Some(name) = open else { return JobStart::Now };
        let Lased { jobs, world, .. } = hands.laser();
        let to = jobs.tells_end();
        jobs.close(&mut world.ports);
        world.announce(format_args!("error:the job was not begun: the laser's interlock {name} is open; close it\n"));
        if to != Recipient::Nobody {
            world.say(to, format_args!("Done printing file\n"));
        }
        JobStart::Never
    }

    /// A job that goes on after a power cut is dark until its own next M3 or M4.
    fn job_goes_on(hands: &mut M, _beginning: [u8; BEGINNING_BYTES]) {
        let Lased { program, world, .. } = hands.laser();
        if has_laser(world.config) {
            program::laser::stop(program);
        }
    }

    fn may_go_on(hands: &mut M) -> bool {
        let open = if has_laser(hands.world().config) { open_interlock(hands.world()) } else { None };
        if let Some(name) = open {
            tell_open(hands, name, format_args!("close it, then ~ goes on"));
        } else {
            hands.laser().beam.goes_on();
        }
        open.is_none()
    }

    /// The first step that burns may come before the next look.
    fn goes_on(hands: &mut M, _from: State) {
        let Lased { beam, world, .. } = hands.laser();
        beam.darken(&mut world.ports, false);
    }

    fn stops(hands: &mut M) {
        let Lased { beam, world, .. } = hands.laser();
        beam.force_off(&mut world.ports);
    }
}

fn has_laser(config: &MachineConfig) -> bool {
    config.laser.enable
}

/// Ends the beam at rest.
#[inline]
fn end<'c>(hands: &mut impl LaserHands<'c>) {
    let Lased { beam, world, .. } = hands.laser();
    beam.end(&mut world.ports);
}

/// An interlock has opened: a moving machine holds, so that nothing is left uncut.
fn opens<'c>(hands: &mut impl LaserHands<'c>, name: &str) {
    feed_hold::hold(hands, Event::Hold);
    tell_open(hands, name, format_args!("the beam is locked until it is closed"));
}

/// The laser has gone off by itself: a moving machine holds, so that nothing is left uncut unseen.
#[cold]
fn has_gone_off<'c>(hands: &mut impl LaserHands<'c>) {
    feed_hold::hold(hands, Event::Hold);
    let text = "the laser went off, as the firmware was late: look at the work, then ~ goes on; report this as a bug";
    hands.announce(format_args!("WARNING: {text}\n"));
}

fn tell_open<'c>(hands: &mut impl LaserHands<'c>, name: &str, then: Arguments<'_>) {
    hands.announce(format_args!("// NOTE the laser's interlock {name} is open: {then}\n"));
}

/// Returns the first interlock that is open.
fn open_interlock<'c, P: Ports>(world: &World<'c, P>) -> Option<&'c str> {
    open_interlocks(world).next()
}

fn open_interlocks<'c, P: Ports>(world: &World<'c, P>) -> impl Iterator<Item = &'c str> + use<'c, P> {
    let config: &'c MachineConfig = world.config;
    let levels = world.ports.inputs();
    config.laser.interlock_names().filter(move |name| {
        let place = config.switches.iter().position(|switch| switch.name == *name);
        place.is_none_or(|place| levels.is_active(Input::Switch(place as u8)))
    })
}

/// Returns the laser as viewers see it, while the machine is in this state; none where there is none.
pub(crate) fn shown<P: Ports>(
    world: &mut World<'_, P>,
    program: &Interpreter,
    beam: &Beam,
    state: State,
) -> Option<LaserShown> {
    if !has_laser(world.config) {
        return None;
    }
    let path = world.ports.motion(|motion| motion.power());
    let (power, is_test) = beam.power(world.config.laser.maximum_power, path);
    let is_framing = state == State::Jog && power > 0.0;
    let mut shown =
        LaserShown { power, mode: program.modal().auxiliary.spindle, is_test, is_framing, open: String::new() };
    for piece in open_interlocks(world).flat_map(|name| [name, ","]) {
        // There is room for all of them.
        let _ = shown.open.push_str(piece);
    }
    Some(shown)
}

fn is_door_open<P: Ports>(world: &World<'_, P>) -> bool {
    world.config.safety_door.enable && world.ports.inputs().is_active(Input::Door)
}

/// `fire percent [ms] | off | status`: the beam at rest.
pub(crate) fn fire<'c>(hands: &mut impl LaserHands<'c>, arguments: &str, to: Recipient) -> Outcome {
    let Lased { beam, world, .. } = hands.laser();
    let World { ports, config, texts, sessions } = world;
    if !has_laser(config) {
        return Err(texts.because("there is no laser: see [laser]"));
    }
    let is_question = matches!(arguments, "" | "status" | "off");
    if !is_question && !ports.motion(|motion| motion.is_idle()) {
        return Err(texts.because("the laser is fired at rest: wait until the machine stands"));
    }
    let now = ports.now();
    let percent = beam.fire(texts, ports, now, config.laser.maximum_power, arguments)?;
    sessions.say(to, format_args!("laser {percent:.1} %\n"));
    Ok(Answer::Ok)
}
