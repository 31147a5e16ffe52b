//! Copying a program's state in place.

use crate::Interpreter;

/// Copies one part. Never inlined, so that the stack holds the copy no longer than the call.
#[inline(never)]
fn copy<T: Clone>(to: &mut T, from: &T) {
    to.clone_from(from);
}

/// Copies `other` into `program`, part by part: a copy of the whole would need as much stack again.
pub fn copy_program(program: &mut Interpreter, other: &Interpreter) {
    let Interpreter {
        modal,
        tools,
        splines,
        cycles,
        park,
        second_park,
        position,
        saved,
        compliant_seek_rate,
        heaters,
        last_probe,
        memory,
        flow,
        frames,
        input_result,
        debugs,
        line,
        setup,
        left_out,
        effects,
        following,
        pixels,
        before,
    } = program;
    copy(modal, &other.modal);
    copy(tools, &other.tools);
    copy(splines, &other.splines);
    copy(cycles, &other.cycles);
    copy(park, &other.park);
    copy(second_park, &other.second_park);
    copy(position, &other.position);
    copy(saved, &other.saved);
    copy(compliant_seek_rate, &other.compliant_seek_rate);
    copy(heaters, &other.heaters);
    copy(last_probe, &other.last_probe);
    memory.copy_from(&other.memory);
    copy(flow, &other.flow);
    copy(frames, &other.frames);
    copy(input_result, &other.input_result);
    copy(debugs, &other.debugs);
    copy(line, &other.line);
    copy(setup, &other.setup);
    copy(left_out, &other.left_out);
    copy(effects, &other.effects);
    copy(following, &other.following);
    copy(pixels, &other.pixels);
    copy(before, &other.before);
}
