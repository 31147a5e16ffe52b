//! Cold extrusion: an extruder stands while its nozzle is colder than `min_extrude_temp` or M302 says.

use base::failure::Failure;
use base::tuning::Tuning;
use base::{Ports, World};
use program::{Interpreter, Move};

/// Whether a move may turn the extruder: when it is warm enough, or stays.
pub(crate) fn may_extrude<P: Ports>(
    world: &mut World<'_, P>,
    program: &Interpreter,
    tuning: &Tuning,
    request: &Move,
) -> Result<(), Failure> {
    if !tuning.guards_cold {
        return Ok(());
    }
    let Some(axis) = program.tools().active().map(|tool| tool.settings.axis) else { return Ok(()) };
    let fed = request.target[axis] - world.ports.motion(|motion| motion.commanded_position())[axis];
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
