//! AXIS_TWIST_COMPENSATION_CALIBRATE: on a twisted rail of the carriage, the probe beside the tool rises and
//! falls against it from end to end. At some places along the axis the bed is touched by the probe and then
//! by paper; the difference, less its mean, is the twist.

use base::bed::Twist;
use base::failure::Failure;
use heapless::Vec;
use units::{Axis, PerAxis};

use super::moves::{CLEAR, go_over, lift, unleveled};
use super::state::Along;
use crate::paper::PaperHands;
use crate::probing::{nozzle_over, stow_after, touch_uncorrected};

/// Returns a place along the axis, mm.
fn place<'c>(hands: &impl PaperHands<'c>, index: usize) -> f64 {
    let twist = &hands.config().axis_twist;
    let share = index as f64 / f64::from(twist.samples.max(2) - 1);
    twist.start.0 + share * (twist.end.0 - twist.start.0)
}

impl Along {
    /// Begins with the first place along the axis.
    ///
    /// # Errors
    /// When the machine cannot go there.
    pub fn begin<'c>(hands: &mut impl PaperHands<'c>) -> Result<Self, Failure> {
        let config = hands.config();
        if !config.probe.enable {
            return Err(Failure::refused(&"no probe is configured: [zprobe] enable"));
        }
        if config.axis_twist.start == config.axis_twist.end {
            return Err(Failure::refused(
                &"where is the twist to be measured? [axis twist compensation] start, end and line",
            ));
        }
        Self { contact: 0.0, offsets: Vec::new() }.go(hands)
    }

    /// Goes to the next place: touches there, and brings the tool over it.
    fn go<'c>(mut self, hands: &mut impl PaperHands<'c>) -> Result<Self, Failure> {
        let config = hands.config();
        let (along, line) = (place(hands, self.offsets.len()), config.axis_twist.line.0);
        let place = if config.axis_twist.along_y { [line, along] } else { [along, line] };
        let (bed, high) = (*hands.bed(), config.axis_twist.initial_height.0);
        let touched = touch_uncorrected(hands, nozzle_over(&bed, place), high);
        if touched.is_ok() {
            // The tool is lifted, since scripts must not begin at the bed.
            lift(hands)?;
        }
        let ended = touched.as_ref().map(|_| base::failure::Answer::Ok).map_err(Clone::clone);
        stow_after(hands, ended)?;
        let contact: PerAxis<f64> = touched?;
        self.contact = unleveled(hands, &contact);
        go_over(hands, place, high, contact[Axis::Z] - bed.probe_offsets[2] + CLEAR)?;
        let (number, count, letter) =
            (self.offsets.len() + 1, config.axis_twist.samples, if config.axis_twist.along_y { 'Y' } else { 'X' });
        hands.say(format_args!("Place {number} of {count}: {letter}{along:.2}\n"));
        Ok(self)
    }

    /// Takes the height found, mm, and goes on to the next place; `None` after the last one.
    ///
    /// # Errors
    /// When the machine cannot go there.
    pub fn next<'c>(mut self, hands: &mut impl PaperHands<'c>, height: f64) -> Result<Option<Self>, Failure> {
        // The list holds every sample, since the schema bounds their number.
        let _ = self.offsets.push(self.contact - height);
        if self.offsets.len() < usize::from(hands.config().axis_twist.samples) {
            return self.go(hands).map(Some);
        }
        let mean = self.offsets.iter().sum::<f64>() / self.offsets.len() as f64;
        let mut twist = Twist::along(hands.config().axis_twist.along_y);
        for (index, offset) in self.offsets.iter().enumerate() {
            let (at, off) = (place(hands, index), offset - mean);
            twist.push([at, off]);
            hands.say(format_args!("{}{at:.2}: the probe reads {off:+.4} mm\n", if twist.along_y { 'Y' } else { 'X' }));
        }
        let offs = || twist.points().iter().map(|point| point[1]);
        let range = offs().fold(f64::MIN, f64::max) - offs().fold(f64::MAX, f64::min);
        hands.bed().twist = twist;
        hands.say(format_args!(
            "The axis twists the probe by {range:.4} mm from end to end. It is taken off what is probed. M500 saves it\n"
        ));
        Ok(None)
    }
}
