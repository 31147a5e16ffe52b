//! Pace of a live board: how much virtual time goes by in a second of the computer's.

use std::thread;
use std::time::{Duration, Instant};

use super::clock_file::{ClockFile, Traffic, Turn};

/// Rate of catching up, in multiples of the pace.
const CATCH_UP: f64 = 2.0;
/// Virtual time between two rounds where a program follows the time of the board: how long an answer takes
/// is a part of what it measures.
pub const FOLLOWED_SLICE: Duration = Duration::from_micros(500);
/// Time to the next look at the page where the board has to wait.
const ASK_AGAIN: Duration = Duration::from_micros(30);

/// Reads a pace from the command line.
///
/// # Errors
/// When it is not a number above zero.
pub fn parse(text: &str) -> Result<f64, String> {
    let rate: f64 = text.parse().map_err(|_| format!("{text}: not a number"))?;
    if rate.is_finite() && rate > 0.0 { Ok(rate) } else { Err(format!("{text}: the pace is above 0")) }
}

/// Tells after each slice of virtual time when the next one may begin. All instants are durations since the
/// board's power-on, by its clock and by the computer's.
#[derive(Debug)]
pub struct Pace {
    /// Virtual seconds for each of the computer's.
    rate: f64,
    /// Highest rate of catching up; without one a late board runs as fast as it can.
    most: Option<f64>,
    /// End of the last slice, by the board's clock.
    reached: Duration,
    /// Beginning of the slice that follows it, by the computer's.
    released: Duration,
}

impl Pace {
    /// Real time; what was lost is made up for at once. For a person, who waits for the board.
    pub const fn real_time() -> Self {
        Self { rate: 1.0, most: None, reached: Duration::ZERO, released: Duration::ZERO }
    }

    /// A steady share of real time: never faster on the mean, and at no time more than twice as fast. So a
    /// program that fits its own clock to the board's finds a rate that holds, however late the board is.
    pub const fn steady(rate: f64) -> Self {
        Self { rate, most: Some(CATCH_UP * rate), reached: Duration::ZERO, released: Duration::ZERO }
    }

    /// Returns when the next slice begins: with the board at `now`, and `elapsed` on the computer.
    pub fn next(&mut self, now: Duration, elapsed: Duration) -> Duration {
        let mean = now.div_f64(self.rate);
        let slice = now.saturating_sub(self.reached);
        let soonest = self.most.map_or(Duration::ZERO, |most| self.released + slice.div_f64(most));
        self.reached = now;
        self.released = elapsed.max(mean).max(soonest);
        self.released
    }
}

/// What decides when a live board goes on.
pub enum Timing {
    /// The computer's clock.
    Paced(Pace, Instant),
    /// A host program, in lock step.
    Locked(ClockFile),
}

impl Timing {
    /// Begins now, with the board at power-on.
    pub fn paced(pace: Pace) -> Self {
        Self::Paced(pace, Instant::now())
    }

    /// Whether the next slice may be run.
    ///
    /// # Errors
    /// When the page of the lock step cannot be read.
    pub fn may_go(&mut self, now_ns: u64, traffic: Traffic) -> Result<bool, String> {
        let Self::Locked(page) = self else { return Ok(true) };
        match page.turn(now_ns, traffic).map_err(|error| error.to_string())? {
            Turn::Go => Ok(true),
            Turn::Wait => Ok(false),
            Turn::Alone => {
                thread::sleep(FOLLOWED_SLICE);
                Ok(true)
            }
        }
    }

    /// Waits until the time after a slice, which has brought the board to this instant if it was run.
    ///
    /// # Errors
    /// When the page of the lock step cannot be written.
    pub fn rest(&mut self, now_ns: u64, has_run: bool) -> Result<(), String> {
        match self {
            Self::Paced(pace, began) => {
                let next = pace.next(Duration::from_nanos(now_ns), began.elapsed());
                thread::sleep(next.saturating_sub(began.elapsed()));
            }
            Self::Locked(page) if has_run => page.tell(now_ns).map_err(|error| error.to_string())?,
            Self::Locked(_) => thread::sleep(ASK_AGAIN),
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLICE: Duration = Duration::from_millis(1);

    /// Runs so many slices, each of which costs the computer this long. Returns the instants at which they
    /// have begun, by the computer's clock, and the board's time at the end.
    fn run(pace: &mut Pace, from: (Duration, Duration), slices: u32, cost: Duration) -> (Duration, Duration) {
        let (mut now, mut elapsed) = from;
        for _ in 0..slices {
            now += SLICE;
            elapsed = pace.next(now, elapsed + cost);
        }
        (now, elapsed)
    }

    fn millis((now, elapsed): (Duration, Duration)) -> (u128, u128) {
        (now.as_millis(), elapsed.as_millis())
    }

    #[test]
    fn an_idle_computer_keeps_the_pace() {
        let cost = Duration::from_micros(100);
        for (mut pace, took) in [(Pace::real_time(), 100), (Pace::steady(0.25), 400), (Pace::steady(2.0), 50)] {
            assert_eq!(millis(run(&mut pace, Default::default(), 100, cost)), (100, took));
        }
    }

    #[test]
    fn a_steady_board_catches_up_at_twice_its_pace_until_it_is_on_time() {
        let cost = Duration::from_micros(100);
        let mut pace = Pace::steady(0.25);
        let at = run(&mut pace, Default::default(), 10, cost);
        assert_eq!(millis(at), (10, 40));
        // The computer is busy elsewhere for 400 ms: 100 ms of the board's.
        let stood = (at.0, at.1 + Duration::from_millis(400));
        let at = run(&mut pace, stood, 1, cost);
        assert_eq!(millis(at), (11, 440));
        let at = run(&mut pace, at, 50, cost);
        assert_eq!(millis(at), (61, 540), "2 ms for each of the board's");
        // On time again after 200 slices of 2 ms less than usual each.
        let at = run(&mut pace, at, 200, cost);
        assert_eq!(millis(at), (261, 1044));
    }

    #[test]
    fn without_a_limit_lost_time_is_made_up_for_at_once() {
        let cost = Duration::from_micros(100);
        let mut pace = Pace::real_time();
        let at = run(&mut pace, (Duration::ZERO, Duration::from_millis(400)), 100, cost);
        assert_eq!(millis(at), (100, 410));
    }

    #[test]
    fn a_slow_computer_is_not_waited_for() {
        let mut pace = Pace::steady(0.25);
        assert_eq!(millis(run(&mut pace, Default::default(), 100, Duration::from_millis(5))), (100, 500));
    }

    #[test]
    fn a_pace_is_above_zero() {
        assert_eq!(parse("0.25"), Ok(0.25));
        for text in ["0", "-1", "inf", "NaN", "fast"] {
            assert!(parse(text).is_err(), "{text}");
        }
    }
}
