//! An object that is excluded while the motors make it, or while its moves are planned (M486,
//! EXCLUDE_OBJECT): it is left at once, and everything else is made as it was.

use scenarios::{Bench, CARTESIAN, Plan};
use units::Actuator::{self, Alpha, Beta, Delta, Gamma};

/// Style of moves in a slicer's file.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Ways {
    Lines,
    /// With rounded corners (G64).
    Rounded,
    Arcs,
}

#[derive(Clone, Copy, Debug)]
struct Style {
    absolute_e: bool,
    ways: Ways,
    /// Whether the objects have Klipper's names instead of Marlin's numbers.
    klipper: bool,
}

const PLAIN: Style = Style { absolute_e: false, ways: Ways::Lines, klipper: false };
/// Moves of an object in a layer: more than are planned ahead.
const MOVES: usize = 80;
/// Filament for an object in a layer, mm.
const FILAMENT: f64 = 2.0;

/// Three objects of 10 mm along X, 20 mm apart, in two layers. The slicer comes retracted by 2 mm and lifted
/// by 0.4 mm, and leaves so.
fn part(style: Style) -> String {
    let mut text = String::from("G28.3 X0 Y0 Z0\nG90\nG1 Z0.6 F3000\n");
    text += if style.absolute_e { "M82\nG92 E0\n" } else { "M83\n" };
    text += if style.ways == Ways::Rounded { "G64 P0.05\n" } else { "" };
    let mut e = 0.0;
    let mut filament = |by: f64| {
        e = if style.absolute_e { e + by } else { by };
        format!("E{e:.5}")
    };
    text += &format!("G1 {} F1800\nM486 T3\n", filament(-2.0));
    for layer in 1..=2 {
        let z = 0.2 * f64::from(layer);
        for object in 0..3 {
            text += &if style.klipper {
                format!("EXCLUDE_OBJECT_START NAME=part_{object}\n")
            } else {
                format!("M486 S{object}\n")
            };
            let from = 20.0 * f64::from(object);
            text += &format!("G0 X{from} Y5 F9000\nG1 Z{z:.1} F3000\nG1 {} F1800\nG1 F1200\n", filament(2.0));
            for n in 1..=MOVES {
                let x = from + 10.0 * n as f64 / MOVES as f64;
                let y = if n % 2 == 0 { 5.0 } else { 5.2 };
                let e = filament(FILAMENT / MOVES as f64);
                text += &match style.ways {
                    Ways::Arcs if n % 8 == 0 => format!("G2 X{x:.4} Y{y:.4} R0.2 {e}\n"),
                    _ => format!("G1 X{x:.4} Y{y:.4} {e}\n"),
                };
            }
            text += &format!("G1 {} F1800\nG1 Z{:.1} F3000\n", filament(-2.0), z + 0.4);
            text += if style.klipper { "EXCLUDE_OBJECT_END\n" } else { "" };
        }
    }
    let end = if style.klipper { "" } else { "M486 S-1\n" };
    format!("{text}{end}G0 X0 Y20\n")
}

const STEPS_PER_MM: i64 = 80;

/// A step while an object is made: time, ns; places of X, Y and E, steps from the object's beginning.
type Step = (u64, [i64; 3]);

/// Steps and filament of a print.
#[derive(Debug, Default)]
struct Made {
    /// Steps of X, by object and layer.
    steps: [[Vec<Step>; 2]; 3],
    /// Filament by object and layer, while X goes on, mm.
    filament: [[f64; 2]; 3],
    /// Filament in all, mm.
    in_all: f64,
    /// Filament of the object that was being made at the action, from a while later on, mm.
    too_late: f64,
    /// X at the time of the action, mm.
    said_at: f64,
    /// Lowest Z over the second object after the action, mm.
    least_z: f64,
}

/// Longest time for braking and for steps written ahead, ns.
const BRAKING: u64 = 60_000_000;

/// Plays the file, and runs the action once X has come to a place in the first layer.
fn play(text: &str, at: Option<f64>, does: impl Fn(&mut Bench)) -> Made {
    let mut bench = Plan::new(CARTESIAN).file("part.g", text).start();
    play_on(&mut bench, "play part.g -t\n", at, does)
}

fn play_on(bench: &mut Bench, command: &str, at: Option<f64>, does: impl Fn(&mut Bench)) -> Made {
    let zero = [Alpha, Delta].map(|motor| bench.carriage(motor));
    bench.world(|world| world.trace_mut().take());
    bench.type_in(command);
    let (mut edges, mut said) = (Vec::new(), None);
    for _ in 0..60_000 {
        let heard = bench.hear(0.001);
        let x = bench.carriage(Alpha) - zero[0];
        if let (Some(place), None) = (at, said)
            && x >= place
        {
            said = Some((bench.now_s() * 1e9, x));
            does(bench);
        }
        edges.append(&mut bench.world(|world| world.trace_mut().take()));
        if heard.contains("Done printing") {
            let mut made = sort(&edges, said.map(|(time, _)| time as u64));
            made.in_all = bench.carriage(Delta) - zero[1];
            made.said_at = said.map_or(0.0, |(_, x)| x);
            return made;
        }
    }
    panic!("it does not end");
}

fn sort(edges: &[sim::trace::StepEdge], said: Option<u64>) -> Made {
    let mut made = Made { least_z: f64::INFINITY, ..Made::default() };
    let [mut x, mut y, mut z, mut e] = [0_i64; 4];
    let mut last_e = 0;
    let mut first = [[None; 2]; 3];
    let now_made = |x: i64| ((x + 5 * STEPS_PER_MM).max(0) / (20 * STEPS_PER_MM)).min(2) as usize;
    let mut of_said = None;
    for edge in edges {
        let step = if edge.direction == units::Direction::Forward { 1 } else { -1 };
        if said.is_some_and(|said| edge.time_ns >= said) && of_said.is_none() {
            of_said = Some((now_made(x), z > 100));
        }
        match edge.actuator {
            Actuator::Alpha => x += step,
            Actuator::Beta => y += step,
            Actuator::Gamma => z += step,
            Actuator::Delta => e += step,
            _ => continue,
        }
        let object = now_made(x);
        let over_second = (41 * STEPS_PER_MM / 2..59 * STEPS_PER_MM / 2).contains(&x);
        if said.is_some_and(|said| edge.time_ns > said + BRAKING) && over_second {
            made.least_z = made.least_z.min(z as f64 / 400.0);
        }
        // Z of the layers: 0.2 and 0.4 mm; lifted: 0.6 and 0.8.
        let layer = match z {
            70..=90 => 0,
            150..=170 => 1,
            _ => {
                last_e = e;
                continue;
            }
        };
        if edge.actuator == Actuator::Alpha {
            // More is pushed back after a retraction, on the spot.
            if (1..12).contains(&(e - last_e)) {
                made.filament[object][layer] += (e - last_e) as f64 / 415.0;
                if said.is_some_and(|said| edge.time_ns > said + BRAKING) && of_said.is_some_and(|(o, _)| o == object) {
                    made.too_late += (e - last_e) as f64 / 415.0;
                }
            }
            last_e = e;
            let (t0, from) = *first[object][layer].get_or_insert((edge.time_ns, [x, y, e]));
            made.steps[object][layer].push((edge.time_ns - t0, [x - from[0], y - from[1], e - from[2]]));
        }
    }
    made
}

#[track_caller]
fn near(is: f64, ought: f64, within: f64, what: &str) {
    assert!((is - ought).abs() < within, "{what}: {is}, not {ought}");
}

/// The steps of an object are those of the whole part.
fn same(some: &Made, whole: &Made, object: usize, layer: usize, what: &str) {
    let (ours, theirs) = (&some.steps[object][layer], &whole.steps[object][layer]);
    assert_eq!(ours.len(), theirs.len(), "{what}: object {object} in layer {layer}");
    for ((_, ours), (_, theirs)) in ours.iter().zip(theirs) {
        assert_eq!(ours, theirs, "{what}: object {object} in layer {layer}");
    }
}

fn styles() -> [Style; 4] {
    [
        PLAIN,
        Style { absolute_e: true, klipper: true, ..PLAIN },
        Style { ways: Ways::Rounded, ..PLAIN },
        Style { absolute_e: true, ways: Ways::Arcs, klipper: false },
    ]
}

#[test]
fn nothing_more_of_the_object_under_the_nozzle_is_made_and_all_else_is_as_it_was() {
    for style in styles() {
        let text = part(style);
        let whole = play(&text, None, |_| {});
        for layers in &whole.filament {
            layers.iter().for_each(|made| near(*made, FILAMENT, 0.06, "all of it"));
        }
        // With more of it to be read; with its end, and what follows, planned already; in its last move.
        for (at, command) in [
            (21.0, "M486 C\n"),
            (24.0, "M486 P1\n"),
            (27.0, "M486 C\n"),
            (29.0, "EXCLUDE_OBJECT CURRENT=1\n"),
            (29.9, "M486 C\n"),
        ] {
            let command = if style.klipper { "EXCLUDE_OBJECT NAME=PART_1\n" } else { command };
            let what = format!("{style:?}, {command:?} at X{at}");
            let made = play(&text, Some(at), |bench| bench.type_in(command));
            near(made.too_late, 0.0, 0.001, &what);
            let by_then = FILAMENT * (made.said_at - 20.0) / 10.0;
            near(made.filament[1][0], by_then.min(FILAMENT), 0.25, &what);
            assert_eq!(made.filament[1][1], 0.0, "{what}: nor in the next layer");
            assert!(made.least_z > 0.19, "{what}: {}", made.least_z);
            for (object, layer) in [(0, 0), (2, 0), (0, 1), (2, 1)] {
                same(&made, &whole, object, layer, &what);
            }
            // The print ends as far retracted as the file does: only the cancelled filament is missing.
            let missing: f64 = (0..2).map(|layer| whole.filament[1][layer] - made.filament[1][layer]).sum();
            near(made.in_all, whole.in_all - missing, 0.03, &what);
        }
    }
}

#[test]
fn excluding_another_object_changes_nothing_of_the_one_under_the_nozzle() {
    let text = part(PLAIN);
    let whole = play(&text, None, |_| {});
    // Nothing of the object is planned; its beginning is.
    for at in [1.0, 7.0, 9.5] {
        let made = play(&text, Some(at), |bench| bench.type_in("M486 P1\n"));
        for layer in 0..2 {
            same(&made, &whole, 0, layer, "the first");
            for ((ours, _), (theirs, _)) in made.steps[0][layer].iter().zip(&whole.steps[0][layer]) {
                // On a grid of 5 ns, wherever on it the object begins.
                assert!(ours.abs_diff(*theirs) <= 10, "at X{at}: {ours} ns, {theirs} ns");
            }
            same(&made, &whole, 2, layer, "the third");
            near(made.filament[1][layer], 0.0, 0.01, "the second");
        }
        near(made.in_all, whole.in_all - 2.0 * FILAMENT, 0.03, "E");
    }
}

#[test]
fn the_last_object_can_be_left_and_the_job_ends() {
    let text = part(PLAIN);
    let whole = play(&text, None, |_| {});
    let made = play(&text, Some(49.0), |bench| bench.type_in("M486 C\n"));
    near(made.too_late, 0.0, 0.001, "the third");
    same(&made, &whole, 0, 1, "the next layer");
    same(&made, &whole, 1, 1, "the next layer");
}

#[test]
fn a_held_machine_drops_them_and_stays_held() {
    let text = part(PLAIN);
    let whole = play(&text, None, |_| {});
    for at in [23.0, 29.0] {
        let made = play(&text, Some(at), |bench| {
            bench.send(b"!");
            bench.hear(0.3);
            let stood = [Alpha, Beta, Gamma, Delta].map(|motor| bench.carriage(motor));
            bench.say("M486 C");
            bench.hear(0.5);
            assert_eq!([Alpha, Beta, Gamma, Delta].map(|motor| bench.carriage(motor)), stood);
            bench.send(b"~");
        });
        near(made.too_late, 0.0, 0.001, "the second");
        assert_eq!(made.filament[1][1], 0.0, "nor in the next layer");
        same(&made, &whole, 2, 0, "the third");
        same(&made, &whole, 2, 1, "the third");
        near(made.in_all, whole.in_all - 2.0 * FILAMENT + made.filament[1][0], 0.03, "E");
    }
}

#[test]
fn a_suspended_job_goes_on_without_the_object() {
    let text = part(PLAIN);
    let whole = play(&text, None, |_| {});
    let made = play(&text, Some(23.0), |bench| {
        bench.say("pause");
        bench.hear(4.0);
        bench.say("M486 C");
        bench.send(b"resume\n");
    });
    // Moves planned before the suspension were made.
    assert!(made.filament[1][0] < 0.9 * FILAMENT && made.filament[1][1] == 0.0, "{:?}", made.filament);
    same(&made, &whole, 2, 0, "the third");
    same(&made, &whole, 0, 1, "the first");
}

#[test]
fn one_that_is_taken_in_again_is_made_in_the_next_layer() {
    let text = part(PLAIN);
    let whole = play(&text, None, |_| {});
    let made = play(&text, Some(23.0), |bench| {
        bench.say("M486 C");
        bench.hear(1.0);
        bench.say("M486 U1");
    });
    assert!(made.filament[1][0] < 0.5 * FILAMENT, "{:?}", made.filament);
    same(&made, &whole, 1, 1, "the second");
}

#[test]
fn a_file_that_excludes_an_object_means_what_comes_behind() {
    let text = part(PLAIN);
    let (before, behind) = text.split_at(text.match_indices("M486 S2\n").next().unwrap().0);
    let made = play(&format!("{before}M486 P1\n{behind}"), None, |_| {});
    near(made.filament[1][0], FILAMENT, 0.06, "the first layer");
    assert_eq!(made.filament[1][1], 0.0);
}

#[test]
fn the_time_left_and_the_line_go_on_from_what_is_made() {
    let text = part(PLAIN);
    let mut bench = Plan::new(CARTESIAN).file("part.g", &text).start();
    bench.say("play part.g");
    let zero = bench.carriage(Alpha);
    while bench.carriage(Alpha) - zero < 28.0 {
        bench.hear(0.05);
    }
    let left = |bench: &mut Bench| {
        let said = bench.ask("M27");
        let clock = said.split("time left: ").nth(1).unwrap_or_else(|| panic!("{said}")).split(' ').next().unwrap();
        clock.split(':').fold(0.0, |sum, part| 60.0 * sum + part.parse::<f64>().unwrap())
    };
    let before = left(&mut bench);
    bench.say("M486 C");
    bench.hear(1.2);
    let behind = left(&mut bench);
    assert!(behind < before && behind > 1.0, "{before} s, then {behind} s");
}

#[test]
fn a_pause_behind_it_loses_nothing_and_makes_nothing_of_what_is_excluded() {
    // The moves of the second object are planned while the first is made, and a pause waits for those.
    let text = part(PLAIN);
    let whole = play(&text, None, |_| {});
    let made = play(&text, Some(9.0), |bench| {
        bench.type_in("M486 P1\npause\n");
        bench.hear(4.0);
        bench.send(b"resume\n");
    });
    near(made.filament[1][0] + made.filament[1][1], 0.0, 0.01, "the second");
    same(&made, &whole, 0, 0, "the first");
    same(&made, &whole, 2, 0, "the third");
    near(made.in_all, whole.in_all - 2.0 * FILAMENT, 0.03, "E");
}

#[test]
fn a_job_that_begins_in_an_excluded_object_goes_on_with_the_next_one() {
    for absolute_e in [false, true] {
        let text = part(Style { absolute_e, ..PLAIN });
        let whole = play(&text, None, |_| {});
        let text = text.replace("M486 T3\n", "M486 T3\nM486 P1\n");
        let of_second = text.match_indices("M486 S1\n").nth(1).unwrap().0;
        let line = text[..of_second].lines().count() + 10;
        let mut bench = Plan::new(CARTESIAN).file("part.g", &text).start();
        bench.run(&["G28.3 X0 Y0 Z0"]);
        let made = play_on(&mut bench, &format!("play part.g -t --from line {line}\n"), None, |_| {});
        assert_eq!(made.filament[1], [0.0; 2]);
        same(&made, &whole, 2, 1, "the third");
    }
}
