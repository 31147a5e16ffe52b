//! G28 and `$H`: homing, or what stands for it: a feature's way, or a line of the configuration. G28.3: the
//! machine is somewhere else than it believes.

use base::World;
use base::failure::{Answer, Outcome};
use base::hands::Hands as _;
use base::ports::MotionPort as _;
use base::sessions::Recipient;
use units::{Axis, AxisSet, PerAxis};

use crate::machine::frames::Then;
use crate::machine::suspend;
use crate::machine::work_hands::{JobHands, MoveHands};

/// Homes these axes, or all where none is named.
pub(crate) fn home<'c>(hands: &mut impl JobHands<'c>, named: AxisSet, to: Recipient) -> Outcome {
    if let Some(outcome) = hands.homes(named, to) {
        return outcome;
    }
    let homing = &hands.world().config.homing;
    let (script, of_z) = (homing.gcode.as_str(), homing.z_gcode.as_str());
    // Within the script G28 is homing itself.
    if named.is_empty() && !script.is_empty() && !hands.frames().run_script(script) {
        return suspend::start_script(hands.frames(), script, Then::Ended(Ok(())));
    }
    let z_is_asked_for = named.is_empty() || named.has(Axis::Z);
    let homes_z = z_is_asked_for && !of_z.is_empty() && !hands.frames().run_script(of_z);
    let others = if homes_z { named.without(AxisSet::of(Axis::Z)) } else { named };
    if named.is_empty() || !others.is_empty() {
        let homed = procedures::homing::home(&mut hands.sequence(to), others);
        hands.resynchronise_if_still();
        homed?;
    }
    if homes_z {
        return suspend::start_script(hands.frames(), of_z, Then::Ended(Ok(())));
    }
    Ok(Answer::Ok)
}

/// Takes these places for those where the machine is; `homed`: the axes count as homed.
pub(crate) fn set_position<'c>(hands: &mut impl MoveHands<'c>, to: &PerAxis<Option<f64>>, homed: bool) -> Outcome {
    hands.standstill()?;
    let mut position = hands.position();
    let named = units::AxisSet::collect(units::Axis::ALL.into_iter().filter(|axis| to[*axis].is_some()));
    named.axes().for_each(|axis| position[axis] = to[axis].unwrap_or(position[axis]));
    let World { ports, texts, .. } = hands.world();
    let set = ports.motion(|motion| motion.set_position(position));
    set.map_err(|refusal| texts.refused(format_args!("{refusal}")))?;
    if homed {
        hands.sequence(Recipient::Nobody).declare_homed(named);
    }
    hands.axes().stray(named);
    Ok(Answer::Ok)
}
