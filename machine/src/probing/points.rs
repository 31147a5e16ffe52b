//! Probing the bed at one place after another: over to it, down, and up again.

use config::ProbeConfig;
use units::{Axis, PerAxis};

use super::search::{Search, search};
use crate::bed::Bed;
use crate::executor::Hands;
use crate::failure::{Failure, message};
use crate::ports::Ports;

/// The way to the bed: -1, or 1 for a probe that searches upwards.
const fn towards_bed(probe: &ProbeConfig) -> f64 {
    if probe.reverse_z { 1.0 } else { -1.0 }
}

/// The height `probe_height` away from a contact.
pub(super) fn clear_of(probe: &ProbeConfig, contact: f64) -> f64 {
    contact - towards_bed(probe) * probe.height.0
}

/// Where the nozzle is while the probe is over this place.
pub(super) fn nozzle_over(bed: &Bed, [x, y]: [f64; 2]) -> [f64; 2] {
    let [dx, dy, _] = bed.probe_offsets;
    [x - dx, y - dy]
}

/// Where the probe is while the nozzle is here.
pub(super) fn probe_at(bed: &Bed, nozzle: &PerAxis<f64>) -> [f64; 2] {
    let [dx, dy, _] = bed.probe_offsets;
    [nozzle[Axis::X] + dx, nozzle[Axis::Y] + dy]
}

/// Finds the bed with the nozzle at X and Y, coming from this height. Stands `probe_height` away from it
/// afterwards.
pub(super) async fn find_bed<P: Ports>(
    hands: &mut Hands<'_, '_, P>,
    at: [f64; 2],
    from: f64,
) -> Result<PerAxis<f64>, Failure> {
    let probe = hands.tuning().probe;
    let mut over = hands.position();
    over[Axis::Z] = from;
    hands.go_there(over, probe.fast_rate).await?;
    let contact = touch(hands, at, from).await?;
    lift(hands, clear_of(&probe, contact[Axis::Z])).await?;
    Ok(contact)
}

/// Probes the bed with the nozzle at X and Y, travelling there and back up at this height.
pub(super) async fn probe_point<P: Ports>(
    hands: &mut Hands<'_, '_, P>,
    at: [f64; 2],
    height: f64,
) -> Result<PerAxis<f64>, Failure> {
    let contact = touch(hands, at, height).await?;
    lift(hands, height).await?;
    Ok(contact)
}

async fn touch<P: Ports>(hands: &mut Hands<'_, '_, P>, [x, y]: [f64; 2], height: f64) -> Result<PerAxis<f64>, Failure> {
    let probe = hands.tuning().probe;
    let mut over = hands.position();
    (over[Axis::X], over[Axis::Y], over[Axis::Z]) = (x, y, height);
    hands.go_there(over, probe.fast_rate).await?;
    let down = Search::down(hands.position(), probe.slow_rate, probe.max_travel.0, probe.reverse_z);
    let Some(contact) = search(hands, &down).await? else {
        lift(hands, height).await?;
        let text = format_args!("ZProbe not triggered at X{x:.3} Y{y:.3} on {} mm of way", probe.max_travel.0);
        return Err(Failure::Refused(message(text)));
    };
    Ok(contact)
}

async fn lift<P: Ports>(hands: &mut Hands<'_, '_, P>, height: f64) -> Result<(), Failure> {
    let mut target = hands.position();
    target[Axis::Z] = height;
    let rate = hands.tuning().probe.return_rate;
    hands.go_there(target, rate).await
}
