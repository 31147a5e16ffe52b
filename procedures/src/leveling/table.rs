//! M375.1: a grid as a table of numbers.

use core::fmt::Write as _;

use base::failure::{Answer, Failure, Outcome};
use base::ports::MotionPort;
use base::sessions::Reply;
use motion::{GridShape, Motion};

use base::hands::Hands;

/// Text of a row of fifty heights.
type Line = heapless::String<512>;

/// M375.1: reports line `row` of the grid in force: the heading if there is one, the rows, the greatest
/// difference. Returns true while more lines follow. `human_readable` is the configuration's wish for
/// coordinates.
///
/// # Errors
/// When no grid is in force.
pub fn grid_line(
    motion: &mut impl MotionPort,
    human_readable: bool,
    row: usize,
    reply: &mut Reply<'_>,
) -> Result<bool, Failure> {
    let (line, more) = motion.motion(|motion| table_line(motion, human_readable, row))?;
    reply.say(format_args!("{line}\n"));
    Ok(more)
}

/// Shows the whole grid in force, at the end of a sequence.
///
/// # Errors
/// When no grid is in force.
pub fn show_grid<'c>(hands: &mut impl Hands<'c>) -> Outcome {
    let with_places = hands.config().leveling.grid.human_readable;
    let (mut row, mut more) = (0, true);
    while more {
        let line;
        (line, more) = hands.motion(|motion| table_line(motion, with_places, row))?;
        hands.say(format_args!("{line}\n"));
        hands.drain();
        row += 1;
    }
    Ok(Answer::Ok)
}

/// Returns a line of the table, and whether more follow.
fn table_line(motion: &Motion, with_places: bool, index: usize) -> Result<(Line, bool), Failure> {
    let grid = motion.compensation().grid();
    let grid = grid.ok_or_else(|| Failure::refused(&"no grid levels the machine: load one with M375"))?;
    let (shape, rows) = (grid.shape(), grid.shape().count[1]);
    // A table with places has a heading before its first row.
    let line = match index.checked_sub(usize::from(with_places)) {
        None => heading(shape),
        // As on the machine, rear rows come first.
        Some(row) if row < rows && with_places => heights(shape, grid.heights(), rows - 1 - row, true),
        Some(row) if row < rows => heights(shape, grid.heights(), row, false),
        Some(_) => return Ok((greatest_difference(grid.heights()), false)),
    };
    Ok((line, true))
}

fn heading(shape: &GridShape) -> Line {
    let mut line = Line::new();
    // The line has room for the longest grid, here and below.
    let _ = write!(line, "{:>9} ", "Y \\ X");
    for column in 0..shape.count[0] {
        let _ = write!(line, "{:8.2} ", shape.place(column)[0]);
    }
    line
}

fn heights(shape: &GridShape, heights: &[f32], row: usize, with_places: bool) -> Line {
    let (mut line, columns) = (Line::new(), shape.count[0]);
    if with_places {
        let _ = write!(line, "{:8.2} |", shape.place(row * columns)[1]);
    }
    for height in heights.iter().skip(row * columns).take(columns) {
        let _ = if with_places { write!(line, "{height:8.4} ") } else { write!(line, "{height:7.4} ") };
    }
    line
}

fn greatest_difference(heights: &[f32]) -> Line {
    let (low, high) = heights.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), height| {
        (if *height < low { *height } else { low }, if *height > high { *height } else { high })
    });
    let mut line = Line::new();
    let _ = write!(line, "Maximum delta: {:.4}", high - low);
    line
}
