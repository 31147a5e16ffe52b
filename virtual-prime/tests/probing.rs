//! Velvet's image and a probe on a pin of the board: the contact's edge is stamped by its interrupt.

use crate::common::velvet::{Plan, SECOND, Velvet};
use sim::models::surface::{Bed, Surface};
use sim::trace::StepEdge;
use units::Actuator::{Alpha, Gamma};

/// Length of a step in the sample, mm: Z, and X.
const Z_STEP: f64 = 1.0 / 400.0;
const X_STEP: f64 = 1.0 / 80.0;

/// Plans the sample with a probe on its connector. Homing is not needed: the machine starts at zero, 10 mm
/// over the bed.
fn plan() -> Plan {
    ["[zprobe] enable = true", "[zprobe] probe_pin = PB10^", "[zprobe] max_travel = 15"]
        .into_iter()
        .fold(Plan::new(), Plan::set)
}

fn lay(velvet: &mut Velvet, surface: Surface) {
    let at_ns = velvet.bench.vm.now_ns();
    velvet.world(|world| world.lay(at_ns, surface));
    velvet.hear(5);
}

fn bed(height_mm: f64) -> Surface {
    Surface { bed: Some(Bed::level(height_mm)), ..Surface::default() }
}

fn z_of(velvet: &mut Velvet) -> f64 {
    velvet.world(|world| world.carriage_mm(Gamma)).expect("a Z motor")
}

fn numbers(answer: &str, head: &str) -> Vec<f64> {
    let line =
        answer.lines().find_map(|line| line.strip_prefix(head)).unwrap_or_else(|| panic!("no {head} in {answer}"));
    line.trim_end_matches(']').split([',', ':']).map(|word| word.parse().expect("a number")).collect()
}

/// Returns the time from the step that closed the contact to the first later step with a longer distance to
/// the next than before, ns.
fn brake_delay(edges: &[StepEdge], steps_to_contact: usize) -> u64 {
    let down: Vec<_> = edges.iter().filter(|edge| edge.actuator == Gamma).map(|edge| edge.time_ns).collect();
    let contact = down[steps_to_contact - 1];
    let before = contact - down[steps_to_contact - 2];
    let slower = down.windows(2).skip(steps_to_contact - 1).find(|pair| pair[1] - pair[0] > before + before / 200 + 20);
    slower.expect("it brakes")[0] - contact
}

#[test]
fn g38_finds_the_surface_to_the_step_and_brakes_within_2_ms() {
    for (feed, height) in [(120.0, 4.1234), (600.0, 2.6)] {
        let mut velvet = plan().start();
        lay(&mut velvet, bed(height));
        velvet.world(|world| world.trace_mut().take());
        let answer = velvet.ask(&format!("G38.2 Z-12 F{feed}"), 20 * SECOND);
        let found = numbers(&answer, "[PRB:");
        // The machine is at zero 10 mm above the bed's zero.
        assert!((found[2] + 10.0 - height).abs() <= Z_STEP + 0.0005 && found[3] == 1.0, "{answer}");
        let at = z_of(&mut velvet);
        assert!((at - 10.0 - found[2]).abs() < 0.0006, "it stands at {at}");
        let edges = velvet.world(|world| world.trace_mut().take());
        let delay_ns = brake_delay(&edges, ((10.0 - height) / Z_STEP).ceil() as usize);
        println!("F{feed}: {delay_ns} ns from the contact to the brake");
        assert!(delay_ns <= 2_000_000, "{delay_ns} ns");
        // The machine also knows its position.
        velvet.ask("G53 G0 Z0", SECOND);
        velvet.ask("M400", 20 * SECOND);
        let back = z_of(&mut velvet);
        assert!((back - 10.0).abs() < 1e-9, "back at {back}");
        assert_eq!(velvet.bench.vm.complaints(), Vec::<String>::new());
    }
}

#[test]
fn g30_measures_the_way_to_the_surface() {
    let mut velvet = plan().start();
    lay(&mut velvet, bed(6.789));
    let found = numbers(&velvet.ask("G30 F300", 20 * SECOND), "Z:")[0];
    assert!((found - 3.211).abs() <= Z_STEP + 0.0001, "{found}");
    assert!((z_of(&mut velvet) - 10.0).abs() < 1e-9, "it returns");
    velvet.ask("G30 Z0.5 F300", 20 * SECOND);
    velvet.bench.console.send(b"?");
    let status = velvet.hear_until(">\n", SECOND);
    assert!(status.contains("WPos:0.0000,0.0000,0.5000"), "{status}");
    assert!((z_of(&mut velvet) - 6.789).abs() <= Z_STEP);
}

#[test]
fn the_contacts_end_is_an_edge_as_well() {
    let mut velvet = plan().start();
    lay(&mut velvet, bed(8.0));
    velvet.ask("G38.2 Z-12", 20 * SECOND);
    velvet.ask("G91", SECOND);
    velvet.ask("G1 Z-0.5 F120", SECOND);
    let found = numbers(&velvet.ask("G38.4 Z2 F120", 20 * SECOND), "[PRB:");
    assert!((found[2] + 2.0).abs() <= 2.0 * Z_STEP && found[3] == 1.0, "{found:?}");
}

/// Tests `probe_pin` on another connector, whose number (9) another port's pin may have, and the other way
/// round.
#[test]
fn the_probe_is_at_its_pin() {
    for pin in ["PJ9^", "PJ9!"] {
        let mut velvet = plan().set(&format!("[zprobe] probe_pin = {pin}")).start();
        lay(
            &mut velvet,
            Surface { bed: None, blocks: vec![[[33.0, 40.0], [-500.0, 500.0], [-500.0, 500.0]]], ..Surface::default() },
        );
        // X stands at 30 mm at power-on.
        let found = numbers(&velvet.ask("G38.2 X10 F300", 20 * SECOND), "[PRB:");
        assert!((found[0] - 3.0).abs() <= X_STEP, "{pin}: {found:?}");
        let at = velvet.world(|world| world.carriage_mm(Alpha)).expect("an X motor");
        assert!((at - 33.0).abs() <= X_STEP, "{pin}: {at}");
        let answer = velvet.ask("M119", SECOND);
        assert!(answer.contains(&format!("(Probe){}", pin)), "{answer}");
    }
}

#[test]
fn a_miss_is_an_alarm_and_leaves_the_machine_safe() {
    let mut velvet = plan().fault("switch-never:probe").start();
    velvet.type_in("G38.2 Z-1 F300");
    velvet.hear_until("ALARM: Probe fail", 5 * SECOND);
    velvet.assert_safe();
    velvet.assert_told_once("ALARM: Probe fail");
}

#[test]
fn a_probe_that_is_stuck_closed_is_refused() {
    let mut velvet = plan().fault("switch-always:probe").start();
    velvet.type_in("G30");
    velvet.hear_until("error:ZProbe triggered before move, aborting command.\n", 5 * SECOND);
    assert_eq!(velvet.world(|world| world.trace().total()), 0);
}

/// Tests leveling, and the memory that the deepest of all command sequences takes.
#[test]
fn a_grid_levels_the_bed() {
    let plan = [
        "[zprobe] leveling = cartesian grid",
        "[zprobe] probe_height = 2",
        "[cartesian grid leveling strategy] only_by_two_corners = true",
        "[cartesian grid leveling strategy] grid_x_size = 2",
        "[cartesian grid leveling strategy] grid_y_size = 2",
        "[cartesian grid leveling strategy] initial_height = -6",
    ]
    .into_iter()
    .fold(plan(), Plan::set);
    let mut velvet = plan.start();
    let bed = Bed::tilted(0.5, [0.01, 0.02]);
    lay(&mut velvet, Surface { bed: Some(bed), ..Surface::default() });
    let answer = velvet.ask("G32 X0 Y0 A20 B20", 60 * SECOND);
    assert_eq!(answer.matches("DEBUG: X").count(), 4, "{answer}");
    let mut gaps = Vec::new();
    for place in ["X0 Y0", "X20 Y10", "X10 Y20"] {
        velvet.ask(&format!("G1 {place} Z-5 F6000"), SECOND);
        velvet.ask("M400", 20 * SECOND);
        let [x, y, z] = velvet.world(|world| world.tool_mm());
        gaps.push(z - bed.height(x, y));
    }
    assert!(gaps.iter().all(|gap| (gap - gaps[0]).abs() < 3.0 * Z_STEP), "{gaps:?}");
    velvet.type_in("mem");
    let said = velvet.hear(100);
    for line in ["stack never used: ", "stack of interrupts never used: "] {
        let told = said.lines().find_map(|said| said.strip_prefix(line)).expect("a stack's depth");
        let told: u32 = told.trim_end_matches(" bytes").parse().expect("a number");
        assert!(told > 8_192, "{said}");
    }
}
