//! Filament that a move may feed: none while its nozzle is colder than `min_extrude_temp` or M302 says, and
//! without X, Y and Z no more than `max_extrude_only_distance`.

use base::failure::{Failure, TooLong};
use base::tuning::Tuning;
use base::{Ports, World};
use program::{Interpreter, Move};
use units::Axis;

/// Whether a move may turn the extruder: when it is warm enough and the way is short enough, or it stays.
pub(crate) fn may_extrude<P: Ports>(
    world: &mut World<'_, P>,
    program: &Interpreter,
    tuning: &Tuning,
    request: &Move,
) -> Result<(), Failure> {
    if !tuning.guards_filament {
        return Ok(());
    }
    let Some(tool) = program.tools().active().map(|tool| &tool.settings) else { return Ok(()) };
    let here = world.ports.motion(|motion| motion.commanded_position());
    let fed = request.target[tool.axis] - here[tool.axis];
    let is_alone = Axis::PRIMARY.into_iter().all(|axis| request.target[axis] == here[axis]);
    let World { config, texts, .. } = world;
    let extruder = config.extruders.iter().find(|extruder| extruder.tool.id == tool.id);
    if let Some(extruder) = extruder.filter(|extruder| extruder.feeds_too_far(fed, is_alone)) {
        return Err(texts.refused(format_args!("{}", TooLong(extruder))));
    }
    may_feed(world, program, tuning, fed)
}

/// Whether the extruder in use is warm enough to feed so many mm of filament, less than 0 to draw back.
pub(crate) fn may_feed<P: Ports>(
    world: &mut World<'_, P>,
    program: &Interpreter,
    tuning: &Tuning,
    fed: f64,
) -> Result<(), Failure> {
    let World { ports, config, texts, .. } = world;
    let Some(tool) = program.tools().active().map(|tool| &tool.settings) else { return Ok(()) };
    let [least, least_back] = tuning.least_warm.get(usize::from(tool.id.0)).copied().unwrap_or_default();
    let least = if fed < 0.0 { least_back } else { least };
    let heater = config.heaters().find(|(_, heater)| heater.tool_id == tool.id);
    let Some((id, settings)) = heater.filter(|_| fed != 0.0 && least > 0.0) else { return Ok(()) };
    match ports.heat(|heat| heat.heater(id).and_then(|heater| heater.reading())) {
        Some(reading) if reading.0 >= least => Ok(()),
        _ => Err(texts.refused(format_args!("{} is below {least:.0} C: wait with M109, or M302 P1", settings.name))),
    }
}
