//! `get`: one thing about the machine.

use config::MachineConfig;

use super::status::{Status, mode, status};
use super::{position, program};
use crate::failure::{Answer, Failure, Outcome};
use crate::outputs::Outputs;
use crate::ports::{Board, HeatPort, MotionPort};
use crate::safety::microseconds;
use crate::sessions::Reply;

/// `get pos|wcs|state|mode|status|steps|temp [name|chip]|volts [name]`
///
/// # Errors
/// When it is something else.
pub(crate) fn get(
    ports: &mut (impl MotionPort + HeatPort + Board),
    of: &Status<'_>,
    outputs: &Outputs,
    arguments: &str,
    reply: &mut Reply<'_>,
) -> Outcome {
    let mut words = arguments.split_ascii_whitespace();
    match words.next() {
        Some("pos") => position::positions(ports, of.program, reply),
        Some("wcs") => program::work_system(of.program, reply),
        Some("state") => program::modal(of.config, of.program, outputs, reply),
        Some("mode") => mode(of.mode, reply),
        Some("status") => status(ports, of, reply),
        Some("steps") => step_times(ports, reply),
        Some("temp") => temperatures(ports, of.config, words.next(), reply),
        Some("volts") => volts(ports, of.config, words.next(), reply),
        _ => return Err(Failure::refused("get what? pos, wcs, state, mode, status, steps, temp, volts")),
    }
    Ok(Answer::Ok)
}

/// `get steps`: how well steps kept their times since boot.
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

/// `get temp [name|chip]`
fn temperatures(
    ports: &mut (impl HeatPort + Board),
    config: &MachineConfig,
    name: Option<&str>,
    reply: &mut Reply<'_>,
) {
    if name.is_none_or(|name| name == "chip")
        && let Some(celsius) = ports.chip_celsius()
    {
        reply.say(format_args!("chip temp: {:.6}\n", celsius.0));
    }
    for (id, controller) in config.heaters().filter(|(_, heater)| name.is_none_or(|name| name == heater.name)) {
        let shown = ports.heat(|heat| {
            let heater = heat.heater(id)?;
            let reading = heater.reading().map_or(f32::INFINITY, |celsius| celsius.0);
            Some((reading, heater.target().0, heater.duty().0))
        });
        let Some((reading, target, duty)) = shown else { continue };
        reply.say(format_args!(
            "{}: {} ({}) temp: {reading:.6}/{target:.6} @{duty}\n",
            controller.name, controller.designator, controller.tool_id
        ));
    }
}

/// `get volts [name]`
fn volts(board: &mut impl Board, config: &MachineConfig, name: Option<&str>, reply: &mut Reply<'_>) {
    let mut say = |name: &str| match board.voltage(name) {
        Some(volts) => reply.say(format_args!("{name}: {:.6} v\n", volts.0)),
        None => reply.say(format_args!("{name}: INF\n")),
    };
    match name {
        Some(name) => say(name),
        None => config.voltages.iter().for_each(|monitor| say(&monitor.name)),
    }
}
