//! Strips of lights: codes change their colours where the path has come to; colours to be shown are looked at
//! some twenty times a second, and sent when they are new.

use base::failure::Failure;
use base::ports::Wake;
use base::{Ports, World};
use motion::Refusal;
use parts::lights::Condition;
use program::{LightChange, State};
use thermal::{HeatControl, OFF_BELOW};
use units::{Micros, SwitchId};

use crate::features::state::States;
use crate::machine::Machine;
use crate::machine::moments::Moments;
use crate::machine::program_io::apply;

/// Distance from its target within which a heater has warmed up, C.
const WARM_WITHIN_C: f32 = 5.0;
/// Temperature from which the way to a target counts, C.
const COLD_C: f32 = 25.0;

/// Strips of lights at the machine's moments.
pub(crate) struct Feature;

impl<P: Ports> Moments<P> for Feature {
    fn wired(machine: &mut Machine<'_, P>) {
        configure(machine);
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, now: Micros) {
        if machine.safety.state() != State::Invalid {
            look(machine, now);
        }
    }

    fn change_light(machine: &mut Machine<'_, P>, light: &LightChange) -> Result<(), Failure> {
        change(machine, light)
    }

    fn pass_light(machine: &mut Machine<'_, P>, change: &LightChange) {
        machine.features.strips.change(change);
    }

    fn drop_effects(machine: &mut Machine<'_, P>) {
        machine.features.riding_lights.clear();
    }
}

/// Sets up the strips of lights, at boot behind the wiring.
pub(crate) fn configure<P: Ports>(machine: &mut Machine<'_, P>) {
    for strip in &machine.world.config.led_strips {
        // The configuration has counted the lights.
        let _fits = machine.features.strips.add(strip.lights(), strip.initial);
    }
}

/// Has colours change behind the moves submitted: at once when nothing moves, or where the change does not
/// ride; else when the motors have come there, and nothing waits.
fn change<P: Ports>(machine: &mut Machine<'_, P>, change: &LightChange) -> Result<(), Failure> {
    loop {
        let waits = change.rides && !machine.safety.is_halted();
        take_reached(machine);
        let is_still =
            machine.world.ports.motion(|motion| motion.is_idle()) && machine.features.riding_lights.is_empty();
        if !waits || is_still {
            machine.features.strips.change(change);
            return Ok(());
        }
        match machine.world.ports.motion(motion::Motion::mark) {
            Ok(mark) if machine.features.riding_lights.wait(mark, *change).is_ok() => return Ok(()),
            Ok(_) | Err(Refusal::Full | Refusal::Stopping) => machine.wait(Wake::Any).unless_halted()?,
            Err(refusal) => return Err(machine.world.texts.refused(format_args!("{refusal}"))),
        }
    }
}

/// Applies the changes of colours that the path has reached.
fn take_reached<P: Ports>(machine: &mut Machine<'_, P>) {
    if machine.features.riding_lights.is_empty() {
        return;
    }
    let reached = machine.world.ports.heat(|heat| heat.reached());
    while let Some(change) = machine.features.riding_lights.reached(reached) {
        machine.features.strips.change(&change);
    }
}

/// Looks at the strips of lights, and sends new colours.
pub(crate) fn look<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    if machine.world.config.led_strips.is_empty() {
        return;
    }
    if machine.features.lights.is_due(now) {
        let condition = condition(machine);
        take_reached(machine);
        let changed = machine.features.strips.take_changed();
        machine.features.lights.look(&machine.world.config.led_strips, condition, changed, now);
    }
    while let Some(place) = machine.features.lights.next() {
        if !send(machine, place) {
            return;
        }
        machine.features.lights.sent(place);
    }
}

/// Sends the colours of a strip. False when they cannot be sent yet.
fn send<P: Ports>(machine: &mut Machine<'_, P>, place: usize) -> bool {
    let Machine { features: States { lights, strips, .. }, world: World { config, ports, .. }, .. } = machine;
    let config = *config;
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
        let change = machine.outputs.drive(config, SwitchId(switch as u8), f32::from(part) / 255.0);
        apply(machine, change);
    }
    true
}

fn condition<P: Ports>(machine: &mut Machine<'_, P>) -> Condition {
    match machine.safety.told_mode().state() {
        State::Alarm | State::Sleep | State::Invalid => return Condition::Halted,
        State::Hold | State::Suspended | State::Door => return Condition::Waits,
        _ => {}
    }
    if machine.jobs.waits_for_operator() {
        return Condition::Waits;
    }
    if let Some(share) = machine.world.ports.heat(warming) {
        return Condition::Heats(share);
    }
    match machine.jobs.share() {
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
