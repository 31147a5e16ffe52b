//! Search for the stall threshold of drivers with stallGuard4, whose threshold shifts no reading: readings
//! are compared with it. So both ends are read at once: above the upper end a motor that runs free reports a
//! stall now and then; below the lower end a motor that stands reports none.

use base::failure::Failure;
use base::ports::StallSearch;
use units::Amps;

use super::readings::Readings;
use super::strokes::{self, Way};
use super::{CRAWL, Found, LEAST_MEAN, Speeds};
use crate::endstop_phase::PhaseHands;

/// With threshold 0 a reading is four times the threshold up to which the driver says stall: `SGTHRS` is half
/// of stallGuard4's reading, whose range is half that of the other drivers' readings.
const PER_THRESHOLD: f32 = 4.0;
/// Least and greatest value of the threshold (`SGTHRS`).
pub(super) const THRESHOLDS: [i16; 2] = [0, 255];

/// Finds the threshold for a current.
pub(super) fn find<'c>(
    hands: &mut impl PhaseHands<'c>,
    way: &Way,
    speeds: &Speeds,
    current: Option<Amps>,
) -> Result<Found, Failure> {
    let crawl = hands.config().load_speed(way.motor).0 * CRAWL;
    let readings = read(hands, way, crawl, current, 0, true)?;
    let stands = threshold(libm::ceilf(readings.most_likely() / PER_THRESHOLD));
    hands.say(format_args!(
        "// crawling at {crawl:.1} mm/s, where it induces next to nothing, it says stall from {stands} on\n"
    ));
    let (mut free, mut found) = (THRESHOLDS[1], None);
    for rate in speeds {
        let readings = read(hands, way, *rate, current, 0, false)?;
        free = free.min(threshold(readings.least_likely() / PER_THRESHOLD));
        let middle = stands.midpoint(free);
        let with = if middle > stands { Some(read(hands, way, *rate, current, middle, false)?) } else { None };
        let Some(readings) = with.filter(|readings| readings.are_free(LEAST_MEAN)) else {
            hands.say(format_args!("// at {rate:.0} mm/s it reads too little for any threshold\n"));
            break;
        };
        hands.say(format_args!(
            "// at {rate:.0} mm/s free up to {free}; with {middle} it reads {:.0}, noise {:.0}, least {}\n",
            readings.mean(),
            readings.noise(),
            readings.least()
        ));
        found = Some(Found { threshold: middle, free, stands, slowest: *rate, readings });
    }
    found.ok_or_else(|| {
        Failure::refused(&"no threshold tells a stall from running free: a higher speed, or less current, may")
    })
}

/// Returns the value as a whole threshold within the range of `SGTHRS`.
fn threshold(value: f32) -> i16 {
    // A float to integer cast saturates.
    (value as i16).clamp(THRESHOLDS[0], THRESHOLDS[1])
}

fn read<'c>(
    hands: &mut impl PhaseHands<'c>,
    way: &Way,
    rate: f64,
    current: Option<Amps>,
    threshold: i16,
    is_crawl: bool,
) -> Result<Readings, Failure> {
    strokes::set(hands, way.motor, StallSearch { current, threshold })?;
    strokes::there_and_back(hands, way, rate, is_crawl)
}
