//! A single search for a person or a program: G30 down to the bed, G38 along a line.

use base::failure::{Answer, Failure, FailureKind, Outcome};
use base::reason::Alarm;
use program::{ProbeAlong, ProbeDown};
use units::Axis;

use super::search::{Search, check_homed, search};
use crate::leveling;
use crate::probing::ProbeHands;

/// G30: searches for the bed and returns to its start, or stays at the contact; then Z may read as given
/// there. Without a probe the code is unknown, as programs for printers expect.
pub fn probe_down<'c>(hands: &mut impl ProbeHands<'c>, probe: &ProbeDown) -> Outcome {
    if !hands.config().probe.enable {
        return Ok(Answer::Unknown);
    }
    check_homed(hands)?;
    let settings = hands.tuning().probe;
    let rate = probe.rate.unwrap_or(settings.slow_rate);
    hands.standstill()?;
    let start = hands.position();
    let upwards = settings.reverse_z != probe.reversed;
    let found = search(hands, &Search::down(start, rate, settings.max_travel.0, upwards))?;
    match found {
        Some(contact) if probe.stays => hands.go_there(contact, rate)?,
        None if probe.stays => {}
        _ => hands.go_there(start, settings.return_rate)?,
    }
    let Some(contact) = found else {
        if hands.is_playing() {
            // A file waits here, since its next lines count on the height.
            return Err(Failure::refused(&"ZProbe not triggered"));
        }
        hands.say(format_args!("ZProbe not triggered\n"));
        return Ok(Answer::Ok);
    };
    hands.say(format_args!("Z:{:.4}\n", start[Axis::Z] - contact[Axis::Z]));
    if let Some(reads) = probe.reads {
        hands.read_contact(contact[Axis::Z], reads);
    }
    Ok(Answer::Ok)
}

/// G38: searches along a line, and stands where the contact changed. A sender of GRBL's dialect has already
/// sent the line that sets a zero by it: if the search cannot begin, the machine halts, as GRBL's, and
/// refuses that line. A file waits.
pub fn probe_along<'c>(hands: &mut impl ProbeHands<'c>, probe: &ProbeAlong) -> Outcome {
    let done = search_along(hands, probe);
    let halts = hands.speaks_grbl() && !hands.is_playing();
    done.map_err(|why| match why.kind {
        FailureKind::Refused if halts => why.meaning(FailureKind::Alarm).with_alarm(Alarm::ProbeState),
        _ => why,
    })
}

/// Searches along the line. Without a probe the search is refused, for the next lines rely on its result.
fn search_along<'c>(hands: &mut impl ProbeHands<'c>, probe: &ProbeAlong) -> Outcome {
    if !hands.config().probe.enable {
        return Err(Failure::refused(&"no probe is configured: [zprobe] enable"));
    }
    check_homed(hands)?;
    let rate = probe.rate.unwrap_or(hands.tuning().probe.slow_rate);
    hands.standstill()?;
    // The tool goes straight, not along the bed's shape.
    let target = hands.motion(|motion| motion.compensation().motors(&probe.target));
    leveling::set_compensation_aside(hands)?;
    let found = search_and_return(hands, &Search { target, rate, until: probe.until });
    let put_back = leveling::put_compensation_back(hands);
    let found = found?;
    put_back?;
    let position = hands.position();
    let [x, y, z] = Axis::PRIMARY.map(|axis| position[axis]);
    hands.set_last_probe([x, y, z], found);
    hands.say(format_args!("[PRB:{x:.3},{y:.3},{z:.3}:{}]\n", u8::from(found)));
    if !found && probe.must_find {
        hands.halt(Alarm::ProbeMiss, format_args!("ALARM: Probe fail\n"));
        return Err(Failure::HALTED);
    }
    Ok(Answer::Ok)
}

/// Searches and goes back to the contact; returns whether it was found.
fn search_and_return<'c>(hands: &mut impl ProbeHands<'c>, line: &Search) -> Result<bool, Failure> {
    let Some(contact) = search(hands, line)? else { return Ok(false) };
    // Braking went a little past the contact.
    hands.go_there(contact, line.rate)?;
    Ok(true)
}
