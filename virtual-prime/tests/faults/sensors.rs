//! Faults of temperature sensors, their wires and their converter.

use sim::world::Fault;

use super::scene::{Seen, State, enter, fault_halts, halts, printer};
use super::{Case, Class};
use crate::common::velvet::{Plan, SECOND, Velvet};

const NO_HOT_END: &str = "ERROR: MINTEMP or MAXTEMP triggered on T";
const NO_BED: &str = "ERROR: MINTEMP or MAXTEMP triggered on B";

/// Time for four looks, twenty times a second, and the halt.
const FOUR_LOOKS_MS: f64 = 300.0;

fn open(case: &Case) -> Seen {
    fault_halts(printer(), case.state, &Fault::ThermistorOpen("hotend".into()), NO_HOT_END, case.within_ms)
}

fn shorted(case: &Case) -> Seen {
    let (name, told) = if case.state == State::Heating { ("bed", NO_BED) } else { ("hotend", NO_HOT_END) };
    fault_halts(printer(), case.state, &Fault::ThermistorShort(name.into()), told, case.within_ms)
}

/// Lets a sensor slide out of its heater on the way up: in a cold heater the firmware could not tell.
fn slips(case: &Case) -> Seen {
    let mut velvet = enter(printer(), case.state);
    let hot_end = velvet.world(|world| world.heater_index("hotend")).expect("a hot end");
    while velvet.world(|world| world.heater_c(hot_end)) < 100.0 {
        velvet.hear(100);
    }
    let slips = Fault::ThermistorSlips("hotend".into());
    halts(velvet, |velvet| velvet.inject(&slips), "ERROR: T ", case.within_ms)
}

fn loose(case: &Case) -> Seen {
    // On the way up a jump down also looks like a heater that does not heat.
    let told = if case.state == State::Heating { "ERROR: T " } else { "its sensor has come off or is shorting" };
    fault_halts(printer(), case.state, &Fault::ThermistorLoose("hotend".into()), told, case.within_ms)
}

fn noisy(case: &Case) -> Seen {
    fault_halts(printer(), case.state, &Fault::ThermistorNoisy("hotend".into(), 25.0), "ERROR: T", case.within_ms)
}

fn drifts(case: &Case) -> Seen {
    let fault = Fault::ThermistorDrifts("hotend".into(), -4.0);
    fault_halts(printer(), case.state, &fault, "ERROR: ", case.within_ms)
}

fn swapped(case: &Case) -> Seen {
    let swap = Fault::ThermistorsSwapped("hotend".into(), "bed".into());
    let mut velvet = enter(Plan::new(), State::Idle);
    velvet.inject(&swap);
    halts(velvet, |velvet| velvet.type_in("M104 S200"), "ERROR: ", case.within_ms)
}

/// Stops the converter itself, and with it every reading.
fn converter_stands(case: &Case) -> Seen {
    let velvet = enter(printer(), case.state);
    let stands = |velvet: &mut Velvet| {
        velvet.bench.vm.with(|stopped| {
            let at = stopped.stop.at;
            stopped.session.board_mut().mcu.stop_converter(at);
        });
    };
    halts(velvet, stands, "ERROR: MINTEMP or MAXTEMP triggered on ", case.within_ms)
}

/// Silences the chip with the hot end's sensor.
fn chip_falls_silent(case: &Case) -> Seen {
    let plan = ["sensor = max31865", "spi_channel = 0", "spi_select_pin = PD10"]
        .iter()
        .fold(printer(), |plan, line| plan.set(&format!("[temperature control] hotend.{line}")));
    let silent = Fault::ConverterSilent("hotend".into());
    fault_halts(plan, case.state, &silent, NO_HOT_END, case.within_ms)
}

fn open_in_m109(case: &Case) -> Seen {
    let mut velvet = Plan::new().file("last.g", "M109 S200\n").start();
    velvet.type_in("play /sd/last.g");
    velvet.hear(2 * SECOND);
    let open = Fault::ThermistorOpen("hotend".into());
    let (velvet, seen) = super::scene::halted(velvet, |velvet| velvet.inject(&open), NO_HOT_END, case.within_ms);
    assert!(!velvet.said().contains("Done printing"), "{}", velvet.said());
    seen
}

pub const CLASSES: &[Class] = &[
    Class {
        name: "a_sensor_that_opens",
        what: "thermistor open",
        does: "that heater off at the first bad reading; halt after four in a row, with the sensor's name",
        cases: &[
            Case { state: State::Heating, within_ms: FOUR_LOOKS_MS, run: open },
            Case { state: State::Holding, within_ms: FOUR_LOOKS_MS, run: open },
            Case { state: State::Printing, within_ms: FOUR_LOOKS_MS, run: open },
            Case { state: State::Heating, within_ms: FOUR_LOOKS_MS, run: open_in_m109 },
        ],
    },
    Class {
        name: "a_sensor_that_shorts",
        what: "thermistor shorted",
        does: "the same",
        cases: &[
            Case { state: State::Heating, within_ms: FOUR_LOOKS_MS, run: shorted },
            Case { state: State::Holding, within_ms: FOUR_LOOKS_MS, run: shorted },
            Case { state: State::Printing, within_ms: FOUR_LOOKS_MS, run: shorted },
        ],
    },
    Class {
        name: "a_sensor_that_slides_out",
        what: "sensor slides out of its heater",
        does: "halt: the reading falls faster than heat can, or while the heater is fully driven; one that is out before it is warm reads too little, until `runaway_heating_timeout`",
        cases: &[
            Case { state: State::Holding, within_ms: 8_000.0, run: slips },
            Case { state: State::Printing, within_ms: 8_000.0, run: slips },
            Case { state: State::Heating, within_ms: 8_000.0, run: slips },
        ],
    },
    Class {
        name: "a_sensor_with_a_loose_plug",
        what: "sensor's plug loose: the reading jumps by 15 C",
        does: "halt",
        cases: &[
            Case { state: State::Holding, within_ms: 8_000.0, run: loose },
            Case { state: State::Heating, within_ms: 8_000.0, run: loose },
        ],
    },
    Class {
        name: "a_sensor_with_noise",
        what: "sensor's wire picks up noise: the reading is off by up to 25 C, either way",
        does: "halt",
        cases: &[
            Case { state: State::Holding, within_ms: 8_000.0, run: noisy },
            Case { state: State::Printing, within_ms: 8_000.0, run: noisy },
            Case { state: State::Heating, within_ms: 8_000.0, run: noisy },
        ],
    },
    Class {
        name: "a_sensor_that_drifts",
        what: "sensor reads less and less, by 4 C a second (a slow drift is not seen)",
        does: "halt: it cools at full output",
        cases: &[
            Case { state: State::Holding, within_ms: 15_000.0, run: drifts },
            Case { state: State::Printing, within_ms: 15_000.0, run: drifts },
        ],
    },
    Class {
        name: "a_converter_that_stands",
        what: "the converter of the thermistors stands (ADC1)",
        does: "no reading counts after 50 ms: heaters off; halt 0.2 s later",
        cases: &[
            Case { state: State::Heating, within_ms: FOUR_LOOKS_MS, run: converter_stands },
            Case { state: State::Holding, within_ms: FOUR_LOOKS_MS, run: converter_stands },
            Case { state: State::Printing, within_ms: FOUR_LOOKS_MS, run: converter_stands },
        ],
    },
    Class {
        name: "a_chip_that_falls_silent",
        what: "a sensor's converter chip stops answering",
        does: "that heater off at once; halt after four looks, with what to check",
        cases: &[
            Case { state: State::Heating, within_ms: 500.0, run: chip_falls_silent },
            Case { state: State::Printing, within_ms: 500.0, run: chip_falls_silent },
        ],
    },
    Class {
        name: "sensors_in_each_others_plugs",
        what: "sensors of two heaters in each other's plugs",
        does: "halt at the first heating, before anything is hot; both are named",
        cases: &[Case { state: State::PowerOn, within_ms: 7_000.0, run: swapped }],
    },
];

super::tests! {
    a_sensor_that_opens
    a_sensor_that_shorts
    a_sensor_that_slides_out
    a_sensor_with_a_loose_plug
    a_sensor_with_noise
    a_sensor_that_drifts
    a_converter_that_stands
    a_chip_that_falls_silent
    sensors_in_each_others_plugs
}
