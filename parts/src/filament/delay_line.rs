//! Delay line of the filament's diameter between the sensor and the nozzle: a diameter for each piece of a
//! fixed length, indexed by the extruder's position when it passed the sensor. Bounded, and without a heap.

/// Number of pieces that are kept.
const PIECES: usize = 128;
/// Number of pieces between the sensor and the nozzle; the rest is for filament that is drawn back.
const UP_TO_THE_NOZZLE: f64 = 100.0;
/// Length of the shortest piece, mm.
const SHORTEST: f64 = 0.2;
/// Greatest number of looks in a mean: filament that stands may be another one after a while.
const LOOKS: u16 = 32;

/// A piece of filament.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Piece {
    /// Mean diameter, mm; 0 if none was measured.
    diameter: f32,
    /// Number of measurements in the mean.
    count: u16,
}

/// The pieces that have passed the sensor last.
#[derive(Clone, Debug)]
pub struct DelayLine {
    pieces: [Piece; PIECES],
    /// Length of a piece, mm.
    length: f64,
    /// First and last piece that was measured, as multiples of their length.
    measured: Option<(i64, i64)>,
}

impl DelayLine {
    /// Creates a delay line for a sensor at this distance from the nozzle, mm.
    #[must_use]
    pub fn new(delay: f64) -> Self {
        Self { pieces: [Piece::default(); PIECES], length: (delay / UP_TO_THE_NOZZLE).max(SHORTEST), measured: None }
    }

    /// Adds the diameter, mm, of the filament that is at the sensor when the extruder has pushed to `pushed`,
    /// mm; `None` if it is unknown. Filament that passes again after drawing back is known already. Pieces
    /// that passed between two looks get the same diameter.
    pub fn add(&mut self, pushed: f64, diameter: Option<f64>) {
        let place = self.place(pushed);
        let (first, last) = match self.measured {
            Some((first, last)) if place > last - PIECES as i64 => (first, last),
            // Either the first piece, or the extruder counts anew.
            _ => (place, place - 1),
        };
        if place < last {
            return;
        }
        let diameter = diameter.unwrap_or(0.0) as f32;
        if place == last {
            self.average(place, diameter);
        } else {
            for passed in (last + 1).max(place - PIECES as i64 + 1)..=place {
                *self.piece_mut(passed) = Piece { diameter, count: 1 };
            }
        }
        self.measured = Some((first, place));
    }

    fn average(&mut self, place: i64, diameter: f32) {
        let piece = self.piece_mut(place);
        if diameter > 0.0 && piece.diameter > 0.0 {
            piece.count = (piece.count + 1).min(LOOKS);
            piece.diameter += (diameter - piece.diameter) / f32::from(piece.count);
        } else {
            *piece = Piece { diameter, count: 1 };
        }
    }

    /// Returns the diameter of the piece that passed the sensor when the extruder had pushed to `pushed`, mm.
    /// For a piece that will pass only later, the last piece is taken. `None` when nothing was measured;
    /// before the first piece, the first piece counts if `at_once`.
    #[must_use]
    pub fn diameter(&self, pushed: f64, at_once: bool) -> Option<f64> {
        let (first, last) = self.measured?;
        let place = self.place(pushed);
        if place < first && !at_once {
            return None;
        }
        let oldest = first.max(last - PIECES as i64 + 1);
        let piece = self.pieces[index(place.clamp(oldest, last))];
        (piece.diameter > 0.0).then_some(f64::from(piece.diameter))
    }

    /// Returns whether the piece that passes the sensor at the position `pushed` of the extruder, mm, has yet
    /// to come.
    #[must_use]
    pub fn is_to_come(&self, pushed: f64) -> bool {
        self.measured.is_some_and(|(_, last)| self.place(pushed) > last)
    }

    fn place(&self, pushed: f64) -> i64 {
        libm::floor(pushed / self.length) as i64
    }

    fn piece_mut(&mut self, place: i64) -> &mut Piece {
        &mut self.pieces[index(place)]
    }
}

const fn index(place: i64) -> usize {
    place.rem_euclid(PIECES as i64) as usize % PIECES
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Filament whose thickness changes along it.
    fn thickness(at: f64) -> f64 {
        1.75 + 0.1 * libm::sin(at / 30.0)
    }

    proptest! {
        #[test]
        fn a_piece_is_as_thick_at_the_nozzle_as_at_the_sensor(
            delay in 5.0..300.0_f64,
            ways in proptest::collection::vec(-3.0..6.0_f64, 1..400),
        ) {
            let mut line = DelayLine::new(delay);
            let (mut pushed, mut furthest) = (0.0_f64, 0.0_f64);
            for way in ways {
                // The range goes as far back as filament is drawn, and no further.
                let least = furthest - delay / 10.0;
                let to = (pushed + way).max(least.max(0.0));
                for step in 1..=10 {
                    let at = pushed + (to - pushed) * f64::from(step) / 10.0;
                    line.add(at, Some(thickness(at)));
                    furthest = furthest.max(at);
                    let was = at - delay;
                    match line.diameter(was, false) {
                        None => prop_assert!(was < 0.6 + delay / 50.0, "{was}"),
                        // Tolerance: the length of a piece, and the filament that passes between two looks.
                        Some(is) => prop_assert!((is - thickness(was)).abs() < 0.1 * (0.6 + delay / 50.0) / 30.0 + 1e-6),
                    }
                }
                pushed = to;
            }
        }
    }

    #[test]
    fn what_was_not_measured_is_not_known() {
        let mut line = DelayLine::new(50.0);
        assert_eq!(line.diameter(0.0, true), None);
        line.add(100.0, Some(1.7));
        assert_eq!((line.diameter(60.0, false), line.diameter(60.0, true)), (None, Some(f64::from(1.7_f32))));
        line.add(101.0, None);
        line.add(102.0, Some(1.8));
        assert!(line.diameter(100.2, false).is_some());
        assert_eq!(line.diameter(100.7, false), None, "a piece that nobody measured");
        assert!(line.diameter(101.6, false).is_some());
    }

    #[test]
    fn an_extruder_that_counts_anew_begins_anew() {
        let mut line = DelayLine::new(50.0);
        line.add(1_000.0, Some(1.7));
        line.add(0.0, Some(1.8));
        assert_eq!(line.diameter(0.1, false), Some(f64::from(1.8_f32)));
        assert_eq!(line.diameter(-20.0, false), None);
    }

    #[test]
    fn filament_long_gone_is_as_thick_as_the_oldest_that_is_known() {
        let mut line = DelayLine::new(50.0);
        assert_eq!(line.diameter(0.0, true), None);
        for step in 0..20_000 {
            let at = f64::from(step) * 0.1;
            line.add(at, Some(1.0 + at / 1_000.0));
        }
        let last = 2_000.0;
        let oldest = line.diameter(0.0, false).expect("the oldest");
        // As much is known as lies between sensor and nozzle, and not much more.
        let reach = last - (oldest - 1.0) * 1_000.0;
        assert!((50.0..200.0).contains(&reach), "{reach} mm");
        assert_eq!(line.diameter(last - reach - 100.0, false), Some(oldest));
        let newer = line.diameter(last - reach / 2.0, false).expect("a piece");
        assert!((newer - (1.0 + (last - reach / 2.0) / 1_000.0)).abs() < 0.01, "{newer}");
    }
}
