//! Words that the image sends to the driver chips.

use std::fmt::Write as _;

use sim::models::tmc26x::Chip;
use units::Actuator;

use super::table::{self, Expected};
use super::{JOB, play};
use crate::common::velvet::{Plan, SECOND};

/// Boots, plays the job, and changes a current. Asserts that every chip has been sent the table's words, in
/// its order, and no others.
#[track_caller]
pub fn assert_sent(plan: Plan, chip: Chip, table: &str) {
    let job = JOB.replace(" B2", "");
    let mut velvet = plan.with_drivers(chip).file("job.g", &job).start();
    velvet.hear(2 * SECOND);
    play(&mut velvet);
    let mut found = String::new();
    for motor in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma, Actuator::Delta] {
        for (index, word) in velvet.world(|world| world.driver(motor as usize).words().to_vec()).iter().enumerate() {
            // Writing to a String cannot fail.
            let _ = writeln!(found, "{}.{index} = {word:#07x}", motor.name());
        }
    }
    let mut expected = String::new();
    for row in table::parse(table) {
        let Expected::Value { value, .. } = row.ready else { panic!("{}: a word is not live", row.name) };
        let _ = writeln!(expected, "{} = {value:#07x}", row.name);
    }
    assert!(found == expected, "the chips were sent\n{found}");
}
