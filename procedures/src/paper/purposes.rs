//! Purposes of paper tests: their beginnings, and the changes that their results make.

use base::failure::Failure;
use units::{Axis, AxisSet};

use super::moves::{CLEAR, go_over, lift, unleveled};
use super::state::{Along, Purpose, Walk};
use crate::arms::homes_by_motor;
use crate::paper::PaperHands;
use crate::probing::touch_here;

impl Purpose {
    /// Begins the test with this number, and brings the tool to the paper's place.
    pub fn begin<'c>(hands: &mut impl PaperHands<'c>, number: f64) -> Result<Self, Failure> {
        match number as u8 {
            0 => begin_probe_offset(hands),
            1 if hands.config().homing_endstop(Axis::Z).is_none() => {
                Err(Failure::refused(&"Z has no switch to home with: [endstops] homing_direction"))
            }
            1 => Ok(Self::Endstop),
            2 => Ok(Self::Height),
            3 => Walk::begin(hands).map(Self::Screws),
            _ => Along::begin(hands).map(Self::Twist),
        }
    }

    /// Accepts the tool's height, at which the paper drags; returns the next purpose to try, if any.
    pub fn accept<'c>(self, hands: &mut impl PaperHands<'c>, turned: bool) -> Result<Option<Self>, Failure> {
        let here = hands.position();
        let (height, bare) = (here[Axis::Z], unleveled(hands, &here));
        match self {
            Self::ProbeOffset { contact } => set_probe_offset(hands, contact - bare),
            Self::Endstop => set_homing_position(hands, height)?,
            Self::Height => hands.say(format_args!("the paper drags at Z {height:.4} of the machine\n")),
            Self::Screws(walk) => return Ok(walk.next(hands, turned)?.map(Self::Screws)),
            Self::Twist(along) => return Ok(along.next(hands, bare)?.map(Self::Twist)),
        }
        Ok(None)
    }
}

/// Touches the bed under the probe, and brings the tool over the same place.
fn begin_probe_offset<'c>(hands: &mut impl PaperHands<'c>) -> Result<Purpose, Failure> {
    if !hands.config().probe.enable {
        return Err(Failure::refused(&"no probe is configured: [zprobe] enable"));
    }
    let contact = touch_here(hands)?;
    let [dx, dy, _] = hands.bed().probe_offsets;
    let place = [contact[Axis::X] + dx, contact[Axis::Y] + dy];
    let high = hands.position()[Axis::Z];
    let low = contact[Axis::Z] - hands.bed().probe_offsets[2] + CLEAR;
    go_over(hands, place, high, low)?;
    let [x, y] = place;
    hands.say(format_args!(
        "The probe's contact closed at X:{x:.4} Y:{y:.4}. The tool is over that place now, some {CLEAR} mm above the bed\n"
    ));
    // The probe and the tool touch the same place with the tool at different positions, where a mesh differs.
    Ok(Purpose::ProbeOffset { contact: unleveled(hands, &contact) })
}

fn set_probe_offset<'c>(hands: &mut impl PaperHands<'c>, offset: f64) {
    let [.., z] = &mut hands.bed().probe_offsets;
    let before = core::mem::replace(z, offset);
    hands.say(format_args!(
        "The probe's contact closes with the tool {offset:.4} mm over the bed ({before:.4} before). M500 saves it (M565 Z, \
         M851 Z-)\n"
    ));
}

/// Lowers the homing position of Z by its reading at the height that should read zero.
fn set_homing_position<'c>(hands: &mut impl PaperHands<'c>, reads: f64) -> Result<(), Failure> {
    let offset = hands.tuning().home_offset()[Axis::Z] - reads;
    if !offset.is_finite() {
        return Err(hands.texts().refused(format_args!("Z reads {reads}")));
    }
    lift(hands)?;
    hands.tuning().set_home_offset(Axis::Z, offset);
    let by_motor = homes_by_motor(hands.config());
    hands.axes().forget_homed(if by_motor { AxisSet::PRIMARY } else { AxisSet::of(Axis::Z) });
    hands.say(format_args!(
        "Z read {reads:.4} at the bed, and is zero there from the next homing on (M206 Z{offset:.4}). G28, then M500 saves it\n"
    ));
    Ok(())
}
