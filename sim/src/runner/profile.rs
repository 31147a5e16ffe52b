//! What a plot of the motion needs: place, speed, acceleration and jerk of the planned path over time, before input shaping and pressure
//! advance, and so ahead of the motors by their latency.
//!
//! Samples lie on a grid of time. When there are too many, every other one is forgotten and the grid is twice as coarse from then on,
//! so a job of any length gives a table of the same size. Where the motion rests there are no samples but one at its begin.

use std::io::{self, Write};
use std::path::Path;

use motion::trajectory::Piece;
use units::Axis;

/// Most rows of the table.
const MAX_ROWS: usize = 20_000;
/// The finest grid, seconds.
const FINEST: f64 = 0.000_25;

#[derive(Clone, Copy, Debug)]
struct Row {
    time: f64,
    /// Which point of the grid, if it is one: others mark a rest.
    grid: Option<u64>,
    place: [f64; 3],
    speed: f64,
    acceleration: f64,
    jerk: f64,
}

/// Takes samples of pieces as they are planned.
#[derive(Debug)]
pub struct ProfileLog {
    rows: Vec<Row>,
    spacing: f64,
    last: Option<Piece>,
}

fn seconds(piece: &Piece) -> f64 {
    piece.start.to_num::<f64>() / f64::from(units::STEP_CLOCK_HZ)
}

fn sample(piece: &Piece, time: f64, grid: Option<u64>) -> Row {
    let t = (time - seconds(piece)).clamp(0.0, piece.duration);
    let point = piece.point_after(piece.distance(t));
    Row {
        time,
        grid,
        place: Axis::PRIMARY.map(|axis| point[axis]),
        speed: piece.speed_at(t),
        acceleration: piece.acceleration_at(t),
        jerk: piece.jerk,
    }
}

impl ProfileLog {
    /// Nothing seen yet.
    pub const fn new() -> Self {
        Self { rows: Vec::new(), spacing: FINEST, last: None }
    }

    /// The motion goes on with this piece; one that begins within the last takes its place from there on.
    pub fn piece(&mut self, piece: &Piece) {
        if self.last.as_ref() == Some(piece) {
            return;
        }
        if let Some(last) = self.last.replace(*piece) {
            self.take(&last, seconds(piece));
        }
    }

    /// Samples a piece up to `until`.
    fn take(&mut self, piece: &Piece, until: f64) {
        let begin = seconds(piece);
        let end = begin + piece.duration;
        let rests = until > end + self.spacing;
        let until = until.min(end);
        let mut grid = (begin / self.spacing).ceil() as u64;
        while grid as f64 * self.spacing < until {
            let spacing = self.spacing;
            self.push(sample(piece, grid as f64 * spacing, Some(grid)));
            // It may be coarser by now.
            grid = if self.spacing > spacing { grid / 2 } else { grid } + 1;
        }
        if rests {
            let rest = Row { speed: 0.0, acceleration: 0.0, jerk: 0.0, ..sample(piece, end, None) };
            self.push(rest);
        }
    }

    fn push(&mut self, row: Row) {
        self.rows.push(row);
        if self.rows.len() < MAX_ROWS {
            return;
        }
        self.spacing *= 2.0;
        let mut rest = false;
        self.rows.retain_mut(|row| match &mut row.grid {
            Some(grid) => {
                let stays = grid.is_multiple_of(2);
                *grid /= 2;
                stays
            }
            None => {
                rest = !rest;
                rest
            }
        });
    }

    /// Writes the table: `time_s,x_mm,y_mm,z_mm,speed_mm_s,acceleration_mm_s2,jerk_mm_s3`.
    pub fn write(mut self, path: &Path) -> io::Result<()> {
        if let Some(last) = self.last.take() {
            self.take(&last, f64::INFINITY);
        }
        let mut file = io::BufWriter::new(std::fs::File::create(path)?);
        writeln!(file, "time_s,x_mm,y_mm,z_mm,speed_mm_s,acceleration_mm_s2,jerk_mm_s3")?;
        for Row { time, place: [x, y, z], speed, acceleration, jerk, .. } in &self.rows {
            writeln!(file, "{time:.6},{x:.4},{y:.4},{z:.4},{speed:.4},{acceleration:.2},{jerk:.0}")?;
        }
        file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motion::trajectory::tick_time;

    fn piece(start: f64, duration: f64, speed: f64, acceleration: f64) -> Piece {
        Piece { start: tick_time(start), duration, speed, acceleration, ..Piece::default() }
    }

    #[test]
    fn a_table_of_any_job_has_few_rows_in_order_of_time() {
        let mut log = ProfileLog::new();
        for second in 0..60 {
            log.piece(&piece(f64::from(second), 0.4, 0.0, 100.0));
            log.piece(&piece(f64::from(second) + 0.4, 0.4, 40.0, -100.0));
        }
        log.take(&piece(60.0, 1.0, 0.0, 10.0), 70.0);
        assert!(log.rows.len() < MAX_ROWS && log.rows.len() > MAX_ROWS / 4, "{} rows", log.rows.len());
        assert!(log.rows.is_sorted_by(|a, b| a.time < b.time));
        let fastest = log.rows.iter().map(|row| row.speed).fold(0.0, f64::max);
        assert!((fastest - 40.0).abs() < 1.0, "{fastest} mm/s");
        assert!(log.rows.iter().any(|row| row.speed == 0.0 && row.grid.is_none()), "rests show");
    }

    #[test]
    fn what_a_new_plan_replaces_is_not_in_the_table() {
        let mut log = ProfileLog::new();
        log.piece(&piece(0.0, 1.0, 10.0, 0.0));
        log.piece(&piece(0.5, 0.1, 10.0, -100.0));
        log.piece(&piece(2.0, 0.1, 0.0, 100.0));
        let at = |time: f64| log.rows.iter().rfind(|row| row.time <= time).expect("a row").speed;
        assert_eq!(at(0.49), 10.0);
        assert!((at(0.55) - 5.0).abs() < 0.1 && at(1.0) == 0.0);
    }
}
