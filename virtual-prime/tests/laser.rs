//! The laser at its pins: duty and gate of a beam at rest, and how soon a halt forces both off.

use crate::common::MS;
use crate::common::machine::{changes, pin, watch};
use crate::common::velvet::{Plan, SECOND};
use crate::common::writes::Written;

/// TIM8 (RM0399 section 42.4, boundary addresses): mode of channels 1 and 2, enables and polarities, period,
/// compare value of channel 1.
const MODE: u64 = 0x4001_0418;
const ENABLES: u64 = 0x4001_0420;
const PERIOD: u64 = 0x4001_042C;
const COMPARE: u64 = 0x4001_0434;
/// OCxM in the mode register (RM0399 section 42.4.8), no buffered compare value.
const FORCED_INACTIVE: u64 = 0x40;
const PWM_MODE_1: u64 = 0x60;
const GATE: &str = "PD9";

fn plan(lines: &[&str]) -> Plan {
    let usual = ["enable = true", "pwm_pin = PWM2_1", "ttl_pin = PD9", "maximum_s_value = 1000"];
    let plan = usual.iter().chain(lines).fold(Plan::new(), |plan, line| plan.set(&format!("[laser] {line}")));
    [MODE, ENABLES, PERIOD, COMPARE].into_iter().fold(plan, |plan, register| plan.watching(register..register + 4))
}

/// Returns the last value written to a register since the last call, and when.
fn last(writes: &[Written], register: u64) -> Option<(u64, u64)> {
    writes.iter().rev().find(|write| write.address == register).map(|write| (write.value & 0xFFFF, write.at_ns))
}

#[test]
fn fire_drives_duty_and_gate_and_a_halt_forces_both_off() {
    let mut velvet = plan(&["pwm_frequency = 20000"]).start();
    let set_up = velvet.bench.writes.take();
    assert_eq!(last(&set_up, PERIOD).map(|(value, _)| value), Some(9_999), "all counts of 20 kHz");
    assert_eq!(last(&set_up, MODE).map(|(value, _)| value), Some(PWM_MODE_1), "unlocked, without a buffer");
    watch(&mut velvet, &[GATE]);
    velvet.ask("fire 50 5000", SECOND);
    assert_eq!(last(&velvet.bench.writes.take(), COMPARE).map(|(value, _)| value), Some(5_000));
    assert!(changes(&mut velvet).iter().any(|change| change.pin == pin(GATE) && change.high));
    let since = velvet.send_through(b"M112\n");
    velvet.hear(20);
    let writes = velvet.bench.writes.take();
    let forced = last(&writes, MODE).expect("the mode is written");
    let gate = changes(&mut velvet).into_iter().rfind(|change| change.pin == pin(GATE)).expect("the gate goes off");
    println!("forced off after {} us, gate after {} us", (forced.1 - since) / 1_000, (gate.at_ns - since) / 1_000);
    assert_eq!((forced.0, gate.high), (FORCED_INACTIVE, false));
    assert!(forced.1 - since <= MS && gate.at_ns - since <= MS);
    assert_eq!(last(&writes, COMPARE).map(|(value, _)| value), Some(0));
}

#[test]
fn the_output_is_driven_as_it_is_configured() {
    let lines = ["pwm_frequency = 50000", "inverted_pwm = true", "opendrain = true", "pullup = true"];
    let mut velvet = plan(&lines).start();
    let set_up = velvet.bench.writes.take();
    assert_eq!(last(&set_up, PERIOD).map(|(value, _)| value), Some(3_999));
    assert_eq!(last(&set_up, ENABLES).map(|(value, _)| value), Some(0b11), "on, and on is low");
    let state = crate::common::machine::state(&mut velvet, "PI5");
    assert!(state.open_drain && state.pull == 1, "{state:?}");
}
