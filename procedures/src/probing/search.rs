//! A search along a straight line that ends where the probe's contact changes.

use base::failure::Failure;
use base::ports::Input;
use base::reason::Reason;
use base::safety::Event;
use motion::Mode;
use program::Contact;
use units::{Axis, Micros, MmPerSecond, PerAxis};

use super::deployment;
use crate::homing::wait_trigger;
use crate::probing::ProbeHands;

/// Number of searches that a contact which does not last may cut short; then the wiring is to blame.
const RETRIES: u8 = 3;

/// Message for a deployable probe that reads closed before it searches.
const TOO_EARLY: &str =
    "the probe reads triggered before it touches: is it out, is its wire whole? M670 I or ! at probe_pin inverts it";

/// A search along a straight line from the machine's position.
#[derive(Clone, Copy, Debug)]
pub(super) struct Search {
    /// End of the search without a contact, in machine space.
    pub target: PerAxis<f64>,
    /// Speed of the search.
    pub rate: MmPerSecond,
    /// Change of the contact that ends the search.
    pub until: Contact,
}

impl Search {
    /// Creates a search straight down from here (up, with `upwards`), mm.
    pub fn down(from: PerAxis<f64>, rate: MmPerSecond, travel: f64, upwards: bool) -> Self {
        let mut target = from;
        target[Axis::Z] += if upwards { travel } else { -travel };
        Self { target, rate, until: Contact::Closes }
    }
}

/// Returns the input that fires at this change.
const fn input_of(until: Contact, inverted: bool) -> Input {
    match (until, inverted) {
        (Contact::Closes, false) | (Contact::Opens, true) => Input::Probe,
        _ => Input::ProbeOpen,
    }
}

/// Returns whether the contact is already as the search would leave it.
fn is_at_end<'c>(hands: &mut impl ProbeHands<'c>, until: Contact) -> bool {
    let inputs = hands.inputs();
    hands.tuning().probe_touches(inputs) == (until == Contact::Closes)
}

/// Checks that the axes are homed: probing moves, so it needs the same as moves.
pub fn check_homed<'c>(hands: &impl ProbeHands<'c>) -> Result<(), Failure> {
    if hands.config().motion.must_be_homed && !hands.all_homed() {
        return Err(Failure::alarm(&"Must be homed before moving"));
    }
    Ok(())
}

/// Searches. Returns the exact position at which the contact changed, while the machine stands a braking
/// distance past it; or `None` when it did not change on the way, and the machine stands at the target.
pub(super) fn search<'c>(hands: &mut impl ProbeHands<'c>, search: &Search) -> Result<Option<PerAxis<f64>>, Failure> {
    hands.standstill()?;
    if search.until == Contact::Closes {
        // A contact that is to open touches already, so its probe is deployed.
        deployment::ensure(hands)?;
    }
    hands.apply(Event::ProbingBegins);
    let found = search_at_standstill(hands, search);
    // Ending in a hold would leave the operator to resume a search that is over. An alarm waits for nobody.
    let held = match &found {
        Err(failure) if !failure.is_refusal() => Ok(()),
        _ => hands.wait_while_held(),
    };
    hands.apply(Event::ProbingEnds);
    held.and(found)
}

fn search_at_standstill<'c>(hands: &mut impl ProbeHands<'c>, search: &Search) -> Result<Option<PerAxis<f64>>, Failure> {
    let dwell = hands.tuning().probe.dwell;
    hands.wait_for(dwell)?;
    if is_at_end(hands, search.until) {
        // Without a deployable probe the message is Smoothieware's.
        let is_moved = search.until == Contact::Closes && deployment::is_moved(hands);
        let text = if is_moved { TOO_EARLY } else { "ZProbe triggered before move, aborting command." };
        return Err(hands.texts().because(text).with_reason(Reason::Target));
    }
    // Filters would delay the stop at the contact.
    hands.motion(|motion| motion.bypass_filters(true));
    hands.search_begins();
    let found = search_past_sparks(hands, search);
    hands.search_ends();
    hands.motion(|motion| motion.bypass_filters(false));
    let found = found?;
    hands.standstill()?;
    Ok(found)
}

/// Searches again while the contact does not last.
fn search_past_sparks<'c>(hands: &mut impl ProbeHands<'c>, search: &Search) -> Result<Option<PerAxis<f64>>, Failure> {
    let debounce = hands.tuning().probe.debounce;
    // The move is a rapid, with which a laser stays off; the override is undone, since it is for cutting.
    let rate = search.rate * (1.0 / hands.motion(|motion| motion.overrides().rapid));
    for _ in 0..=RETRIES {
        // The feed reads armed inputs, so it finds a contact that changes between the look before and this
        // store.
        let input = input_of(search.until, hands.tuning().probe_inverted);
        hands.latch().arm(input.bit());
        hands.go(search.target, rate, Mode::Rapid)?;
        let Some(trigger) = wait_trigger(hands)? else { return Ok(None) };
        // A contact may come while the operator holds the machine: the next move waits for the release.
        hands.wait_while_held()?;
        hands.wait_for(debounce)?;
        if debounce == Micros(0) || is_at_end(hands, search.until) {
            return Ok(Some(hands.motion(|motion| motion.position_of_steps(&trigger.steps))));
        }
    }
    Err(Failure::alarm(&"the probe fires but does not stay triggered: check its wiring"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::ports::InputLevels;
    use base::tuning::Tuning;

    #[test]
    fn an_inverted_contact_touches_while_its_input_is_open() {
        for (level, inverted) in [(false, false), (false, true), (true, false), (true, true)] {
            let inputs = if level { InputLevels::default().with(Input::Probe) } else { InputLevels::default() };
            let mut tuning = Tuning::default();
            tuning.probe_inverted = inverted;
            assert_eq!(tuning.probe_touches(inputs), level != inverted);
            // The latch fires on the input change that closes the contact.
            let fires = input_of(Contact::Closes, inverted);
            assert_eq!(fires, if inverted { Input::ProbeOpen } else { Input::Probe });
            assert_ne!(fires, input_of(Contact::Opens, inverted));
        }
    }

    #[test]
    fn a_search_goes_down_or_up_by_its_travel_alone() {
        let here = PerAxis([1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
        let down = Search::down(here, MmPerSecond(5.0), 10.0, false);
        assert_eq!(down.target, PerAxis([1.0, 2.0, -7.0, 4.0, 5.0, 6.0]));
        assert_eq!(Search::down(here, MmPerSecond(5.0), 10.0, true).target[Axis::Z], 13.0);
    }
}
