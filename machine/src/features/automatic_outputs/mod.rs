//! Outputs that nobody switches: outputs that follow temperatures and motors; and fans that ought to turn.

use core::fmt::{self, Display, Formatter};

use base::reason::Alarm;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use config::{FanConfig, FanFollows, StoppedFan, TemperatureSwitchConfig};
use parts::fans::{Facts, Fans, Found};
use parts::outputs::{Outputs, TemperatureSwitches};
use program::State;
use thermal::HeatControl;
use thermal::surplus::SurplusWatch;
use units::{Celsius, Micros, SwitchId};

use crate::features::state::States;
use crate::machine::Machine;
use crate::machine::moments::Moments;
use crate::machine::program_io::apply;
use crate::machine::work_hands::HaltHands;

/// Outputs that nobody switches, and what they follow.
pub(crate) struct Automatic<'m, 'c, P> {
    fans: &'m mut Fans,
    switches: &'m mut TemperatureSwitches,
    surplus: &'m mut SurplusWatch,
    outputs: &'m mut Outputs,
    /// A motor has current.
    motors: bool,
    world: &'m mut World<'c, P>,
}

/// The machine for outputs that nobody switches.
pub(crate) trait AutomaticHands<'c>: HaltHands<'c> {
    /// Returns the outputs.
    fn automatic(&mut self) -> Automatic<'_, 'c, Self::Ports>;
}

impl<'c, P: Ports> AutomaticHands<'c> for Machine<'c, P> {
    fn automatic(&mut self) -> Automatic<'_, 'c, P> {
        let States { fans, temperature_switches, heat_surplus, .. } = &mut self.features;
        Automatic {
            fans,
            switches: temperature_switches,
            surplus: heat_surplus,
            outputs: &mut self.outputs,
            motors: self.axes.has_any_on(),
            world: &mut self.world,
        }
    }
}

/// Outputs that nobody switches, at the machine's moments.
pub(crate) struct Feature;

impl<'c, M: AutomaticHands<'c>> Moments<M> for Feature {
    fn wired(hands: &mut M) {
        configure_fans(hands.world());
    }

    /// Looks in every state: hot parts are cooled in a halt too.
    fn each_10_ms(hands: &mut M, now: Micros) {
        if hands.state() == State::Invalid {
            return;
        }
        let is_halted = hands.is_halted();
        let Automatic { fans, switches, outputs, motors, world, .. } = hands.automatic();
        if !world.config.temperature_switches.is_empty() {
            follow_temperatures(world, switches, outputs, now);
        }
        if !world.config.fans.is_empty() {
            follow_by_fans(world, fans, outputs, motors, now);
            if let Some(stopped) = watch_tachometers(world, fans, is_halted, now) {
                hands.halt(Alarm::Abort, format_args!("ERROR: {stopped}\n"));
            }
        }
        let Automatic { surplus, world, .. } = hands.automatic();
        compare_with_models(world, surplus, now);
    }

    fn arm(hands: &mut M, rule: u8, armed: bool) {
        hands.automatic().switches.arm(rule, armed);
    }

    fn stops(hands: &mut M) {
        let Automatic { switches, world, .. } = hands.automatic();
        switches.halted(world.config);
    }
}

/// Warns of a heater that takes quite another power than its model explains: its sensor may be slipping out.
fn compare_with_models<P: Ports>(world: &mut World<'_, P>, heat_surplus: &mut SurplusWatch, now: Micros) {
    let found = world.ports.heat(|heat| heat_surplus.look(now, |id| heat.heater(id)?.surplus()));
    let Some((id, share)) = found else { return };
    let name = world.config.heater(id).map_or("?", |heater| heater.designator.as_str());
    let (percent, what) = (100.0 * share.abs(), if share > 0.0 { "more" } else { "less" });
    world.announce(format_args!(
        "WARNING: {name} takes {percent:.0} % {what} heat than its model explains: look after its sensor, sock, fan and \
         supply; M306 finds another model\n"
    ));
}

/// Has outputs follow temperatures (`[temperature switch]`).
fn follow_temperatures<P: Ports>(
    World { ports, config, .. }: &mut World<'_, P>,
    switches: &mut TemperatureSwitches,
    outputs: &mut Outputs,
    now: Micros,
) {
    let hottest = |rule: &TemperatureSwitchConfig| -> Option<Celsius> {
        let watched = |place: usize| config.temperatures.get(place).is_some_and(|control| rule.watches(control));
        ports.heat(|heat| {
            let readings = heat.heaters().filter(|(id, _)| watched(id.index()));
            readings.filter_map(|(_, heater)| heater.reading()).reduce(|a, b| if b > a { b } else { a })
        })
    };
    for (switch, on) in switches.look(config, now, hottest) {
        apply(ports, outputs.turn_plainly(config, switch, on));
    }
}

/// Tells heat control, at boot before any output changes, which outputs drive fans, and which have a cycle.
fn configure_fans<P: Ports>(World { ports, config, .. }: &mut World<'_, P>) {
    for (place, switch) in config.switches.iter().enumerate() {
        ports.heat(|heat| heat.set_switch_cycle(place, switch.cycle));
    }
    for fan in &config.fans {
        let switch = config.switches.iter().position(|switch| switch.name == fan.name);
        if let Some(switch) = switch {
            // Heat control has as many places as fans.
            let _fits = ports.heat(|heat| heat.add_fan(switch, fan.drive));
        }
    }
}

/// Switches fans that follow something by themselves (`[fan]`); `motors`: a motor has current.
fn follow_by_fans<P: Ports>(
    World { ports, config, .. }: &mut World<'_, P>,
    fans: &mut Fans,
    outputs: &mut Outputs,
    motors: bool,
    now: Micros,
) {
    let facts = |fan: &FanConfig| ports.heat(|heat| facts(fan, motors, heat));
    for (switch, share) in fans.look(config, now, facts) {
        apply(ports, outputs.drive(config, switch, share));
    }
}

fn facts(fan: &FanConfig, motors: bool, heat: &HeatControl) -> Facts {
    let watches_any = fan.follows == FanFollows::Electronics && fan.sensors.is_empty();
    let watched = || heat.heaters().filter(|(id, _)| watches_any || fan.watches(id.index()));
    let warmest = watched().try_fold(f32::NEG_INFINITY, |most, (_, heater)| Some(most.max(heater.reading()?.0)));
    let heats = watched().any(|(_, heater)| heater.is_on());
    Facts { warmest: warmest.map(Celsius), heats, motors }
}

/// A fan that has stopped.
struct Stopped<'c> {
    name: &'c str,
    rpm: f32,
    least: f32,
}

impl Display for Stopped<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let Self { name, rpm, least } = self;
        write!(f, "fan {name} has stopped: {rpm:.0} rpm, not {least:.0}")
    }
}

/// Watches tachometers, and tells of a fan that has stopped or turns again. One whose stop is to halt the
/// machine is returned.
fn watch_tachometers<'c, P: Ports>(
    world: &mut World<'c, P>,
    fans: &mut Fans,
    is_halted: bool,
    now: Micros,
) -> Option<Stopped<'c>> {
    let World { ports, config, .. } = world;
    let has_supply = ports.supervisor(|supervisor| supervisor.fet_supply_on());
    let (place, found) = ports.heat(|heat| {
        let driven = |switch: SwitchId| has_supply && !heat.is_halted() && heat.given(switch.index()) > 0.0;
        fans.count(config, now, heat.pulses(), driven)
    })?;
    let (fan, rpm) = (config.fans.get(place)?, fans.rpm(place));
    let stopped = Stopped { name: fan.name.as_str(), rpm, least: fan.tachometer.min_rpm };
    match (found, fan.tachometer.when_stopped) {
        (Found::Stopped, StoppedFan::Halt) if !is_halted => return Some(stopped),
        (Found::Stopped, _) => world.announce(format_args!("WARNING: {stopped}\n")),
        _ => world.announce(format_args!("// NOTICE fan {} turns again: {rpm:.0} rpm\n", stopped.name)),
    }
    None
}

/// Reports the power and the speed of fans (M123).
pub(crate) fn report_fans<P: Ports>(world: &mut World<'_, P>, fans: &Fans, to: Recipient) {
    let World { ports, config, sessions, .. } = world;
    ports.heat(|heat| fans.report(config, |switch| heat.given(switch.index()), &mut Reply::new(sessions, to)));
}
