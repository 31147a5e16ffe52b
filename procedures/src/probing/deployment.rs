//! Deployable probes, which are brought out before they touch and stowed afterwards: servo probes, and
//! magnetic probes that are fetched from a dock.
//!
//! Every search finds the probe deployed, or deploys it first and comes back to its start. A probe that a
//! search has deployed is stowed when the command has ended, well or not; after a halt nothing moves, and the
//! probe stays as it is until M402. A probe that M401 has deployed stays until M402, and so does a probe
//! after a search that ends at its contact (G38, G30 Z).

use base::failure::{Answer, Failure, FailureKind, Outcome};
use base::ports::Input;
use units::{Axis, PerAxis};

use super::deployment_state::Deployment;
use super::search::check_homed;
use crate::probing::ProbeHands;

/// Both settings, as messages name them.
const DEPLOY: &str = "deploy_gcode";
const STOW: &str = "stow_gcode";

/// Returns whether an input says that the probe is out; `None` without such an input.
fn sensed<'c>(hands: &mut impl ProbeHands<'c>) -> Option<bool> {
    let (probe, inputs) = (hands.config().probe, hands.inputs());
    let by_pin = probe.deployed_pin.map(|_| inputs.is_active(Input::ProbeDeployed));
    // The circuit is open while the probe hangs in its dock.
    let by_contact = probe.stowed_reads_triggered.then(|| !hands.tuning().probe_touches(inputs));
    by_pin.or(by_contact)
}

/// Returns whether the configuration has scripts that move the probe.
pub(super) fn is_moved<'c>(hands: &impl ProbeHands<'c>) -> bool {
    hands.config().probe_scripts.iter().any(|script| !script.is_empty())
}

fn is_deployed<'c>(hands: &mut impl ProbeHands<'c>) -> bool {
    sensed(hands).unwrap_or(matches!(hands.deployment(), Deployment::BySearch | Deployment::ByCommand))
}

/// Makes sure before a search that the probe is out, and the machine back at its place.
pub(super) fn ensure<'c>(hands: &mut impl ProbeHands<'c>) -> Result<(), Failure> {
    if is_deployed(hands) {
        return Ok(());
    }
    if !is_moved(hands) {
        return match sensed(hands) {
            Some(false) => Err(Failure::refused(&NOT_OUT)),
            _ => Ok(()),
        };
    }
    if *hands.deployment() == Deployment::Unknown {
        // An input, if there is one, says that the probe is not out.
        sensed(hands).ok_or_else(|| Failure::refused(&NOT_KNOWN))?;
    } else if *hands.deployment() != Deployment::Stowed {
        *hands.deployment() = Deployment::Stowed;
        return Err(Failure::refused(
            &"the probe was deployed and is not any more: has it come off? M401 deploys it again",
        ));
    }
    let here = hands.position();
    deploy(hands, Deployment::BySearch)?;
    come_back(hands, here)
}

const NOT_KNOWN: &str = "whether the probe is out is not known: look at it, then M401 or M402";
const NOT_OUT: &str = "the probe is not deployed: look at it, and at deployed_pin; nothing was probed";

/// Runs a script that moves the probe. If it ends too early, the probe may be anywhere.
fn run_script<'c>(hands: &mut impl ProbeHands<'c>, key: &str, script: &str) -> Result<(), Failure> {
    let ran = hands.run_probe_script(key, script);
    if ran.is_err() {
        *hands.deployment() = Deployment::Unknown;
        hands.announce(format_args!(
            "// NOTE {key} has not come to its end: look whether the probe is out; M402 stows it\n"
        ));
    }
    ran
}

fn deploy<'c>(hands: &mut impl ProbeHands<'c>, by: Deployment) -> Result<(), Failure> {
    let [script, _] = &hands.config().probe_scripts;
    run_script(hands, DEPLOY, script)?;
    if sensed(hands) == Some(false) {
        return Err(Failure::refused(&NOT_OUT));
    }
    *hands.deployment() = by;
    Ok(())
}

/// Goes back to a place: high first, and down last.
fn come_back<'c>(hands: &mut impl ProbeHands<'c>, place: PerAxis<f64>) -> Result<(), Failure> {
    let rate = hands.tuning().probe.fast_rate;
    let mut over = hands.position();
    if place == over {
        return Ok(());
    }
    if place[Axis::Z] > over[Axis::Z] {
        over[Axis::Z] = place[Axis::Z];
        hands.go(over, rate, motion::Mode::Rapid)?;
    }
    let high = over[Axis::Z];
    over = place;
    over[Axis::Z] = high;
    hands.go(over, rate, motion::Mode::Rapid)?;
    hands.go_there(place, rate)
}

fn stow<'c>(hands: &mut impl ProbeHands<'c>) -> Result<(), Failure> {
    let [_, script] = &hands.config().probe_scripts;
    run_script(hands, STOW, script)?;
    if sensed(hands) == Some(true) {
        return Err(Failure::refused(&"the probe is still deployed: look at it, and at stow_gcode; M402 tries again"));
    }
    *hands.deployment() = Deployment::Stowed;
    Ok(())
}

/// Leaves a probe out that a search has deployed: after a halt nothing moves, and a program that searched
/// along a line counts on the end of that search.
pub fn leave_out<'c>(hands: &mut impl ProbeHands<'c>) {
    if *hands.deployment() == Deployment::BySearch {
        *hands.deployment() = Deployment::ByCommand;
        hands.announce(format_args!("// NOTE the probe is still deployed: M402 stows it\n"));
    }
}

/// Stows a probe that a search has deployed, after its command has ended with `ended`; after a halt the probe
/// stays.
pub fn stow_after<'c>(hands: &mut impl ProbeHands<'c>, ended: Outcome) -> Outcome {
    if *hands.deployment() != Deployment::BySearch {
        return ended;
    }
    if matches!(ended, Err(Failure::HALTED | Failure { kind: FailureKind::Alarm, .. })) || hands.standstill().is_err() {
        leave_out(hands);
        return ended;
    }
    let stowed = stow(hands);
    if stowed.is_err_and(|failure| failure.is_refusal()) && *hands.deployment() != Deployment::Unknown {
        *hands.deployment() = Deployment::ByCommand;
    }
    let answer = ended?;
    stowed.map(|()| answer)
}

/// M401 deploys the probe, M402 stows it, whatever its state is believed to be.
pub fn deploy_or_stow<'c>(hands: &mut impl ProbeHands<'c>, deploys: bool) -> Outcome {
    if !hands.config().probe.enable || !is_moved(hands) {
        // Hosts send M401 and M402 to every printer.
        return Ok(Answer::PassedOver);
    }
    check_homed(hands)?;
    hands.standstill()?;
    if !deploys {
        return stow(hands).map(|()| Answer::Ok);
    }
    if sensed(hands) == Some(true) {
        *hands.deployment() = Deployment::ByCommand;
        hands.say(format_args!("the probe is deployed already\n"));
        return Ok(Answer::Ok);
    }
    deploy(hands, Deployment::ByCommand).map(|()| Answer::Ok)
}
