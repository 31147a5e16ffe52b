//! What configurations of Smoothieware v2 have and no other file of Velvet does.

mod common;

use common::{Findings, SAMPLE, edited, read};
use config::Severity;

/// The sample and some lines more.
fn with(lines: &str) -> (config::MachineConfig, Findings) {
    read(&format!("{SAMPLE}\n{lines}"))
}

/// That writing the number which the one finding gives ends it.
fn followed(text: &str, setting: &str, written: &str) {
    let (_, findings) = read(text);
    let [finding] = findings.as_slice() else { panic!("{setting}: {findings:#?}") };
    let number = finding.fix.split(' ').nth(1).unwrap();
    let mended = text.replace(&format!("{setting} = {written}"), &format!("{setting} = {number}"));
    assert_ne!(mended, text);
    let (_, findings) = read(&mended);
    assert!(findings.is_empty(), "{setting} = {number}: {findings:#?}");
}

#[test]
fn advice_that_is_followed_ends_the_finding() {
    // 200000 steps/s at 415 steps/mm are 28915.66 mm/min.
    followed(&edited("delta.max_rate = 3600", "delta.max_rate = 30000"), "delta.max_rate", "30000");
    // 935 mm/min are 15.583 mm/s, 1000 are 16.667.
    for rate in ["935", "1000", "700.8"] {
        let text = edited("gamma.max_rate = 900", &format!("gamma.max_rate = {rate}"));
        let text = text.replace("minz.fast_rate = 10", "minz.fast_rate = 30");
        followed(&text, "minz.fast_rate", "30");
    }
    // What the resistor can measure.
    followed(&edited("gamma.current = 1.2", "gamma.current = 7.5"), "gamma.current", "7.5");
}

/// Smoothieware's sample of a delta is for the board with the other drivers.
#[test]
fn a_file_for_the_other_board_is_told_how_to_check_it() {
    let text = SAMPLE.replace("[tmc2590]", "[tmc2660]").replace(".driver = tmc2590", ".reversed = false");
    let (_, findings) = read(&text);
    let finding = findings.iter().find(|finding| finding.key.ends_with("alpha.driver")).unwrap();
    assert!(finding.fix.contains("check with --board tmc2660"), "{finding}");
    assert!(finding.fix.contains("[tmc2590] alpha.sense_resistor"), "{finding}");
}

/// Smoothieware's sample of a button box has keys of a matrix, which nobody reads.
#[test]
fn another_name_is_no_slip() {
    let (_, findings) = with("[button box]\npad.pin = PJ1\npad.press = M117\npad.2_release = M117 up\n");
    let [finding] = findings.as_slice() else { panic!("{findings:#?}") };
    assert_eq!(finding.severity, Severity::Warning, "{finding}");
    assert!(!finding.fix.contains("did you mean"), "{finding}");
}
