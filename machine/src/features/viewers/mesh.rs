//! The mesh of the bed, as viewers see it: rows from the front, each from the left, whichever way it was
//! probed.

use base::Ports;
use base::bed::Bed;
use base::snapshot::MeshShown;
use motion::{GridShape, MOST_SIDE, Motion};

/// Returns the mesh in force, if there is one, and gives viewers its heights where they have others.
pub(super) fn shown<P: Ports>(bed: &Bed, ports: &mut P) -> Option<MeshShown> {
    let (shape, number) = ports.motion(|motion| {
        let compensation = motion.compensation();
        // Zero is the number of no mesh.
        compensation.grid().map(|grid| (*grid.shape(), compensation.changes().wrapping_add(1).max(1)))
    })?;
    let [columns, rows] = shape.count;
    if ports.wants_heights(number) {
        for row in 0..rows {
            let mut room = [0.0; MOST_SIDE];
            let Some(heights) = room.get_mut(..columns) else { break };
            ports.motion(|motion| copy_row(motion, &shape, row, heights));
            ports.show_heights(number, row, heights);
        }
    }
    let mut ends = [shape.origin; 2];
    let [low, high] = &mut ends;
    for ((low, high), (step, count)) in low.iter_mut().zip(high).zip(shape.step.into_iter().zip(shape.count)) {
        let far = *low + step * count.saturating_sub(1) as f64;
        *(if step > 0.0 { high } else { low }) = far;
    }
    Some(MeshShown { name: bed.mesh_name, ends, count: [columns as u8, rows as u8], number })
}

/// Copies the heights of a row, counted from the front, from left to right.
fn copy_row(motion: &Motion, shape: &GridShape, row: usize, to: &mut [f32]) {
    let Some(grid) = motion.compensation().grid() else { return };
    let [columns, rows] = shape.count;
    let row = if shape.step[1] < 0.0 { rows.saturating_sub(row + 1) } else { row };
    let heights = grid.heights().iter().skip(row * columns);
    to.iter_mut().zip(heights).for_each(|(to, height)| *to = *height);
    if shape.step[0] < 0.0 {
        to.reverse();
    }
}
