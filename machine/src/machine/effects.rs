//! Effects that are synchronous with motion: outputs, heaters and lights that change when the steps before
//! them have been made.

use base::Ports;
use base::failure::Failure;
use base::needs::needs;
use base::ports::Wake;
use motion::Refusal;
use parts::heat_codes;
use parts::heat_codes::TargetRefusal;
use parts::outputs::Outputs;
use program::{Effect, Part, State};
use thermal::{Full, Output};
use units::{Micros, SwitchId};

use crate::machine::moments::{Features, Moments as _};
use crate::machine::{Machine, fast_forward, program_io};

/// Carries out an effect when its line is read: outputs then change where the path has come to that line.
pub(crate) fn change<P: Ports>(machine: &mut Machine<'_, P>, effect: Effect) -> Result<(), Failure> {
    if machine.safety.state() == State::Check {
        fast_forward::follow(machine, effect);
        return Ok(());
    }
    let is_playing = machine.jobs.is_playing();
    let was_on = matches!(effect, Effect::Switch { switch, .. } if machine.outputs.is_on(switch));
    let output = match effect {
        Effect::Target { heater, target } => {
            if target > thermal::OFF_BELOW {
                needs(machine.world.texts, machine.world.config, Part::Heater(heater), is_playing)?;
                heat_codes::check_target(
                    machine.world.texts,
                    &mut machine.world.ports,
                    machine.world.config,
                    heater,
                    target,
                )?;
                if !machine.world.ports.supervisor(|supervisor| supervisor.fet_supply_on()) {
                    return Err(heat_codes::no_heater_supply());
                }
            }
            Some(Output::Target(heater, target))
        }
        Effect::Switch { switch, on, value } => {
            Outputs::check(machine.world.texts, machine.world.config, switch, on, value, is_playing)?;
            let Machine { world, jobs, outputs, .. } = &mut *machine;
            program_io::tell_beyond(world, jobs, outputs, switch, value);
            machine.outputs.turn(machine.world.config, switch, on, value)
        }
        Effect::Arm { rule, armed } => {
            Features::<P>::arm(machine, rule, armed);
            None
        }
        Effect::Light(change) => return Features::<P>::change_light(machine, &change),
        Effect::Ignored { .. } => None,
    };
    let Some(output) = output else { return Ok(()) };
    ride(machine, output)?;
    match effect {
        Effect::Switch { switch, .. } if machine.outputs.is_on(switch) != was_on => settle(machine, switch),
        _ => Ok(()),
    }
}

/// Waits while a switched output settles: `on_delay` until it has come up (a power supply), `off_delay` until
/// it stands (a spindle).
fn settle<P: Ports>(machine: &mut Machine<'_, P>, switch: SwitchId) -> Result<(), Failure> {
    let is_on = machine.outputs.is_on(switch);
    let delay = |switch: &config::SwitchConfig| if is_on { switch.on_delay } else { switch.off_delay };
    let delay = machine.world.config.switches.get(switch.index()).map_or(Micros(0), delay);
    if delay == Micros(0) || machine.safety.is_halted() {
        return Ok(());
    }
    machine.standstill()?;
    machine.wait_for(delay)
}

/// Has an output change behind the moves submitted: at once when nothing moves, else with the motors, and
/// nothing waits.
fn ride<P: Ports>(machine: &mut Machine<'_, P>, output: Output) -> Result<(), Failure> {
    loop {
        let is_idle = machine.world.ports.motion(|motion| motion.is_idle());
        // On a halted machine nothing is on its way any more, and off must not wait for the motors to stand.
        if machine.safety.is_halted() || is_idle && machine.world.ports.heat(|heat| !heat.has_effects()) {
            let applied = machine.world.ports.heat(|heat| heat.apply(output));
            return applied.map_err(|why| match output {
                Output::Target(heater, target) => {
                    TargetRefusal { config: machine.world.config, heater, target, why }.failure(machine.world.texts)
                }
                _ => Failure::HALTED,
            });
        }
        match machine.world.ports.motion(motion::Motion::mark) {
            Ok(mark) => match machine.world.ports.heat(|heat| heat.ride(mark, output)) {
                Ok(()) => return Ok(()),
                Err(Full) => machine.wait(Wake::Any).unless_halted()?,
            },
            Err(Refusal::Full | Refusal::Stopping) => machine.wait(Wake::Any).unless_halted()?,
            Err(refusal) => return Err(machine.world.texts.refused(format_args!("{refusal}"))),
        }
    }
}
