//! Settings and spellings that occur in Smoothieware v2's configuration files only.

mod common;

use common::{Findings, SAMPLE, edited, read};
use config::{BoardId, Severity};

/// The sample and some lines more.
fn with(lines: &str) -> (config::MachineConfig, Findings) {
    read(&format!("{SAMPLE}\n{lines}"))
}

/// Asserts that writing the number which the one finding gives ends the finding.
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
    // The current that the resistor can measure.
    followed(&edited("gamma.current = 1.2", "gamma.current = 7.5"), "gamma.current", "7.5");
}

#[test]
fn the_lines_of_buttons_keep_their_underscores() {
    let (config, findings) = with(
        "[button box]\nplay.pin = PJ1^!\nplay.press = play /sd/a_part.g\nplay.release = M117 a_b\n\
         play.long_press = M117 c_d\n",
    );
    assert!(findings.is_empty(), "{findings:#?}");
    let button = &config.buttons[0];
    assert_eq!(
        (button.press.as_str(), button.release.as_str(), button.long_press.as_str()),
        ("play /sd/a_part.g", "M117 a_b", "M117 c_d")
    );
}

#[test]
fn a_button_of_a_panel_is_no_mistake() {
    let (config, findings) = with("[button box]\nb2.pin = external\nb2.press = M117 b\n");
    let [finding] = findings.as_slice() else { panic!("{findings:#?}") };
    assert_eq!(finding.severity, Severity::Warning);
    assert!(finding.reason.contains("panels are not supported yet"), "{finding}");
    assert!(config.off.is_empty() && config.buttons[0].pin.is_none());
    // No other pin may be `external`.
    let key = "[switch]\nb2.enable = true\nb2.input_pin = external\nb2.output_on_command = M117\n";
    let (_, findings) = read(&SAMPLE.replace("[switch]\n", key));
    assert_eq!(findings.first().map(|finding| finding.severity), Some(Severity::Error), "{findings:#?}");
}

#[test]
fn heaters_without_a_number_have_smoothiewares() {
    let numbers = |text: &str| {
        let (config, _) = read(text);
        let number =
            |name: &str| config.temperatures.iter().find(|heater| heater.name == name).map(|one| one.tool_id.0);
        [number("aux"), number("chamber"), number("z2")]
    };
    let lines = |name: &str| format!("{name}.enable = true\n{name}.sensor = thermistor\n");
    let text = format!("[temperature control]\n{}{}{}", lines("z2"), lines("chamber"), lines("aux"));
    assert_eq!(numbers(&text), [Some(253), Some(252), Some(251)]);
    let text = format!("{text}z2.tool_id = 255\n{}", lines("board"));
    // Smoothieware has the board's number twice.
    assert_eq!(numbers(&text), [Some(252), Some(251), Some(250)]);
    let text = text.replace("chamber.enable = true", "chamber.enable = false");
    assert_eq!(numbers(&text), [Some(252), None, Some(251)]);
}

#[test]
fn an_input_pin_that_is_none_leaves_the_output() {
    let lines = "[switch]\nlamp.enable = true\nlamp.input_pin = nc\nlamp.input_on_command = M42\n\
                 lamp.input_off_command = M43\nlamp.output_pin = PJ1\nlamp.output_type = digital\n";
    let (config, findings) = read(&SAMPLE.replace("[switch]\n", lines));
    assert!(findings.is_empty(), "{findings:#?}");
    let lamp = config.switches.iter().find(|switch| switch.name == "lamp").unwrap();
    assert!(!lamp.is_input() && lamp.output_pin.is_some());
    let key = "[switch]\nkey.enable = true\nkey.input_pin = nc\nkey.output_on_command = M117\n";
    let (_, findings) = read(&SAMPLE.replace("[switch]\n", key));
    let [finding] = findings.as_slice() else { panic!("one finding: {findings:#?}") };
    assert!(finding.reason.contains("the input has no pin"), "{finding}");
}

#[test]
fn a_motor_without_current_starts_with_the_least() {
    let text = SAMPLE
        .lines()
        .map(|line| if line.starts_with("alpha.current") { "alpha.current = 0" } else { line })
        .fold(String::new(), |text, line| text + line + "\n");
    let (config, summary) = config::parse(text.as_bytes(), BoardId::Prime2590, &mut ());
    assert!(summary.is_usable() && summary.is_complete(), "{summary:?}");
    assert!(config.actuators[units::Actuator::Alpha].current.is_none());
    let (_, findings) = read(&text);
    let [finding] = findings.as_slice() else { panic!("{findings:#?}") };
    assert!(finding.reason.contains("the least its driver can give"), "{finding}");
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
