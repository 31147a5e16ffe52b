//! Power of a laser that is not what a file asks for.

use super::{Desk, Kind, places};

/// The sample printer with a laser whose full power is S1000, in place of its extruder.
fn laser() -> Desk {
    let laser = "[laser]\nenable = true\npwm_pin = PWM1_1\nmaximum_s_value = 1000\n\n[voltage monitor]";
    Desk::with(&[("[voltage monitor]", laser)])
}

/// Returns line, kind and text of each finding on this machine.
fn said(desk: &mut Desk, text: &str) -> Vec<(u32, Kind, String)> {
    let (found, totals) = desk.read(text);
    assert_eq!(totals.stops, 0, "{found:?}");
    found.into_iter().map(|finding| (finding.line, finding.kind, finding.what.as_str().to_owned())).collect()
}

#[test]
fn an_s_beyond_the_scale_is_told_once_with_what_it_becomes() {
    let text = "G28\nM3 S1200\nG0 X5\nG1 X10 F600\nG1 X20 S5000\n";
    let told = "S1200 is more than full power, which is S1000: it burns at full power".to_owned();
    assert_eq!(said(&mut laser(), text), [(4, Kind::Power, told)]);
    assert_eq!(said(&mut laser(), "G28\nM3 S1000\nG1 X10 F600\nM5\nG1 X5 S2000\n"), []);
}

#[test]
fn the_scale_is_that_of_the_file() {
    let text = "G28\nM452 R2000\nM4 S1200\nG1 X10 F600\nM452 R255\nG1 X20\n";
    let told = "S1200 is more than full power, which is S255: it burns at full power".to_owned();
    assert_eq!(said(&mut laser(), text), [(6, Kind::Power, told)]);
    assert!(said(&mut laser(), "G28\nM452\nM452 R255 L10\nM3 S255\nG1 X10 F600\n").is_empty());
}

#[test]
fn scales_that_the_machine_refuses_stop_the_job() {
    let (found, _) = laser().read("G28\nM452 R10 L20\n");
    assert_eq!(places(&found), [(2, Kind::Word)]);
}

#[test]
fn a_rapid_with_power_is_dark_and_that_is_told_once() {
    let told = "a rapid does not burn: S500 counts from the next G1 on".to_owned();
    let text = "G28\nG0 X1 S100\nM3 S0\nG0 X5 S0\nG0 X10 S500\nX20 S300\nG1 X30 F600\n";
    assert_eq!(said(&mut laser(), text), [(5, Kind::DarkRapid, told)]);
    assert_eq!(said(&mut laser(), "G28\nM3 S500\nG0 X10\nG1 X20 S300 F600\nM5\nG0 X5 S500\n"), []);
}

#[test]
fn outside_laser_mode_moves_do_not_burn() {
    let text = "G28\nM452 S0\nM3 S500\nG0 X5 S400\nG1 X10 F600\nG1 X20 S5000\nM452 S1\nG1 X10 S400\n";
    let told = "laser mode is off: moves do not burn, whatever S".to_owned();
    assert_eq!(said(&mut laser(), text), [(5, Kind::LaserMode, told)]);
}

#[test]
fn m3_needs_something_to_turn_on() {
    let text = "G28\nM3 S500\nG1 X10 F600\nG1 X20\nM5\n";
    let told = "M3 turns nothing on, and S500 is no power here".to_owned();
    assert_eq!(said(&mut Desk::new(), text), [(3, Kind::NothingBurns, told)]);
    let spindle = "[switch]\nspindle.enable = true\nspindle.output_pin = PI11\nspindle.output_type = digital\n\
                   spindle.input_on_command = M3\nspindle.input_off_command = M5\n\n[voltage monitor]";
    assert_eq!(said(&mut Desk::with(&[("[voltage monitor]", spindle)]), "G28\nM3 S50\nG1 X10 F600\nM5\n"), []);
    assert_eq!(said(&mut Desk::new(), "G28\nG1 X10 F600 S500\n"), []);
}

#[test]
fn another_file_is_told_anew() {
    let text = "G28\nM3 S1200\nG1 X10 F600\nG0 X5 S3\n";
    let mut desk = laser();
    let first = said(&mut desk, text);
    assert_eq!((first.len(), &said(&mut desk, text)), (2, &first));
}
