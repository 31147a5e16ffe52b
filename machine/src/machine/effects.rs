//! Effects that are synchronous with motion: outputs, heaters and lights that change when the steps before
//! them have been made.

use base::failure::Failure;
use base::needs::needs;
use base::ports::{HeatPort as _, MotionPort as _, Wake};
use base::supervisor::SupervisorPort as _;
use base::{Ports, World};
use jobs::player::Jobs;
use motion::Refusal;
use parts::heat_codes;
use parts::heat_codes::TargetRefusal;
use parts::outputs::Outputs;
use program::{Effect, LightChange, Part, State};
use thermal::{Full, Output};
use units::{Micros, SwitchId};

use crate::machine::fast_forward::ReadOverHands;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::work_hands::MoveHands;
use crate::machine::{Machine, fast_forward, program_io};

/// The machine for effects of a program: its outputs, and lights of features.
pub(crate) trait EffectHands<'c>: ReadOverHands<'c> {
    /// Returns the switched outputs.
    fn outputs(&mut self) -> &mut Outputs;

    /// Returns the outputs, the jobs that are told of them, and the world that they are in.
    fn outputs_in_world(&mut self) -> (&mut Outputs, &mut Jobs, &mut World<'c, Self::Ports>);

    /// Changes the colours of lights where the path has come to.
    ///
    /// # Errors
    /// When the machine halts meanwhile.
    fn change_light(&mut self, change: &LightChange) -> Result<(), Failure>;
}

impl<'c, P: Ports> EffectHands<'c> for Machine<'c, P> {
    fn outputs(&mut self) -> &mut Outputs {
        &mut self.outputs
    }

    fn outputs_in_world(&mut self) -> (&mut Outputs, &mut Jobs, &mut World<'c, P>) {
        (&mut self.outputs, &mut self.jobs, &mut self.world)
    }

    fn change_light(&mut self, change: &LightChange) -> Result<(), Failure> {
        Features::<P>::change_light(self, change)
    }
}

/// Carries out an effect when its line is read: outputs then change where the path has come to that line.
pub(crate) fn change<'c>(hands: &mut impl EffectHands<'c>, effect: Effect) -> Result<(), Failure> {
    if hands.state() == State::Check {
        fast_forward::follow(hands, effect);
        return Ok(());
    }
    let is_playing = hands.jobs().is_playing();
    let was_on = matches!(effect, Effect::Switch { switch, .. } if hands.outputs().is_on(switch));
    let output = match effect {
        Effect::Target { heater, target } => {
            if target > thermal::OFF_BELOW {
                let World { ports, texts, config, .. } = hands.world();
                needs(texts, config, Part::Heater(heater), is_playing)?;
                heat_codes::check_target(texts, ports, config, heater, target)?;
                if !ports.supervisor(|supervisor| supervisor.fet_supply_on()) {
                    return Err(heat_codes::no_heater_supply());
                }
            }
            Some(Output::Target(heater, target))
        }
        Effect::Switch { switch, on, value } => {
            let (outputs, jobs, world) = hands.outputs_in_world();
            Outputs::check(world.texts, world.config, switch, on, value, is_playing)?;
            program_io::tell_beyond(world, jobs, outputs, switch, value);
            outputs.turn(world.config, switch, on, value)
        }
        Effect::Arm { rule, armed } => {
            hands.arm(rule, armed);
            None
        }
        Effect::Light(change) => return hands.change_light(&change),
        Effect::Ignored { .. } => None,
    };
    let Some(output) = output else { return Ok(()) };
    ride(hands, output)?;
    match effect {
        Effect::Switch { switch, .. } if hands.outputs().is_on(switch) != was_on => settle(hands, switch),
        _ => Ok(()),
    }
}

/// Waits while a switched output settles: `on_delay` until it has come up (a power supply), `off_delay` until
/// it stands (a spindle).
fn settle<'c>(hands: &mut impl EffectHands<'c>, switch: SwitchId) -> Result<(), Failure> {
    let is_on = hands.outputs().is_on(switch);
    let delay = |switch: &config::SwitchConfig| if is_on { switch.on_delay } else { switch.off_delay };
    let delay = hands.world().config.switches.get(switch.index()).map_or(Micros(0), delay);
    if delay == Micros(0) || hands.is_halted() {
        return Ok(());
    }
    hands.standstill()?;
    hands.wait_for(delay)
}

/// Has an output change behind the moves submitted: at once when nothing moves, else with the motors, and
/// nothing waits.
fn ride<'c>(hands: &mut impl MoveHands<'c>, output: Output) -> Result<(), Failure> {
    loop {
        let is_idle = hands.world().ports.motion(|motion| motion.is_idle());
        // On a halted machine nothing is on its way any more, and off must not wait for the motors to stand.
        if hands.is_halted() || is_idle && hands.world().ports.heat(|heat| !heat.has_effects()) {
            let applied = hands.world().ports.heat(|heat| heat.apply(output));
            return applied.map_err(|why| match output {
                Output::Target(heater, target) => {
                    let World { config, texts, .. } = hands.world();
                    TargetRefusal { config, heater, target, why }.failure(texts)
                }
                _ => Failure::HALTED,
            });
        }
        match hands.world().ports.motion(motion::Motion::mark) {
            Ok(mark) => match hands.world().ports.heat(|heat| heat.ride(mark, output)) {
                Ok(()) => return Ok(()),
                Err(Full) => hands.wait(Wake::Any).unless_halted()?,
            },
            Err(Refusal::Full | Refusal::Stopping) => hands.wait(Wake::Any).unless_halted()?,
            Err(refusal) => return Err(hands.world().texts.refused(format_args!("{refusal}"))),
        }
    }
}
