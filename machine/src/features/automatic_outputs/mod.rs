//! Outputs that nobody switches: outputs that follow temperatures and motors; and fans that ought to turn.

use base::reason::Alarm;
use base::sessions::{Recipient, Reply};
use base::{Ports, World};
use config::{FanConfig, FanFollows, StoppedFan, TemperatureSwitchConfig};
use parts::fans::{Facts, Found};
use program::State;
use thermal::HeatControl;
use units::{Celsius, Micros, SwitchId};

use crate::features::state::States;
use crate::machine::Machine;
use crate::machine::moments::Moments;
use crate::machine::program_io::apply;

/// Outputs that nobody switches, at the machine's moments.
pub(crate) struct Feature;

impl<P: Ports> Moments<P> for Feature {
    fn wired(machine: &mut Machine<'_, P>) {
        configure_fans(machine);
    }

    fn each_10_ms(machine: &mut Machine<'_, P>, now: Micros) {
        if machine.safety.state() != State::Invalid {
            look(machine, now);
        }
    }

    fn arm(machine: &mut Machine<'_, P>, rule: u8, armed: bool) {
        machine.features.temperature_switches.arm(rule, armed);
    }

    fn stops(machine: &mut Machine<'_, P>) {
        machine.features.temperature_switches.halted(machine.world.config);
    }
}

/// Looks at temperatures and has outputs follow, in every state: hot parts are cooled in a halt too.
pub(crate) fn look<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    if !machine.world.config.temperature_switches.is_empty() {
        follow_temperatures(machine, now);
    }
    if !machine.world.config.fans.is_empty() {
        follow_by_fans(machine, now);
        watch_tachometers(machine, now);
    }
    compare_with_models(machine, now);
}

/// Warns of a heater that takes quite another power than its model explains: its sensor may be slipping out.
fn compare_with_models<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    let Machine { features: States { heat_surplus, .. }, world: World { ports, .. }, .. } = machine;
    let found = ports.heat(|heat| heat_surplus.look(now, |id| heat.heater(id)?.surplus()));
    let Some((id, share)) = found else { return };
    let name = machine.world.config.heater(id).map_or("?", |heater| heater.designator.as_str());
    let (percent, what) = (100.0 * share.abs(), if share > 0.0 { "more" } else { "less" });
    machine.announce(format_args!(
        "WARNING: {name} takes {percent:.0} % {what} heat than its model explains: look after its sensor, sock, fan and \
         supply; M306 finds another model\n"
    ));
}

/// Has outputs follow temperatures (`[temperature switch]`).
fn follow_temperatures<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    let Machine { features: States { temperature_switches, .. }, world: World { ports, config, .. }, .. } = machine;
    let hottest = |rule: &TemperatureSwitchConfig| -> Option<Celsius> {
        let watched = |place: usize| config.temperatures.get(place).is_some_and(|control| rule.watches(control));
        ports.heat(|heat| {
            let readings = heat.heaters().filter(|(id, _)| watched(id.index()));
            readings.filter_map(|(_, heater)| heater.reading()).reduce(|a, b| if b > a { b } else { a })
        })
    };
    for (switch, on) in temperature_switches.look(config, now, hottest) {
        let change = machine.outputs.turn_plainly(machine.world.config, switch, on);
        apply(machine, change);
    }
}

/// Tells heat control, at boot before any output changes, which outputs drive fans, and which have a cycle.
pub(crate) fn configure_fans<P: Ports>(machine: &mut Machine<'_, P>) {
    let config = machine.world.config;
    for (place, switch) in config.switches.iter().enumerate() {
        machine.world.ports.heat(|heat| heat.set_switch_cycle(place, switch.cycle));
    }
    for fan in &config.fans {
        let switch = config.switches.iter().position(|switch| switch.name == fan.name);
        if let Some(switch) = switch {
            // Heat control has as many places as fans.
            let _fits = machine.world.ports.heat(|heat| heat.add_fan(switch, fan.drive));
        }
    }
}

/// Switches fans that follow something by themselves (`[fan]`).
fn follow_by_fans<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    let Machine { axes, features: States { fans, .. }, world: World { ports, config, .. }, .. } = machine;
    let motors = axes.has_any_on();
    let facts = |fan: &FanConfig| ports.heat(|heat| facts(fan, motors, heat));
    for (switch, share) in fans.look(config, now, facts) {
        let change = machine.outputs.drive(machine.world.config, switch, share);
        apply(machine, change);
    }
}

fn facts(fan: &FanConfig, motors: bool, heat: &HeatControl) -> Facts {
    let watches_any = fan.follows == FanFollows::Electronics && fan.sensors.is_empty();
    let watched = || heat.heaters().filter(|(id, _)| watches_any || fan.watches(id.index()));
    let warmest = watched().try_fold(f32::NEG_INFINITY, |most, (_, heater)| Some(most.max(heater.reading()?.0)));
    let heats = watched().any(|(_, heater)| heater.is_on());
    Facts { warmest: warmest.map(Celsius), heats, motors }
}

/// Watches tachometers: a fan that has stopped is told, or halts the machine.
fn watch_tachometers<P: Ports>(machine: &mut Machine<'_, P>, now: Micros) {
    let has_supply = machine.world.ports.supervisor(|supervisor| supervisor.fet_supply_on());
    let Machine { features: States { fans, .. }, world: World { ports, config, .. }, .. } = machine;
    let news = ports.heat(|heat| {
        let driven = |switch: SwitchId| has_supply && !heat.is_halted() && heat.given(switch.index()) > 0.0;
        fans.count(config, now, heat.pulses(), driven)
    });
    let Some((place, found)) = news else { return };
    let Some(fan) = machine.world.config.fans.get(place) else { return };
    let rpm = machine.features.fans.rpm(place);
    let (name, least) = (fan.name.as_str(), fan.tachometer.min_rpm);
    match (found, fan.tachometer.when_stopped) {
        (Found::Stopped, StoppedFan::Halt) if !machine.safety.is_halted() => {
            let why = format_args!("ERROR: fan {name} has stopped: {rpm:.0} rpm, not {least:.0}\n");
            machine.halt(Alarm::Abort, why);
        }
        (Found::Stopped, _) => {
            machine.announce(format_args!("WARNING: fan {name} has stopped: {rpm:.0} rpm, not {least:.0}\n"));
        }
        _ => machine.announce(format_args!("// NOTICE fan {name} turns again: {rpm:.0} rpm\n")),
    }
}

/// Reports the power and the speed of fans (M123).
pub(crate) fn report_fans<P: Ports>(machine: &mut Machine<'_, P>, to: Recipient) {
    let Machine { features: States { fans, .. }, world: World { ports, config, sessions, .. }, .. } = machine;
    ports.heat(|heat| fans.report(config, |switch| heat.given(switch.index()), &mut Reply::new(sessions, to)));
}
