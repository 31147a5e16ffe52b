//! Velvet's own image on the virtual board: it homes, heats and prints, and a fault ends in a safe state.
//!
//! `VELVET_ELF` names the image; `make test` builds it and sets it.

use crate::common::MS;
use crate::common::velvet::{Plan, SECOND};
use rigless::mcu::Mcu;
use rigless::soc::stm32h743::generated::{adc3, flash, fmc, rcc, syscfg};
use sim::trace::StepEdge;
use units::{Actuator, Direction};

#[test]
fn the_image_greets_and_the_board_has_nothing_to_complain_about() {
    let mut velvet = Plan::new().start();
    velvet.type_in("version");
    velvet.hear_until("Prime", SECOND);
    assert_eq!(velvet.bench.vm.complaints(), Vec::<String>::new());
}

#[test]
fn the_external_memory_bank_is_closed_and_the_outputs_are_compensated() {
    let mut velvet = Plan::new().start();
    let (bank, cell) = velvet
        .bench
        .vm
        .with(|stopped| {
            let bus = stopped.session.board().mcu.bus();
            let bank = bus.registers("FMC").map(|file| file.get(fmc::Register::Bcr1));
            (bank, bus.registers("SYSCFG").map(|file| file.get(syscfg::Register::Cccsr)))
        })
        .expect("the image runs");
    // RM0399 section 23.7.6: the reset value 0x30DB without MBKEN. Section 13.3.7: EN and READY.
    assert_eq!(bank, Some(0x30DA));
    assert_eq!(cell.map(|cell| cell & 0x101), Some(0x101));
}

#[test]
fn the_flash_has_time_and_oscillators_that_nothing_uses_are_off() {
    let mut velvet = Plan::new().start();
    let registers = velvet.bench.vm.with(|stopped| {
        let bus = stopped.session.board().mcu.bus();
        let clocks = bus.registers("RCC").map(|file| file.get(rcc::Register::Cr));
        (clocks, bus.registers("Flash").map(|file| file.get(flash::Register::Acr)))
    });
    let (Some(clocks), Some(access)) = registers.expect("the image runs") else { panic!("no such block") };
    // RM0399 section 9.7.2: PLL2RDY, PLL2ON; HSI48RDY, HSI48ON. PLL3, PLL1, the crystal, HSI and CSI run.
    assert_eq!(clocks & (0b11 << 26 | 0b11 << 12), 0, "{clocks:#010x}");
    assert_eq!(clocks & (0b11 << 28), 0b11 << 28, "PLL3 makes the 48 MHz of USB");
    assert_eq!(clocks & (1 << 24 | 1 << 16 | 1 << 7 | 1), 1 << 24 | 1 << 16 | 1 << 7 | 1, "{clocks:#010x}");
    // Section 4.9.1: the table asks for LATENCY 2 and WRHIGHFREQ 2 at 200 MHz.
    assert_eq!(access, 0x34);
}

#[test]
fn the_converters_are_calibrated_for_linearity_too() {
    let mut velvet = Plan::new().start();
    for converter in ["ADC1", "ADC3"] {
        let control = velvet.bench.vm.with(move |stopped| {
            stopped.session.board().mcu.bus().registers(converter).map(|file| file.get(adc3::Register::Cr))
        });
        let control = control.flatten().expect("the image runs");
        // RM0399 section 26.7.3: ADCAL over; ADVREGEN, the six words of linearity ready, ADCALLIN, ADEN.
        assert_eq!(control & 0xBFC1_0001, 0x1FC1_0001, "{converter}: {control:#010x}");
    }
}

#[test]
fn homing_stops_every_axis_at_its_switch() {
    let mut velvet = Plan::new().start();
    velvet.ask("G28", 60 * SECOND);
    for motor in [Actuator::Alpha, Actuator::Beta, Actuator::Gamma] {
        let (at, lost) = velvet.world(|world| (world.carriage_mm(motor), world.lost_mm(motor)));
        let at = at.expect("a motor of the machine");
        assert!(at.abs() < 0.05, "{} stands at {at} mm", motor.name());
        assert_eq!(lost, 0.0, "{} pushed against its stop", motor.name());
    }
    assert_eq!(velvet.world(|world| world.timing_faults()), 0, "direction changed too close to a step");
}

/// Job that rests for half a second and draws a square. Homing comes before it: each of its moves begins when
/// the executor has seen the switch, so questions may move those starts.
const SQUARE: &str = "G4 P500\nG1 X60 Y60 F6000\nG1 X100\nG1 Y100\nG1 X60\nG1 Y60\nG4 P10\n";

/// Returns the edges of the square, from the first on, with this typed every so often while it runs.
fn square(question: Option<&str>) -> Vec<StepEdge> {
    let mut velvet = Plan::new().file("square.g", SQUARE).start();
    velvet.ask("G28", 60 * SECOND);
    velvet.world(|world| world.trace_mut().take());
    velvet.ask("M23 square.g", SECOND);
    velvet.type_in("M24");
    for slice in 0..3_000 {
        velvet.hear(10);
        if velvet.said().contains("Done printing file") {
            return velvet.world(|world| world.trace_mut().take());
        }
        // Ten times a second: the answers fill a seventh of the line, so none has to wait for it.
        if let Some(question) = question
            && slice % 10 == 0
        {
            velvet.bench.console.send(question.as_bytes());
        }
    }
    panic!("the square was never done; it said: {}", velvet.said());
}

/// Edge of a motion: time since its start (nanoseconds), motor, direction.
type Edge = (u64, Actuator, Direction);

/// Duration of two instructions, rounded up to whole nanoseconds at either end.
const QUANTISATION_NS: u64 = 7;
/// Duration of the step interrupt's entry. An edge that falls due while the interrupt runs already, for
/// another edge or because the feed woke it, is spared the entry. A difference of one instruction decides
/// about that, and makes at most this much.
const ENTRY_NS: u64 = 100;
/// Number of edges among which one such edge is allowed.
const RARELY: usize = 1_000;

/// Lists the edges: time since the first edge of the same motion, motor, direction. A standstill of 100 ms
/// parts motions: the start of the next motion is the executor's business, its shape is not.
fn within_motions(edges: &[StepEdge]) -> Vec<Edge> {
    let (mut began_ns, mut last_ns) = (0, 0);
    let relative = |edge: &StepEdge| {
        if edge.time_ns - last_ns > 100 * MS {
            began_ns = edge.time_ns;
        }
        last_ns = edge.time_ns;
        (edge.time_ns - began_ns, edge.actuator, edge.direction)
    };
    edges.iter().map(relative).collect()
}

#[test]
fn questions_during_a_job_move_no_edge() {
    let (quiet, asked) = (within_motions(&square(None)), within_motions(&square(Some("?M105\n"))));
    assert!(quiet.len() > 10_000, "only {} edges", quiet.len());
    // The emulator takes an interrupt between two instructions, whose choice depends on the other code that
    // is executed.
    let mut moved = 0;
    for (index, (a, b)) in quiet.iter().zip(&asked).enumerate() {
        let by_ns = a.0.abs_diff(b.0);
        assert!((a.1, a.2) == (b.1, b.2) && by_ns <= ENTRY_NS, "edge {index}: {a:?} quiet, {b:?} asked");
        moved += usize::from(by_ns > QUANTISATION_NS);
    }
    assert!(moved <= quiet.len() / RARELY, "{moved} edges of {} moved", quiet.len());
    assert_eq!(quiet.len(), asked.len());
}
