//! Reports of the program's modes and offsets: `$G`, `$#`, M200, M221.

use base::CodeContext;
use base::failure::{Answer, Outcome};
use base::needs::failure_of;
use base::sessions::Reply;
use config::MachineConfig;
use program::{Interpreter, Tools, write_system_name};
use units::Plane;

use super::status::requested_rate;
use super::{Line, add};
use crate::outputs::Outputs;

/// Returns the name of a coordinate system.
fn system_name(system: usize) -> heapless::String<8> {
    let mut name = heapless::String::new();
    // Eight characters hold every name.
    let _ = write_system_name(&mut name, system);
    name
}

/// `$G`: reports `[GC:G0 G54 G17 G21 G90 G94 G61 M0 M5 M9 T0 F4000.0000 S0.0000]`.
pub fn modal(config: &MachineConfig, program: &Interpreter, outputs: &Outputs, reply: &mut Reply<'_>) {
    let line = modal_words(config, program, outputs);
    reply.say(format_args!("[{line}]\n"));
}

/// Returns the text between the brackets of `$G`; `get state` reports it without them.
pub(super) fn modal_words(config: &MachineConfig, program: &Interpreter, outputs: &Outputs) -> Line {
    let modal = program.modal();
    let plane = match modal.plane {
        Plane::Xy => 17,
        Plane::Xz => 18,
        Plane::Yz => 19,
    };
    let system = system_name(modal.system);
    let (motion, path, units) = (modal.motion_code(), modal.corner.code(), if modal.inches { 20 } else { 21 });
    let (distance, feed_mode) = (if modal.absolute { 90 } else { 91 }, modal.feed_mode.code());
    let spindle = if outputs.is_on_by_name(config, "spindle") { 3 } else { 5 };
    let feed = modal.in_program_units(requested_rate(program).per_minute());
    let (power, tool) = (modal.power, program.tools().active_id());
    let mut line = Line::new();
    add!(line, "GC:{motion} {system} G{plane} G{units} G{distance} {feed_mode} {path} M0 M{spindle} M9 ");
    add!(line, "T{tool} F{feed:.4} S{power:.4}");
    line
}

/// `$#`: reports every offset.
pub fn offsets(program: &Interpreter, verbose: bool, reply: &mut Reply<'_>) {
    let modal = program.modal();
    if verbose {
        work_system(program, reply);
    }
    for (system, offsets) in modal.systems.iter().enumerate() {
        say_offsets(program, &system_name(system), *offsets, reply);
    }
    let park = program.park();
    say_offsets(program, "G28", [park.x, park.y, park.z.unwrap_or(0.0)], reply);
    let second = program.second_park().copied().unwrap_or_default();
    say_offsets(program, "G30", [second.x, second.y, second.z.unwrap_or(0.0)], reply);
    say_offsets(program, "G92", modal.g92, reply);
    let [x, y, z] = modal.tool_offset.map(|mm| modal.in_program_units(mm));
    if verbose {
        reply.say(format_args!("[Tool Offset:{x:.4},{y:.4},{z:.4}]\n"));
    } else {
        reply.say(format_args!("[TLO:{z:.4}]\n"));
    }
    let (place, found) = program.last_probe();
    let [x, y, z] = place.map(|mm| modal.in_program_units(mm));
    reply.say(format_args!("[PRB:{x:.4},{y:.4},{z:.4}:{}]\n", u8::from(found)));
}

fn say_offsets(program: &Interpreter, name: &str, offsets: [f64; 3], reply: &mut Reply<'_>) {
    let [x, y, z] = offsets.map(|mm| program.modal().in_program_units(mm));
    reply.say(format_args!("[{name}:{x:.4},{y:.4},{z:.4}]\n"));
}

/// Reports the work coordinate system in force.
fn work_system(program: &Interpreter, reply: &mut Reply<'_>) {
    reply.say(format_args!("[current WCS: {}]\n", system_name(program.modal().system)));
}

/// Reports the filament's diameter (M200 without D).
///
/// # Errors
/// When P names an extruder that does not exist.
pub fn filament_diameter<P>(code: CodeContext<'_, P>, tools: &Tools) -> Outcome {
    let CodeContext { texts, config, words, reply, .. } = code;
    let tool = tools.selected(words).map_err(|fault| failure_of(texts, config, &fault, false))?;
    match tool.settings.filament_diameter {
        Some(diameter) => reply.say(format_args!("Filament Diameter: {diameter:.6}\n")),
        None => reply.say(format_args!("Volumetric extrusion is disabled\n")),
    }
    Ok(Answer::Ok)
}

/// Reports the flow factor (M221 without S).
///
/// # Errors
/// When P names an extruder that does not exist.
pub fn flow_factor<P>(code: CodeContext<'_, P>, tools: &Tools) -> Outcome {
    let CodeContext { texts, config, words, reply, .. } = code;
    let tool = tools.selected(words).map_err(|fault| failure_of(texts, config, &fault, false))?;
    reply.say(format_args!("Flow rate at {:6.2} %\n", tool.flow * 100.0));
    Ok(Answer::Ok)
}
