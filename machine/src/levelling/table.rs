//! A grid in numbers: M375.1.

use core::fmt::Write as _;

use motion::GridShape;

use crate::controller::Controller;
use crate::failure::{Answer, Failure, Outcome};
use crate::ports::Ports;

/// A row of fifty heights.
type Line = heapless::String<512>;

impl<P: Ports> Controller<P> {
    /// M375.1: the heights in force, a line for each row of the grid; with coordinates when the configuration wants them.
    pub(crate) async fn show_grid(&mut self) -> Outcome {
        let shape = self.ports.motion(|motion| motion.compensation().grid().map(|grid| *grid.shape()));
        let shape = shape.ok_or_else(|| Failure::refused("no grid levels the machine: load one with M375"))?;
        let with_places = self.config.leveling.grid.human_readable;
        let [nx, ny] = shape.count;
        if with_places {
            let mut line = Line::new();
            // A line of the longest grid fits.
            let _ = write!(line, "{:>9} ", "Y \\ X");
            for column in 0..nx {
                let _ = write!(line, "{:8.2} ", shape.place(column)[0]);
            }
            self.say(format_args!("{line}\n"));
        }
        for row in 0..ny {
            // As on the machine: what is farther away stands higher.
            let row = if with_places { ny - 1 - row } else { row };
            let line = self.row(&shape, row, with_places);
            self.say(format_args!("{line}\n"));
            self.drain().await;
        }
        let (low, high) = self.ports.motion(|motion| {
            let heights = motion.compensation().grid().map_or(&[][..], |grid| grid.heights());
            heights.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), height| {
                (if *height < low { *height } else { low }, if *height > high { *height } else { high })
            })
        });
        self.say(format_args!("Maximum delta: {:.4}\n", high - low));
        Ok(Answer::Ok)
    }

    fn row(&mut self, shape: &GridShape, row: usize, with_places: bool) -> Line {
        let (mut line, [nx, _]) = (Line::new(), shape.count);
        self.ports.motion(|motion| {
            let heights = motion.compensation().grid().map_or(&[][..], |grid| grid.heights());
            if with_places {
                // As above.
                let _ = write!(line, "{:8.2} |", shape.place(row * nx)[1]);
            }
            for height in heights.iter().skip(row * nx).take(nx) {
                let _ = if with_places { write!(line, "{height:8.4} ") } else { write!(line, "{height:7.4} ") };
            }
        });
        line
    }
}
