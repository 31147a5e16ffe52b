//! Codes M851.1 to M851.5 of a paper test.

use base::failure::{Answer, Failure, Outcome};
use program::Words;
use units::{Axis, AxisSet};

use super::heights_tried::{Step, Tried};
use super::moves::{go_to_height, lift};
use super::state::{Purpose, Test};
use crate::paper::PaperHands;

/// Longest step, mm: a longer one is a mistake.
const LONGEST_STEP: f64 = 20.0;

const HOW: &str = "TESTZ Z=-1, Z=-0.1, Z=- (halfway) or Z=+ move the tool: until a sheet of paper just drags. Then ACCEPT, or ABORT\n";

/// Runs M851.1 to M851.5.
pub fn paper_test<'c>(hands: &mut impl PaperHands<'c>, words: &Words<'_>) -> Outcome {
    hands.standstill()?;
    if hands.paper().test.is_some() && !hands.all_homed() {
        hands.paper().end();
        return Err(Failure::refused(
            &"the paper test has ended, for the machine does not know any more where it is: home it",
        ));
    }
    match words.code().subcode {
        1 => begin(hands, words.get('P').unwrap_or(0.0)),
        2 => step(hands, words),
        3 => accept(hands, false),
        5 => accept(hands, true),
        _ => give_up(hands),
    }
}

fn begin<'c>(hands: &mut impl PaperHands<'c>, number: f64) -> Outcome {
    if hands.paper().test.is_some() {
        return Err(Failure::refused(&"a paper test is under way: ACCEPT (M851.3) or ABORT (M851.4) it first"));
    }
    if !hands.all_homed() {
        return Err(Failure::refused(&"a paper test needs a machine that knows where it is: home it first"));
    }
    let purpose = Purpose::begin(hands, number)?;
    await_paper(hands, purpose);
    hands.say(format_args!("{HOW}"));
    Ok(Answer::Ok)
}

/// Waits for the paper to be tried, with the tool at its place.
fn await_paper<'c>(hands: &mut impl PaperHands<'c>, purpose: Purpose) {
    hands.paper().test = Some(Test { purpose, tried: Tried::default() });
}

const NONE: &str =
    "no paper test is under way: PROBE_CALIBRATE, Z_ENDSTOP_CALIBRATE, MANUAL_PROBE and BED_SCREWS_ADJUST begin one";

/// Moves the tool: `M851.2 Z-0.1`, or S: -1 halfway to the next height tried below, -2 to it; 1 and 2
/// upwards.
fn step<'c>(hands: &mut impl PaperHands<'c>, words: &Words<'_>) -> Outcome {
    let here = hands.position()[Axis::Z];
    let step = match (words.as_length('Z'), words.get('S')) {
        (Some(mm), None) => Step::By(mm),
        (None, Some(share)) => {
            let up = share > 0.0;
            if libm::fabs(share) > 1.5 { Step::Whole { up } } else { Step::Halfway { up } }
        }
        _ => return Err(Failure::refused(&"M851.2 needs Z, by how much, or S: 1 or -1 halfway, 2 or -2 all the way")),
    };
    let Some(test) = &mut hands.paper().test else { return Err(Failure::refused(&NONE)) };
    test.tried.note(here);
    let next = test.tried.next(here, step);
    if libm::fabs(next - here) > LONGEST_STEP {
        return Err(hands.texts().refused(format_args!("a step of a paper test is {LONGEST_STEP} mm at most")));
    }
    go_to_height(hands, next)?;
    if let Some(test) = &hands.paper().test {
        let shown = test.tried.shown(next);
        hands.say(format_args!("Z: {shown}\n"));
    }
    Ok(Answer::Ok)
}

fn accept<'c>(hands: &mut impl PaperHands<'c>, turned: bool) -> Outcome {
    let Some(test) = &hands.paper().test else { return Err(Failure::refused(&NONE)) };
    let purpose = test.purpose.clone();
    if turned && !matches!(purpose, Purpose::Screws(_)) {
        return Err(Failure::refused(&"ADJUSTED says that a screw was turned: ACCEPT here"));
    }
    // A halt on the way ends the test by itself; nothing has been changed then.
    match purpose.accept(hands, turned) {
        Ok(Some(next)) => await_paper(hands, next),
        Ok(None) => {
            hands.paper().end();
            if hands.axes().homed().has_all(AxisSet::PRIMARY) {
                lift(hands)?;
            }
        }
        Err(failure) => {
            // The tool is not at the paper any more: another ACCEPT would use its height.
            if hands.paper().end() {
                hands.say(format_args!("the paper test has ended, nothing was changed\n"));
            }
            return Err(failure);
        }
    }
    Ok(Answer::Ok)
}

fn give_up<'c>(hands: &mut impl PaperHands<'c>) -> Outcome {
    if !hands.paper().end() {
        return Err(Failure::refused(&NONE));
    }
    lift(hands)?;
    hands.say(format_args!("the paper test has ended, nothing was changed\n"));
    Ok(Answer::Ok)
}
