//! Heaters, fans, relays, and their enable lines.

use board_facts::figures::MODULATION_NS;
use board_facts::wiring::{DRIVERS, OUTPUT_BUFFER_ENABLE, POWER_OUTPUTS, SUPPLY_SWITCH, USB_HOST_POWER, power_output};
use virtual_prime::pin_state::Drive;

use crate::common::machine::{changes, everything, pin, state, watch};
use crate::common::velvet::{PROMPT, SECOND, Velvet};

fn outputs() -> Vec<&'static str> {
    POWER_OUTPUTS.iter().map(|output| output.pin).collect()
}

/// Levels from reset to the prompt, on a machine that uses all of them.
#[test]
fn no_output_is_on_before_its_time() {
    let mut velvet = everything().held();
    let mut watched = outputs();
    watched.extend(DRIVERS.map(|driver| driver.step));
    watched.push(DRIVERS[0].select);
    watched.extend([OUTPUT_BUFFER_ENABLE, SUPPLY_SWITCH, USB_HOST_POWER]);
    watch(&mut velvet, &watched);
    // The image drives the pins within the first millisecond.
    velvet.hear(1);
    for output in &POWER_OUTPUTS {
        let off = if output.on_high { Drive::Low } else { Drive::High };
        assert_eq!(state(&mut velvet, output.pin).drive, off, "{}", output.name);
    }
    assert_eq!(state(&mut velvet, OUTPUT_BUFFER_ENABLE).drive, Drive::Released);
    velvet.hear_until(PROMPT, 2 * SECOND);
    let all = changes(&mut velvet);
    for output in &POWER_OUTPUTS {
        let on = all.iter().find(|change| change.pin == pin(output.pin) && change.high == output.on_high);
        assert_eq!(on, None, "{}", output.name);
    }
    for name in DRIVERS.map(|driver| driver.step).into_iter().chain([USB_HOST_POWER]) {
        assert!(!all.iter().any(|change| change.pin == pin(name) && change.high), "{name}");
    }
    // The buffer and the load switch go on only once a configuration has been wired, and the switch not after
    // the buffer.
    let wired = all.iter().find(|change| change.pin == pin(DRIVERS[0].select)).expect("a driver's select");
    let supply = all.iter().find(|change| change.pin == pin(SUPPLY_SWITCH) && change.high).expect("wired at last");
    assert!(supply.at_ns > wired.at_ns, "{supply:?} {wired:?}");
    let buffer = all.iter().rfind(|change| change.pin == pin(OUTPUT_BUFFER_ENABLE)).expect("wired at last");
    assert!(!buffer.high && buffer.at_ns >= supply.at_ns, "{buffer:?} {supply:?}");
}

/// Returns the outputs that changed while this line took effect; all of them are off before and after.
#[track_caller]
fn outputs_moved_by(velvet: &mut Velvet, on: &str, off: &str) -> Vec<&'static str> {
    changes(velvet);
    assert_eq!(velvet.ask(on, SECOND), "ok\n");
    velvet.hear(400);
    let all = changes(velvet);
    let moved: Vec<_> = outputs().into_iter().filter(|name| all.iter().any(|change| change.pin == pin(name))).collect();
    for name in &moved {
        let output = power_output(name).expect("an output");
        assert!(all.iter().any(|change| change.pin == pin(name) && change.high == output.on_high), "{name}");
        // Modulated outputs change on the modulators' grid, give or take the interrupt's other work.
        let times: Vec<u64> = all.iter().filter(|change| change.pin == pin(name)).map(|change| change.at_ns).collect();
        for pair in times.windows(2) {
            let off_grid = (pair[1] - pair[0] + MODULATION_NS / 2) % MODULATION_NS;
            assert!(off_grid.abs_diff(MODULATION_NS / 2) < 30_000, "{name}: {} ns apart", pair[1] - pair[0]);
        }
    }
    assert_eq!(velvet.ask(off, SECOND), "ok\n");
    velvet.hear(400);
    moved
}

#[test]
fn each_heater_drives_its_own_output_and_no_other() {
    let mut velvet = everything().start();
    watch(&mut velvet, &outputs());
    for (on, off, expected) in
        [("M104 T0 S60", "M104 T0 S0", "PE0"), ("M104 T1 S60", "M104 T1 S0", "PB8"), ("M140 S50", "M140 S0", "PE3")]
    {
        assert_eq!(outputs_moved_by(&mut velvet, on, off), [expected], "{on}");
    }
}

#[test]
fn each_switch_drives_its_own_output_and_no_other() {
    let mut velvet = everything().start();
    watch(&mut velvet, &outputs());
    for (on, off, expected) in
        [("M106 S128", "M107", "PE1"), ("M42", "M43", "PI11"), ("M80", "M81", "PI4"), ("M64", "M65", "PB7")]
    {
        assert_eq!(outputs_moved_by(&mut velvet, on, off), [expected], "{on}");
        let output = power_output(expected).expect("an output");
        let off = if output.on_high { Drive::Low } else { Drive::High };
        assert_eq!(state(&mut velvet, expected).drive, off, "{expected} after {on}");
    }
}

#[test]
fn a_halt_closes_the_buffer_and_opens_the_load_switch() {
    let mut velvet = everything().start();
    let levels = |velvet: &mut Velvet| [OUTPUT_BUFFER_ENABLE, SUPPLY_SWITCH].map(|name| state(velvet, name).drive);
    assert_eq!(levels(&mut velvet), [Drive::Low, Drive::High]);
    assert!(state(&mut velvet, OUTPUT_BUFFER_ENABLE).open_drain);
    velvet.type_in("M112");
    velvet.hear(3 * SECOND);
    assert_eq!(levels(&mut velvet), [Drive::Released, Drive::Low]);
    velvet.ask("M999", SECOND);
    velvet.hear(SECOND);
    assert_eq!(levels(&mut velvet), [Drive::Low, Drive::High]);
}
