//! Strips of lights: codes change their colours where the path has come to; colours to be shown are looked at
//! some twenty times a second, and sent when they are new.

use base::failure::Failure;
use base::ports::{HeatPort as _, Wake};
use base::safety::Safety;
use base::{Ports, World};
use jobs::player::Jobs;
use motion::Refusal;
use parts::lights::{Condition, LightShow};
use parts::outputs::Outputs;
use parts::strips::Strips;
use program::{LightChange, State};
use thermal::{Effects, HeatControl, OFF_BELOW};
use units::{Micros, SwitchId};

use crate::features::state::States;
use crate::machine::Machine;
use crate::machine::moments::Moments;
use crate::machine::program_io::apply;
use crate::machine::work_hands::WaitHands;

/// Distance from its target within which a heater has warmed up, C.
const WARM_WITHIN_C: f32 = 5.0;
/// Temperature from which the way to a target counts, C.
const COLD_C: f32 = 25.0;

/// Strips of lights, and what they show.
pub(crate) struct Lit<'m, 'c, P> {
    strips: &'m mut Strips,
    /// Colours that wait for their places on the path.
    riding: &'m mut Effects<LightChange>,
    lights: &'m mut LightShow,
    outputs: &'m mut Outputs,
    jobs: &'m Jobs,
    safety: &'m Safety,
    world: &'m mut World<'c, P>,
}

/// The machine for strips of lights.
pub(crate) trait LightHands<'c>: WaitHands<'c> {
    /// Returns the strips.
    fn lights(&mut self) -> Lit<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> LightHands<'c> for Machine<'c, P> {
    fn lights(&mut self) -> Lit<'_, 'c, P> {
        let Self { world, outputs, jobs, safety, features: States { lights, strips, riding_lights, .. }, .. } = self;
        Lit { strips, riding: riding_lights, lights, outputs, jobs, safety, world }
    }
}

/// Strips of lights at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: LightHands<'c>> Moments<M> for Feature {
    fn wired(hands: &mut M) {
        let Lit { strips, world, .. } = hands.lights();
        for strip in &world.config.led_strips {
            // The configuration has counted the lights.
            let _fits = strips.add(strip.lights(), strip.initial);
        }
    }

    /// Looks at the strips of lights, and sends new colours.
    fn each_10_ms(hands: &mut M, now: Micros) {
        let Lit { strips, riding, lights, outputs, jobs, safety, world } = hands.lights();
        if safety.state() == State::Invalid || world.config.led_strips.is_empty() {
            return;
        }
        if lights.is_due(now) {
            let condition = condition(safety, jobs, || world.ports.heat(warming));
            take_reached(&mut world.ports, strips, riding);
            lights.look(&world.config.led_strips, condition, strips.take_changed(), now);
        }
        while let Some(place) = lights.next() {
            if !send(world, outputs, (lights, strips), place) {
                return;
            }
            lights.sent(place);
        }
    }

    fn change_light(hands: &mut M, change: &LightChange) -> Result<(), Failure> {
        loop {
            let Lit { world, strips, riding, safety, .. } = hands.lights();
            let waits = change.rides && !safety.is_halted();
            if takes(world, strips, riding, (change, waits))? {
                return Ok(());
            }
            hands.wait(Wake::Any).unless_halted()?;
        }
    }

    fn pass_light(hands: &mut M, change: &LightChange) {
        hands.lights().strips.change(change);
    }

    fn drop_effects(hands: &mut M) {
        hands.lights().riding.clear();
    }
}

/// Has colours change behind the moves submitted: at once when nothing moves, or where the change does not
/// wait; else when the motors have come there, and nothing waits. False: there is no room yet.
fn takes<P: Ports>(
    world: &mut World<'_, P>,
    strips: &mut Strips,
    riding: &mut Effects<LightChange>,
    (change, waits): (&LightChange, bool),
) -> Result<bool, Failure> {
    take_reached(&mut world.ports, strips, riding);
    let is_still = world.ports.motion(|motion| motion.is_idle()) && riding.is_empty();
    if !waits || is_still {
        strips.change(change);
        return Ok(true);
    }
    match world.ports.motion(motion::Motion::mark) {
        Ok(mark) => Ok(riding.wait(mark, *change).is_ok()),
        Err(Refusal::Full | Refusal::Stopping) => Ok(false),
        Err(refusal) => Err(world.texts.refused(format_args!("{refusal}"))),
    }
}

/// Applies the changes of colours that the path has reached.
fn take_reached<P: Ports>(ports: &mut P, strips: &mut Strips, riding: &mut Effects<LightChange>) {
    if riding.is_empty() {
        return;
    }
    let reached = ports.heat(|heat| heat.reached());
    while let Some(change) = riding.reached(reached) {
        strips.change(&change);
    }
}

/// Sends the colours of a strip. False when they cannot be sent yet.
fn send<P: Ports>(
    World { ports, config, .. }: &mut World<'_, P>,
    outputs: &mut Outputs,
    (lights, strips): (&LightShow, &Strips),
    place: usize,
) -> bool {
    let Some(strip) = config.led_strips.get(place) else { return true };
    if !strip.is_of_switches() {
        let bytes = lights.bytes(place, strip, strips.colours(place));
        return ports.send_to_strip(place, &bytes);
    }
    let colour = lights.colours(place, strip, strips.colours(place)).next();
    let parts = colour.unwrap_or_default().parts();
    for (name, part) in strip.switches.iter().zip(parts) {
        let switch = config.switches.iter().position(|switch| switch.name == *name);
        let Some(switch) = switch.filter(|_| !name.is_empty()) else { continue };
        apply(ports, outputs.drive(config, SwitchId(switch as u8), f32::from(part) / 255.0));
    }
    true
}

fn condition(safety: &Safety, jobs: &Jobs, warming: impl FnOnce() -> Option<f32>) -> Condition {
    match safety.told_mode().state() {
        State::Alarm | State::Sleep | State::Invalid => return Condition::Halted,
        State::Hold | State::Suspended | State::Door => return Condition::Waits,
        _ => {}
    }
    if jobs.waits_for_operator() {
        return Condition::Waits;
    }
    if let Some(share) = warming() {
        return Condition::Heats(share);
    }
    match jobs.share() {
        Some((percent, _)) => Condition::Makes(f32::from(percent) / 100.0),
        None => Condition::Quiet,
    }
}

/// Returns the heated share of the coldest heater; none when all heaters that are on are warm.
fn warming(heat: &mut HeatControl) -> Option<f32> {
    let cold = heat.heaters().filter_map(|(_, heater)| {
        let (target, reading) = (heater.target().0, heater.reading()?.0);
        let is_cold = target > OFF_BELOW.0 && reading < target - WARM_WITHIN_C;
        is_cold.then(|| (reading - COLD_C) / (target - COLD_C).max(1.0))
    });
    cold.reduce(f32::min)
}
