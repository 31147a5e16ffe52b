//! `get`: reports of single facts about the machine.

use base::failure::{Answer, Failure, Outcome};
use base::ports::{Board, HeatPort, MotionPort};
use base::safety::microseconds;
use base::sessions::Reply;
use config::MachineConfig;
use heapless::Vec;
use units::{Axis, PerActuator, PerAxis};

use super::status::{Status, fields, mode};
use super::{position, program};
use crate::outputs::Outputs;

/// Runs `get pos|wcs|state|mode|status|steps|temp [name|chip]|volts [name]|fk|ik x[,y,z]`.
///
/// # Errors
/// When the subject is unknown.
pub fn get(
    ports: &mut (impl MotionPort + HeatPort + Board),
    of: &Status<'_>,
    outputs: &Outputs,
    arguments: &str,
    reply: &mut Reply<'_>,
) -> Outcome {
    let mut words = arguments.split_ascii_whitespace();
    match words.next() {
        Some("pos") => position::positions(ports, of.config, of.program, reply),
        Some("wcs") => program::offsets(of.program, true, reply),
        Some("state") => {
            let line = program::modal_words(of.config, of.program, outputs);
            reply.say(format_args!("{line}\n"));
        }
        Some("mode") => mode(of.mode, reply),
        Some("status") => {
            let line = fields(ports, of);
            reply.say(format_args!("{line}\n"));
        }
        Some("steps") => step_times(ports, reply),
        Some("temp") => temperatures(ports, of.config, words.next(), reply),
        Some("volts") => volts(ports, of.config, words.next(), reply),
        Some(way @ ("fk" | "ik")) => kinematics(ports, way == "fk", words.next(), reply)?,
        _ => return Err(Failure::refused(&"get what? pos, wcs, state, mode, status, steps, temp, volts, fk, ik")),
    }
    Ok(Answer::Ok)
}

/// `get steps`: reports how well steps kept their times since boot.
fn step_times(ports: &mut (impl MotionPort + Board), reply: &mut Reply<'_>) {
    let times = ports.step_times();
    let worst_us = microseconds(times.worst);
    let counters = ports.motion(|motion| motion.counters());
    reply.say(format_args!(
        "steps late: {} (worst {worst_us:.2} us), delayed: {}\n\
         feed late: {}, urgent: {}\n\
         steps moved for a driver: {}, blocks without look-ahead: {}, pieces joined: {}\n",
        times.late, times.delayed, counters.late, counters.urgent, counters.squeezed, counters.starved, counters.lumped
    ));
}

/// `get fk x[,y,z]`, `get ik x[,y,z]`: reports the tool's position for motors' positions, and the other way
/// round. A missing number repeats the last given.
fn kinematics(
    ports: &mut impl MotionPort,
    forward: bool,
    numbers: Option<&str>,
    reply: &mut Reply<'_>,
) -> Result<(), Failure> {
    let usage = || Failure::refused(&"usage: get [fk|ik] x[,y,z]");
    let mut given = numbers.unwrap_or("").split(',').map(gcode::read_f64);
    let mut last = given.next().flatten().ok_or_else(usage)?;
    let mut point = PerAxis::default();
    for axis in Axis::PRIMARY {
        if axis != Axis::X
            && let Some(number) = given.next()
        {
            last = number.ok_or_else(usage)?;
        }
        point[axis] = last;
    }
    let Some(config) = ports.motion(|motion| motion.config().copied()) else {
        return Err(Failure::refused(&"motion is not configured"));
    };
    let (name, [x, y, z, ..]) = match forward {
        true => ("cartesian", config.kinematics.point(&PerActuator(point.0)).0),
        false => ("actuator", config.kinematics.actuators(&point).0),
    };
    reply.say(format_args!("{name}= X {x:.6}, Y {y:.6}, Z {z:.6}\n"));
    Ok(())
}

/// Reports temperatures (`get temp [name|chip]`).
fn temperatures(
    ports: &mut (impl HeatPort + Board),
    config: &MachineConfig,
    name: Option<&str>,
    reply: &mut Reply<'_>,
) {
    let mut is_known = name == Some("chip");
    for (id, controller) in config.heaters().filter(|(_, heater)| name.is_none_or(|name| name == heater.name)) {
        let shown = ports.heat(|heat| {
            let heater = heat.heater(id)?;
            let reading = heater.reading().map_or(f32::INFINITY, |celsius| celsius.0);
            Some((reading, heater.target().0, heater.duty().0))
        });
        let Some((reading, target, duty)) = shown else { continue };
        is_known = true;
        reply.say(format_args!("{}", controller.name));
        if name.is_none() {
            reply.say(format_args!(": {} ({})", controller.designator, controller.tool_id));
        }
        reply.say(format_args!(" temp: {reading:.6}/{target:.6} @{duty}\n"));
    }
    match name {
        Some(name) if !is_known => reply.say(format_args!("{name} is not a known temperature control\n")),
        None | Some("chip") => {
            if let Some(celsius) = ports.chip_celsius() {
                reply.say(format_args!("chip temp: {:.6}\n", celsius.0));
            }
        }
        _ => {}
    }
}

/// Reports supply voltages (`get volts [name]`).
fn volts(board: &mut impl Board, config: &MachineConfig, name: Option<&str>, reply: &mut Reply<'_>) {
    let mut say = |name: &str| match board.voltage(name) {
        Some(volts) => reply.say(format_args!("{name}: {:.6} v\n", volts.0)),
        None => reply.say(format_args!("{name}: INF\n")),
    };
    if let Some(name) = name {
        return say(name);
    }
    let mut names: Vec<&str, { config::MAX_VOLTAGES + 2 }> = Vec::new();
    names.extend(config.voltages.iter().map(|monitor| monitor.name.as_str()).chain(["vbat", "vref"]));
    units::sort_short(&mut names, Ord::cmp);
    names.iter().for_each(|name| say(name));
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::bench::{BenchHands, Desk, THREE_MOTORS};
    use base::hands::Hands;

    /// Returns what `get temp` says of this name, on a machine whose heaters do not read.
    fn temperatures_of(name: Option<&str>) -> String {
        let mut bench = BenchHands::<()>::new(THREE_MOTORS);
        let config = bench.config();
        Desk::new().hears(|reply| temperatures(&mut bench.world, config, name, reply))
    }

    #[test]
    fn who_asks_for_a_heater_that_there_is_not_is_told() {
        assert_eq!(temperatures_of(Some("nozzle")), "nozzle is not a known temperature control\n");
        assert_eq!((temperatures_of(None), temperatures_of(Some("chip"))), (String::new(), String::new()));
    }

    #[test]
    fn a_supply_that_cannot_be_measured_is_infinite() {
        let mut bench = BenchHands::<()>::new(THREE_MOTORS);
        let config = bench.config();
        let said =
            |bench: &mut BenchHands<()>, name| Desk::new().hears(|reply| volts(&mut bench.world, config, name, reply));
        assert_eq!(said(&mut bench, Some("vmotor")), "vmotor: 24.000000 v\n");
        assert!(said(&mut bench, None).contains("vbat: 24.000000 v\n"));
        bench.world.supply = None;
        assert_eq!(said(&mut bench, Some("vmotor")), "vmotor: INF\n");
    }

    #[test]
    fn kinematics_repeat_the_last_number() {
        let mut bench = BenchHands::<()>::new(THREE_MOTORS);
        let mut said = |numbers| {
            let mut done = Ok(());
            let text = Desk::new().hears(|reply| done = kinematics(&mut bench.world, true, numbers, reply));
            done.map(|()| text)
        };
        assert_eq!(said(Some("1,2")).unwrap(), "cartesian= X 1.000000, Y 2.000000, Z 2.000000\n");
        assert_eq!(said(Some("3")).unwrap(), "cartesian= X 3.000000, Y 3.000000, Z 3.000000\n");
        assert!(said(None).is_err() && said(Some("1,x")).is_err());
    }
}
