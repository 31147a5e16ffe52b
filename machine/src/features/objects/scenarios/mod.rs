//! Objects that are left out of a print (M486, EXCLUDE_OBJECT).

mod at_once;

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{Alpha, Delta, Gamma};

/// A slicer's habits: it comes retracted by 2 mm and lifted, and leaves so. Each object is a line of 10 mm
/// with 1 mm of filament, 20 mm further along X than the one before.
const TO_EACH: [&str; 3] = [
    "G0 X0 Y5 F9000\nG1 Z0.2\nG1 E2 F1800\nG1 X10 E1 F3000\n",
    "G0 X20\nG1 Z0.2\nG1 E2 F1800\nG1 X30 E1 F3000\n",
    "G0 X40\nG1 Z0.2\nG1 E2 F1800\nG1 X50 E1 F3000\n",
];
const LEAVE: &str = "G1 E-2 F1800\nG1 Z0.6 F3000\n";

fn marlins() -> String {
    let objects: String =
        TO_EACH.iter().enumerate().map(|(n, lines)| format!("M486 S{n} A\"Part {n}\"\n{lines}{LEAVE}")).collect();
    format!("G28.3 X0 Y0 Z0\nM83\nG1 Z0.6 F3000\nG1 E-2 F1800\nM486 T3\n{objects}M486 S-1\nG0 X0 Y20\n")
}

/// Extrusion of a print: growth of E while X was over each object, and in all.
#[derive(Debug, PartialEq)]
struct Made {
    by_object: [f64; 3],
    in_all: f64,
    /// Least Z while X was over the second object, with filament pushed or not.
    least_z_over_the_second: f64,
}

fn print(bench: &mut Bench, during: impl Fn(&mut Bench, f64)) -> Made {
    let zero = [Alpha, Gamma, Delta].map(|motor| bench.carriage(motor));
    let place = |bench: &Bench| {
        let now = [Alpha, Gamma, Delta].map(|motor| bench.carriage(motor));
        [now[0] - zero[0], now[1] - zero[1], now[2] - zero[2]]
    };
    let mut made = Made { by_object: [0.0; 3], in_all: 0.0, least_z_over_the_second: f64::INFINITY };
    bench.say("play part.g -t");
    let (mut heard, mut before) = (String::new(), place(bench));
    for _ in 0..20_000 {
        heard += &bench.hear(0.002);
        let now = place(bench);
        during(bench, now[0]);
        // A line of filament: both go on.
        if now[0] > before[0] && now[2] > before[2] {
            let object = (((now[0] + 5.0) / 20.0) as usize).min(2);
            made.by_object[object] += now[2] - before[2];
        }
        if (20.5..29.5).contains(&now[0]) && now[1] < made.least_z_over_the_second {
            made.least_z_over_the_second = now[1];
        }
        before = now;
        if heard.contains("Done printing") {
            made.in_all = now[2];
            return made;
        }
    }
    panic!("it does not end: {heard}");
}

#[track_caller]
fn near(is: f64, ought: f64) {
    assert!((is - ought).abs() < 0.03, "{is}, not {ought}");
}

#[test]
fn all_objects_are_printed_unless_they_are_left_out() {
    let made = print(&mut Plan::new(CARTESIAN).file("part.g", &marlins()).start(), |_, _| {});
    for object in made.by_object {
        near(object, 1.0);
    }
    near(made.in_all, 3.0 - 2.0);
}

#[test]
fn an_object_that_is_left_out_is_neither_printed_nor_pressed_into_the_others() {
    let file = marlins().replace("M486 T3\n", "M486 T3\nM486 P1\n");
    let made = print(&mut Plan::new(CARTESIAN).file("part.g", &file).start(), |_, _| {});
    near(made.by_object[0], 1.0);
    near(made.by_object[1], 0.0);
    near(made.by_object[2], 1.0);
    near(made.in_all, 2.0 - 2.0);
    near(made.least_z_over_the_second, 0.6);
}

#[test]
fn absolute_e_and_klipper_s_names_leave_the_same_out() {
    let mut e = 0.0;
    let absolute: String = marlins()
        .lines()
        .map(|line| match line.split_once('E').filter(|_| line.starts_with("G1")) {
            Some((before, after)) => {
                let (number, rest) = after.split_once(' ').unwrap_or((after, ""));
                e += number.parse::<f64>().unwrap();
                format!("{before}E{e} {rest}\n")
            }
            None => format!("{line}\n"),
        })
        .collect();
    let mut file = absolute
        .replace("M83", "M82")
        .replace("M486 T3\n", "EXCLUDE_OBJECT_DEFINE NAME=p0\nEXCLUDE_OBJECT_DEFINE NAME=p1\nEXCLUDE_OBJECT NAME=P1\n");
    for n in 0..3 {
        let end = if n == 0 { "" } else { "EXCLUDE_OBJECT_END\n" };
        file = file.replace(&format!("M486 S{n} A\"Part {n}\"\n"), &format!("{end}EXCLUDE_OBJECT_START NAME=p{n}\n"));
    }
    let file = file.replace("M486 S-1\n", "EXCLUDE_OBJECT_END\n");
    let made = print(&mut Plan::new(CARTESIAN).file("part.g", &file).start(), |_, _| {});
    near(made.by_object[0], 1.0);
    near(made.by_object[1], 0.0);
    near(made.by_object[2], 1.0);
    near(made.in_all, 0.0);
}

#[test]
fn the_object_under_the_nozzle_is_left_out_at_once_and_said_to_be() {
    // Many short lines, so that it is not all in the look-ahead queue.
    let slow: String = (1..=400).map(|n| format!("G1 X{:.3} E0.0025 F300\n", 20.0 + f64::from(n) / 40.0)).collect();
    let file = marlins().replace("G1 X30 E1 F3000\n", &slow);
    let mut bench = Plan::new(CARTESIAN).file("part.g", &file).start();
    let told = std::cell::Cell::new(false);
    let made = print(&mut bench, |bench, x| {
        if x > 21.0 && !told.replace(true) {
            let listed = bench.say("M486");
            assert!(listed.contains("objects: 3, this one: Part 1\n"), "{listed}");
            bench.say("M486 C");
        }
    });
    near(made.by_object[0], 1.0);
    assert!(made.by_object[1] < 0.5, "{made:?}");
    near(made.by_object[2], 1.0);
    // Retracted by 2 as at every end: nothing is pushed that was not printed.
    assert!((made.in_all - (made.by_object.iter().sum::<f64>() - 2.0)).abs() < 0.05, "{made:?}");
    assert!(bench.say("M486").contains("1: Part 1 (left out)"));
}

#[test]
fn an_operator_who_jogs_in_a_pause_is_not_left_out() {
    let file = marlins().replace("M486 T3\n", "M486 T3\nM486 P1\n").replace("G0 X20\n", "G0 X20\nM0\n");
    let mut bench = Plan::new(CARTESIAN).file("part.g", &file).start();
    let zero = bench.carriage(Alpha);
    bench.say("play part.g -t");
    bench.hear(6.0);
    let stood = bench.carriage(Alpha);
    near(stood - zero, 10.0);
    bench.run(&["G91", "G0 X-3", "G90"]);
    bench.hear(1.0);
    near(bench.carriage(Alpha), stood - 3.0);
    bench.send(b"M24\n");
    bench.hear_until("Done printing file", 20.0);
    near(bench.carriage(Alpha) - zero, 0.0);
}

#[test]
fn an_abort_ends_it() {
    let file = marlins().replace("M486 T3\n", "M486 T3\nM486 P1\n").replace("G0 X20\n", "G0 X20\nM0\n");
    let mut bench = Plan::new(CARTESIAN).file("part.g", &file).start();
    let zero = bench.carriage(Alpha);
    bench.say("play part.g -t");
    bench.hear(6.0);
    bench.say("abort");
    bench.hear(1.0);
    bench.run(&["G90", "G0 X12"]);
    bench.hear(2.0);
    near(bench.carriage(Alpha) - zero, 12.0);
}

/// Steps of X while an object is printed (the tool is down), by object: where X and E are, counted in steps
/// from the object's first one, and when, ns from then.
fn steps_of_objects(file: &str) -> [Vec<(i64, i64, u64)>; 3] {
    let mut bench = Plan::new(CARTESIAN).file("part.g", file).start();
    bench.world(|world| world.trace_mut().take());
    bench.type_in("play part.g -t\n");
    let mut edges = Vec::new();
    for _ in 0..400 {
        let heard = bench.hear(0.1);
        edges.append(&mut bench.world(|world| world.trace_mut().take()));
        if heard.contains("Done printing") {
            break;
        }
    }
    let (mut x, mut z, mut e) = (0_i64, 0_i64, 0_i64);
    let mut by_object: [Vec<(i64, i64, u64)>; 3] = Default::default();
    let mut first = [None; 3];
    for edge in edges {
        let step = if edge.direction == units::Direction::Forward { 1 } else { -1 };
        match edge.actuator {
            Gamma => z += step,
            Delta => e += step,
            Alpha => {
                x += step;
                // Down: below half the lift.
                if z * 100 < STEPS_PER_MM_Z * 40 {
                    let object = usize::try_from((x + 5 * STEPS_PER_MM_X) / (20 * STEPS_PER_MM_X)).unwrap_or(0).min(2);
                    let (x0, e0, t0) = *first[object].get_or_insert((x, e, edge.time_ns));
                    by_object[object].push((x - x0, e - e0, edge.time_ns - t0));
                }
            }
            _ => {}
        }
    }
    by_object
}

const STEPS_PER_MM_X: i64 = 80;
const STEPS_PER_MM_Z: i64 = 400;

#[test]
fn the_other_objects_are_the_same_steps() {
    let whole = steps_of_objects(&marlins());
    assert!(
        whole.iter().all(|steps| steps.len() == 10 * STEPS_PER_MM_X as usize),
        "{:?}",
        whole.each_ref().map(Vec::len)
    );
    for out in 0..3 {
        let file = marlins().replace("M486 T3\n", &format!("M486 T3\nM486 P{out}\n"));
        let some = steps_of_objects(&file);
        for object in 0..3 {
            if object == out {
                assert!(some[object].is_empty(), "{out} is left out");
            } else {
                assert_eq!(some[object].len(), whole[object].len(), "{object} without {out}");
                for (ours, theirs) in some[object].iter().zip(&whole[object]) {
                    assert_eq!((ours.0, ours.1), (theirs.0, theirs.1), "{object} without {out}: the same steps");
                    // On a grid of 5 ns, wherever on it the object begins.
                    assert!(ours.2.abs_diff(theirs.2) <= 10, "{object} without {out}: {ours:?} {theirs:?}");
                }
            }
        }
    }
}
