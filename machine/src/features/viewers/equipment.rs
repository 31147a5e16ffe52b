//! Switches, probe, tool, spindle and coolant, as viewers see them.

use base::ports::{Input, InputLevels};
use base::snapshot::{LimitShown, ProbeShown, Snapshot, SpindleShown};
use base::tuning::Tuning;
use base::{Ports, World};
use config::{HomingDirection, MachineConfig};
use parts::outputs::{Outputs, spindle_scale};
use program::Interpreter;

/// Adds the equipment to what viewers see.
pub(super) fn add<P: Ports>(
    snapshot: &mut Snapshot,
    world: &World<'_, P>,
    program: &Interpreter,
    tuning: &Tuning,
    outputs: &Outputs,
) {
    let (config, levels) = (world.config, world.ports.inputs());
    snapshot.limits = limits(config, levels);
    snapshot.probe = config.probe.pin.filter(|_| config.probe.enable).map(|_| {
        let (place, found) = program.last_probe();
        ProbeShown { touches: tuning.probe_touches(levels), last: found.then_some(place) }
    });
    let tools = program.tools();
    let tool = (!tools.has_extruders()).then(|| (tools.number(), program.modal().tool_offset[2]));
    snapshot.tool = tool;
    snapshot.spindle = spindle(config, program, outputs);
    let has = |code| Outputs::has_code(config, code);
    snapshot.coolant = (has(7) || has(8)).then(|| [8, 7].map(|code| outputs.is_on_by_code(config, code)));
}

fn limits(config: &MachineConfig, levels: InputLevels) -> heapless::Vec<LimitShown, { config::MAX_ENDSTOPS }> {
    let stops = (0..).zip(&config.endstops).filter(|(_, stop)| stop.pin.is_some());
    stops
        .filter_map(|(index, stop)| {
            Some(LimitShown {
                axis: stop.axis?,
                end: match stop.homing_direction {
                    HomingDirection::ToMin => Some(false),
                    HomingDirection::ToMax => Some(true),
                    HomingDirection::None => None,
                },
                is_pressed: levels.is_active(Input::Endstop(index)),
            })
        })
        .collect()
}

fn spindle(config: &MachineConfig, program: &Interpreter, outputs: &Outputs) -> Option<SpindleShown> {
    if !Outputs::has_code(config, 3) && !Outputs::has_code(config, 4) {
        return None;
    }
    let auxiliary = program.modal().auxiliary;
    let asked = auxiliary.speed.unwrap_or(0.0);
    let factor = if auxiliary.spindle_override { outputs.spindle_percent() / 100.0 } else { 1.0 };
    let most = spindle_scale(config).map_or(0.0, |[_, most]| most);
    let set = outputs.spindle_speed(config, asked) * factor;
    Some(SpindleShown {
        direction: outputs.spindle(config, auxiliary.spindle),
        asked,
        set: if outputs.spindle_is_stopped() {
            0.0
        } else if most > 0.0 {
            set.min(most)
        } else {
            set
        },
        most,
        factor: outputs.spindle_percent() / 100.0,
    })
}
