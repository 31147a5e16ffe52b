//! G34: turns the motors of Z alone until the bed, or the gantry, is parallel to the other.
//!
//! The bed is touched at some points, from which its height over the motors follows. The first motor stays,
//! so Z reads there as before; the others go to where the bed is as high over them as over the first. The
//! remaining error is measured again, until no motor is off by more than the tolerance.

use base::failure::{Answer, Failure, Outcome};
use config::ZAlignment;
use heapless::Vec;
use program::Words;
use units::{Actuator, MmPerSecond};

use super::fit::{Bed, Shape};
use super::single_motors::{move_slaves, slaves_of};
use super::words::Corner;
use crate::leveling;
use crate::probing::ProbeHands;
use crate::probing::{check_homed, touch_places};

/// Motors turn alone at this speed at most.
const RATE: MmPerSecond = MmPerSecond(5.0);

/// A round that leaves more than this share of the error that it found did not do what it should.
const LEAST_GAIN: f64 = 0.7;
/// Below this many tolerances, an error that remains may be the probe's noise.
const NOISE: f64 = 4.0;

/// G34: I is the number of further rounds, T the tolerance.
pub fn align<'c>(hands: &mut impl ProbeHands<'c>, words: &Words<'_>) -> Outcome {
    let config = hands.config();
    if config.z_alignment.motors.is_empty() || !config.probe.enable {
        return Err(Failure::refused(
            &"G34 needs to know where the Z motors are: write motors and points in [z alignment]",
        ));
    }
    let mut settings = config.z_alignment.clone();
    if let Some(rounds) = words.get('I') {
        settings.retries = rounds as u8;
    }
    if let Some(mm) = words.as_length('T') {
        settings.tolerance.0 = mm;
    }
    hands.standstill()?;
    check_homed(hands)?;
    if !hands.all_homed() {
        return Err(Failure::refused(&"G34 touches the bed at places of the machine: home it first"));
    }
    // The compensation in force was measured on a bed that is about to move.
    leveling::take_off(hands)?;
    let slaves = slaves_of(config, Actuator::Gamma);
    rounds(hands, &settings, &slaves)?;
    Ok(Answer::Ok)
}

/// Errors of the slaves, mm: the distance by which each must be moved up.
type Offsets = Vec<f64, 3>;

fn rounds<'c>(hands: &mut impl ProbeHands<'c>, settings: &ZAlignment, slaves: &[Actuator]) -> Result<(), Failure> {
    let mut before = f64::INFINITY;
    let mut moved: Offsets = slaves.iter().map(|_| 0.0).collect();
    for round in 0..=settings.retries {
        let offsets = measure(hands, settings, slaves)?;
        let worst = offsets.iter().copied().map(libm::fabs).fold(0.0, f64::max);
        if worst <= settings.tolerance.0 {
            let text = "they are aligned. Z may touch the bed elsewhere now: home Z, or level, before a job";
            hands.axes().mark_aligned();
            hands.say(format_args!("Z motors: none is off by more than {worst:.4} mm, {text}\n"));
            return Ok(());
        }
        let is_noise = worst <= NOISE * settings.tolerance.0;
        if worst > LEAST_GAIN * before && !is_noise {
            let back: Offsets = moved.iter().map(|distance| -distance).collect();
            move_slaves(hands, slaves, &back, RATE)?;
            hands.say(format_args!(
                "Moving the motors does not mend it: {before:.3} mm before, {worst:.3} mm after. They stand as before.\n\
                 Does [z alignment] motors name gamma's place first and then the slaves', and do all turn the same way?\n"
            ));
            return Err(Failure::refused(&"the Z motors do not bring the bed level: check their order and direction"));
        }
        if worst > settings.max_adjust.0 {
            hands.say(format_args!("Turn that motor by hand first, or check motors and points in [z alignment]\n"));
            let most = settings.max_adjust.0;
            let text = format_args!("a Z motor is off by {worst:.3} mm, max_adjust is {most}: none was moved");
            return Err(hands.texts().refused(text));
        }
        if round == settings.retries {
            before = worst;
            break;
        }
        move_slaves(hands, slaves, &offsets, RATE)?;
        moved.iter_mut().zip(&offsets).for_each(|(sum, offset)| *sum += offset);
        before = worst;
    }
    hands.say(format_args!(
        "Repeat it with more rounds (I) or a greater tolerance (T); M48 says what the probe can do\n"
    ));
    let text = format_args!("a Z motor is still off by {before:.4} mm, tolerance {}", settings.tolerance.0);
    Err(hands.texts().refused(text))
}

/// Touches the points and returns each motor's height error relative to the first motor.
fn measure<'c>(
    hands: &mut impl ProbeHands<'c>,
    settings: &ZAlignment,
    slaves: &[Actuator],
) -> Result<Offsets, Failure> {
    let touches = touch_places(hands, &settings.points, settings.initial_height.0)?;
    let shape = Shape::of(settings.motors.len(), settings.twist);
    let bed = Bed::through(&touches, &settings.motors, shape)
        .ok_or_else(|| Failure::refused(&"these points do not tell how the motors stand: see [z alignment] points"))?;
    let over_first = settings.motors.first().map_or(0.0, |first| bed.height(*first));
    let mut offsets = Offsets::new();
    for (slave, place) in slaves.iter().zip(settings.motors.iter().skip(1)) {
        let offset = bed.height(*place) - over_first;
        let corner = Corner::among(*place, &settings.motors);
        let (size, way) = (libm::fabs(offset), if offset > 0.0 { "low" } else { "high" });
        hands.say(format_args!("Z motor {} ({corner}): {size:.4} mm too {way}\n", slave.name()));
        // The capacity is that of the list of slaves.
        let _ = offsets.push(offset);
    }
    let rest = bed.rest(&touches);
    hands.say(format_args!("What no motor can mend: {rest:.4} mm at the worst point\n"));
    hands.drain();
    Ok(offsets)
}
