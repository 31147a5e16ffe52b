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
            let mut heights = [0.0; MOST_SIDE];
            ports.motion(|motion| copy_row(motion, &shape, row, &mut heights));
            ports.show_heights(number, row, heights.get(..columns).unwrap_or_default());
        }
    }
    let (first, last) = (shape.place(0), shape.place(shape.points().saturating_sub(1)));
    Some(MeshShown {
        name: bed.mesh_name,
        ends: [[first[0].min(last[0]), first[1].min(last[1])], [first[0].max(last[0]), first[1].max(last[1])]],
        count: [columns as u8, rows as u8],
        number,
    })
}

/// Copies the heights of a row, counted from the front, from left to right.
fn copy_row(motion: &Motion, shape: &GridShape, row: usize, to: &mut [f32; MOST_SIDE]) {
    let Some(grid) = motion.compensation().grid() else { return };
    let [columns, rows] = shape.count;
    let from_front = |row: usize| if shape.step[1] < 0.0 { rows.saturating_sub(row + 1) } else { row };
    let heights = grid.heights().get(from_front(row) * columns..).unwrap_or_default();
    for (place, height) in heights.iter().take(columns).enumerate() {
        let column = if shape.step[0] < 0.0 { columns.saturating_sub(place + 1) } else { place };
        if let Some(to) = to.get_mut(column) {
            *to = *height;
        }
    }
}
