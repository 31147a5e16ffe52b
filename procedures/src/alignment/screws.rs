//! G35: how far a person has to turn each screw of the bed.

use core::fmt;

use base::failure::{Answer, Failure, Outcome};
use config::Thread;

use super::words::Corner;
use crate::leveling;
use crate::probing::ProbeHands;
use crate::probing::{check_homed, touch_places};

/// A turn of a bed screw, as it is told to a person.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Turn {
    /// Forty-eighths of a turn: a twelfth of a quarter turn is the least that an eye can tell.
    forty_eighths: u32,
    clockwise: bool,
}

impl Turn {
    /// Returns the turn that raises the bed at the screw by this distance, mm; a negative one lowers the bed.
    fn raising(mm: f64, thread: Thread) -> Self {
        let turns = libm::fabs(mm) / thread.pitch;
        Self { forty_eighths: libm::round(48.0 * turns) as u32, clockwise: (mm > 0.0) == thread.clockwise_raises }
    }
}

/// `1 1/4 turns clockwise (01:15)`: whole turns and minutes of a clock face in brackets, as Klipper says
/// them.
impl fmt::Display for Turn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (whole, part) = (self.forty_eighths / 48, self.forty_eighths % 48);
        // The fraction is reduced to halves, quarters and so on down to forty-eighths.
        let (mut over, mut under) = (part, 48);
        for prime in [2, 2, 2, 2, 3] {
            if over % prime == 0 && under % prime == 0 {
                (over, under) = (over / prime, under / prime);
            }
        }
        match (whole, part) {
            (0, _) => write!(f, "{over}/{under} turn")?,
            (1, 0) => f.write_str("1 turn")?,
            (_, 0) => write!(f, "{whole} turns")?,
            (_, _) => write!(f, "{whole} {over}/{under} turns")?,
        }
        let minutes = (part * 60 + 24) / 48;
        let way = if self.clockwise { "clockwise" } else { "counterclockwise" };
        write!(f, " {way} ({whole:02}:{minutes:02})")
    }
}

/// G35: touches the bed over each screw and says how far it is to be turned for the bed to be as high there
/// as over the first one. Nothing is changed.
pub fn advise<'c>(hands: &mut impl ProbeHands<'c>) -> Outcome {
    let config = hands.config();
    let screws = &config.bed_screws;
    if screws.screws.is_empty() {
        return Err(Failure::refused(&"G35 needs to know where the screws are: write screws in [bed screws]"));
    }
    if !config.probe.enable {
        return Err(Failure::refused(&"G35 needs a probe: [zprobe] enable"));
    }
    hands.standstill()?;
    check_homed(hands)?;
    if !hands.all_homed() {
        return Err(Failure::refused(&"G35 touches the bed at places of the machine: home it first"));
    }
    // The screws level the bare bed, and the compensation in force was measured on the bed before the turn.
    leveling::take_off(hands)?;
    let touches = touch_places(hands, &screws.screws, screws.initial_height.0)?;
    let first = touches.first().map_or(0.0, |touch| touch[2]);
    let mut worst: f64 = 0.0;
    for (touch, place) in touches.iter().zip(&screws.screws).skip(1) {
        let low = first - touch[2];
        worst = worst.max(libm::fabs(low));
        let (corner, size) = (Corner::among(*place, &screws.screws), libm::fabs(low));
        let turn = Turn::raising(low, screws.thread);
        if size <= screws.tolerance.0 || turn.forty_eighths == 0 {
            hands.say(format_args!("The {corner} screw is right: {size:.4} mm off\n"));
        } else {
            let way = if low > 0.0 { "low" } else { "high" };
            hands.say(format_args!("Turn the {corner} screw {turn}: the bed is {size:.4} mm too {way} there\n"));
        }
        hands.drain();
    }
    let reference = Corner::among(screws.screws.first().copied().unwrap_or_default(), &screws.screws);
    if worst <= screws.tolerance.0 {
        hands.say(format_args!("The bed is level: no screw is off by more than {worst:.4} mm\n"));
    } else {
        hands.say(format_args!("Leave the {reference} screw, turn the others, then repeat G35\n"));
    }
    Ok(Answer::Ok)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const M3: Thread = Thread { pitch: 0.5, clockwise_raises: true };

    #[test]
    fn turns_are_told_as_a_person_makes_them() {
        for (mm, told) in [
            (0.125, "1/4 turn clockwise (00:15)"),
            (-0.125, "1/4 turn counterclockwise (00:15)"),
            (0.5, "1 turn clockwise (01:00)"),
            (-0.625, "1 1/4 turns counterclockwise (01:15)"),
            (1.0, "2 turns clockwise (02:00)"),
            (0.25 / 6.0, "1/12 turn clockwise (00:05)"),
            (0.5 / 48.0, "1/48 turn clockwise (00:01)"),
        ] {
            assert_eq!(Turn::raising(mm, M3).to_string(), told);
        }
        let other = Thread { clockwise_raises: false, ..M3 };
        assert_eq!(Turn::raising(0.125, other).to_string(), "1/4 turn counterclockwise (00:15)");
    }

    proptest! {
        #[test]
        fn the_turn_told_leaves_less_than_half_of_a_forty_eighth(mm in -3.0..3.0_f64, pitch in 0.3..1.5_f64) {
            let turn = Turn::raising(mm, Thread { pitch, clockwise_raises: true });
            let raised = f64::from(turn.forty_eighths) * pitch / 48.0 * if turn.clockwise { 1.0 } else { -1.0 };
            prop_assert!((raised - mm).abs() <= pitch / 96.0 + 1e-12);
        }
    }
}
