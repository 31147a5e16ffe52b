//! A carriage on its rail, moved by a motor.

/// Positions of one full step that a driver distinguishes.
const MICROPOSITIONS: f64 = 256.0;

/// Position between two hard stops. Steps are counted, so that no rounding adds up over a long job. A motor
/// that pushes against a stop slips: the travel is lost, and added up.
#[derive(Clone, Debug)]
pub struct Carriage {
    mm_per_full_step: f64,
    /// Position at a count of zero, millimetres.
    origin_mm: f64,
    /// 1/256 full steps taken.
    count: i64,
    /// Hard stops in millimetres; infinite for free rotation (extruders, rotary axes).
    limits_mm: [f64; 2],
    lost_mm: f64,
    /// Backlash between motor and carriage, and the part of it taken up in the forward direction: 1/256
    /// full steps.
    play: i64,
    taken_up: i64,
    /// Lowest and highest position since the carriage was last placed.
    reached_mm: [f64; 2],
}

impl Carriage {
    /// Makes a carriage standing at `position_mm` between `limits_mm`.
    #[must_use]
    pub const fn new(position_mm: f64, limits_mm: [f64; 2], mm_per_full_step: f64) -> Self {
        Self {
            mm_per_full_step,
            origin_mm: position_mm,
            count: 0,
            limits_mm,
            lost_mm: 0.0,
            play: 0,
            taken_up: 0,
            reached_mm: [position_mm; 2],
        }
    }

    /// Moves by this many 1/256 full steps, or up to the hard stop.
    pub fn turn(&mut self, micropositions: i64) {
        let taken_up = (self.taken_up + micropositions).clamp(0, self.play);
        let idle = taken_up - self.taken_up;
        self.taken_up = taken_up;
        self.count += micropositions - idle;
        let wanted = self.position_mm();
        let reached = wanted.clamp(self.limits_mm[0], self.limits_mm[1]);
        if reached != wanted {
            self.lost_mm += (wanted - reached).abs();
            self.origin_mm = reached - self.travelled_mm();
        }
        let [lowest, highest] = self.reached_mm;
        self.reached_mm = [lowest.min(reached), highest.max(reached)];
    }

    /// Returns the part of so many 1/256 full steps that the hard stops permit, play not counted.
    #[must_use]
    pub fn room(&self, micropositions: i64) -> i64 {
        let micropositions = micropositions as f64;
        let per_mm = MICROPOSITIONS / self.mm_per_full_step;
        let place = self.position_mm();
        // Standing past a stop by rounding gives no way back.
        let (down, up) = ((self.limits_mm[0] - place) * per_mm, (self.limits_mm[1] - place) * per_mm);
        let (down, up) = (down.ceil().min(0.0), up.floor().max(0.0));
        micropositions.clamp(down, up) as i64
    }

    /// Loses so many 1/256 full steps of travel, as a rotor does that falls out of its field.
    pub fn lose(&mut self, micropositions: i64) {
        self.lost_mm += micropositions.abs() as f64 * self.mm_per_full_step / MICROPOSITIONS;
    }

    /// Moves the hard stops, millimetres.
    pub const fn limit(&mut self, limits_mm: [f64; 2]) {
        self.limits_mm = limits_mm;
    }

    fn travelled_mm(&self) -> f64 {
        self.count as f64 * self.mm_per_full_step / MICROPOSITIONS
    }

    /// Returns the carriage's position, millimetres.
    #[must_use]
    pub fn position_mm(&self) -> f64 {
        self.origin_mm + self.travelled_mm()
    }

    /// Gives the carriage backlash, millimetres.
    pub fn loosen(&mut self, backlash_mm: f64) {
        self.play = (backlash_mm / self.mm_per_full_step * MICROPOSITIONS).round() as i64;
        self.taken_up = self.taken_up.min(self.play);
    }

    /// Puts the carriage somewhere by hand.
    pub fn place(&mut self, position_mm: f64) {
        self.origin_mm = position_mm - self.travelled_mm();
        self.reached_mm = [position_mm; 2];
    }

    /// Returns the lowest and highest position since the carriage was last placed, millimetres.
    #[must_use]
    pub const fn reached_mm(&self) -> [f64; 2] {
        self.reached_mm
    }

    /// Returns the commanded travel that the hard stops have swallowed, millimetres.
    #[must_use]
    pub const fn lost_mm(&self) -> f64 {
        self.lost_mm
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_million_steps_out_and_back_end_where_they_began() {
        let mut carriage = Carriage::new(30.0, [-1e9, 1e9], 0.2);
        (0..1_000_000).for_each(|_| carriage.turn(16));
        assert_eq!(carriage.position_mm(), 30.0 + 12_500.0);
        (0..1_000_000).for_each(|_| carriage.turn(-16));
        assert_eq!(carriage.position_mm(), 30.0);
    }

    #[test]
    fn a_hard_stop_swallows_travel_and_counts_it() {
        let mut carriage = Carriage::new(1.0, [0.0, 10.0], 0.256);
        carriage.turn(-1_500);
        assert_eq!((carriage.position_mm(), carriage.lost_mm()), (0.0, 0.5));
        carriage.turn(2_000);
        assert!((carriage.position_mm() - 2.0).abs() < 1e-12);
    }
}
