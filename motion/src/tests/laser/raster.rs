//! Pictures: every edge at its place, at speed.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Axis, MmPerSecond, PerAxis};

use super::{by_speed, constant, duties, machines, plain, run, steps, with_laser};
use crate::{
    Mode, MotionConfig, Move, Tag,
    laser::{LaserConfig, Power},
    tests::{
        laws::ideal,
        rig::{Rig, at, cases, printer},
    },
};

/// Distance of two rows, mm.
const ROW_MM: f64 = 0.1;

/// A picture of rows of pixels, there and back.
#[derive(Clone, Debug)]
pub struct Picture {
    pub rows: Vec<Vec<u16>>,
    /// Size of a pixel and way before and behind a row, mm.
    pub pixel: f64,
    pub overscan: f64,
    pub speed: f64,
    pub by_speed: bool,
}

impl Picture {
    fn power(&self, level: u16) -> Power {
        if self.by_speed { by_speed(level) } else { constant(level) }
    }

    /// Returns the level of the pixel at a place, zero beside the picture.
    pub fn level_at(&self, place: &PerAxis<f64>) -> f64 {
        let row = self.rows.get((place[Axis::Y] / ROW_MM).round() as usize);
        let index = (place[Axis::X] / self.pixel).floor();
        row.filter(|_| index >= 0.0).map_or(0.0, |row| {
            let is_backward = (place[Axis::Y] / ROW_MM).round() as usize % 2 == 1;
            let from_start = if is_backward { row.len() as f64 - 1.0 - index } else { index };
            let level = if from_start >= 0.0 { row.get(from_start as usize) } else { None };
            level.map_or(0.0, |level| f64::from(*level))
        })
    }

    /// The moves, and the places at which the level changes, with the new level.
    pub fn moves(&self) -> (Vec<Move>, Vec<(PerAxis<f64>, u16)>) {
        let (mut moves, mut changes) = (Vec::new(), Vec::new());
        let mut line = 0;
        let mut go = |x: f64, y: f64, level: u16, mode: Mode| {
            line += 1;
            let feed = Move::feed(at(x, y, 0.0, 0.0), MmPerSecond(self.speed));
            moves.push(Move { power: self.power(level), mode, tag: Tag(line), ..feed });
        };
        for (index, row) in self.rows.iter().enumerate() {
            let (y, width) = (ROW_MM * index as f64, row.len() as f64 * self.pixel);
            let (start, sign) = if index % 2 == 0 { (0.0, 1.0) } else { (width, -1.0) };
            go(start - sign * self.overscan, y, 0, Mode::Rapid);
            go(start, y, 0, Mode::Feed);
            let mut before = 0;
            for (n, level) in row.iter().enumerate() {
                let place = |n: usize| start + sign * n as f64 * self.pixel;
                go(place(n + 1), y, *level, Mode::Feed);
                if *level != before {
                    changes.push((at(place(n), y, 0.0, 0.0), *level));
                }
                before = *level;
            }
            if before != 0 {
                changes.push((at(start + sign * width, y, 0.0, 0.0), 0));
            }
            go(start + sign * (width + self.overscan), y, 0, Mode::Feed);
        }
        (moves, changes)
    }
}

pub fn pictures() -> impl Strategy<Value = Picture> {
    let level = prop_oneof![2 => Just(0_u16), 1 => Just(20_000_u16), 1 => Just(65_535_u16), 1 => 300..65_535_u16];
    let rows = prop::collection::vec(prop::collection::vec(level, 1..80), 1..4);
    (rows, 0.04..0.4_f64, prop_oneof![Just(0.0), 0.1..45.0_f64], 20.0..500.0_f64, any::<bool>())
        .prop_map(|(rows, pixel, overscan, speed, by_speed)| Picture { rows, pixel, overscan, speed, by_speed })
}

/// A machine, and a picture that it can make: shapers round the path's corners, so the corners must be away
/// from the picture.
fn pictures_on_machines() -> impl Strategy<Value = (Picture, MotionConfig)> {
    (pictures(), machines()).prop_map(|(picture, config)| {
        // Pulses and latency of the slowest shaper.
        let rounded = if config.filters.latency() > 0.0 { 0.12 * picture.speed } else { 0.0 };
        (Picture { overscan: picture.overscan.max(rounded), ..picture }, config)
    })
}

/// Events that turn the laser on or off, and no others.
fn switches(duties: &[(f64, u16)]) -> Vec<(f64, bool)> {
    let mut is_on = false;
    let mut switches = Vec::new();
    for (at, duty) in duties {
        if (*duty > 0) != is_on {
            is_on = !is_on;
            switches.push((*at, is_on));
        }
    }
    switches
}

/// Every edge is at its place: the greatest distance, mm.
fn worst_place(rig: &Rig, config: MotionConfig, picture: &Picture) -> Result<f64, TestCaseError> {
    let (_, changes) = picture.moves();
    let ideal = ideal(rig, config);
    let played = duties(rig);
    // Power by speed has changes between the edges.
    let (times, places): (Vec<f64>, Vec<PerAxis<f64>>) = if picture.by_speed {
        let mut is_on = false;
        let places = changes.iter().filter(|(_, level)| {
            let switches = (*level > 0) != is_on;
            is_on = *level > 0;
            switches
        });
        let switches = switches(&played);
        (switches.into_iter().map(|(at, _)| at).collect(), places.map(|(place, _)| *place).collect())
    } else {
        let wanted: Vec<u16> = changes.iter().map(|(_, level)| *level).collect();
        let got: Vec<u16> = played.iter().map(|(_, duty)| *duty).collect();
        prop_assert_eq!(got, wanted);
        (played.into_iter().map(|(at, _)| at).collect(), changes.into_iter().map(|(place, _)| place).collect())
    };
    prop_assert_eq!(times.len(), places.len());
    let mut worst = 0.0_f64;
    for (at, wanted) in times.into_iter().zip(places) {
        let Some((there, velocity)) = ideal.machine(at) else {
            prop_assert!(false, "no motion at {at} ns");
            break;
        };
        let off = Axis::PRIMARY.map(|axis| there[axis] - wanted[axis]);
        let off = off.into_iter().map(|part| part * part).sum::<f64>().sqrt();
        prop_assert!(off < 0.01, "{off} mm from {wanted:?} at {at} ns, at {there:?}, {velocity:?}");
        worst = worst.max(off);
    }
    Ok(worst)
}

proptest! {
    #![proptest_config(cases(40))]

    #[test]
    fn every_edge_of_a_picture_is_at_its_place((picture, config) in pictures_on_machines(), feed in 0.1..2.0_f64) {
        let mut rig = with_laser(config, plain());
        rig.motion().set_overrides(feed, 1.0);
        picture.moves().0.iter().for_each(|request| rig.submit(request));
        rig.finish();
        worst_place(&rig, config, &picture)?;
        let counters = rig.motion().counters();
        prop_assert_eq!((counters.late, counters.swallowed), (0, 0));
    }

    #[test]
    fn a_picture_of_no_power_makes_the_same_steps(picture in pictures(), config in machines()) {
        let (moves, _) = picture.moves();
        let dark: Vec<Move> = moves.iter().map(|request| Move { power: Power { level: 0, ..request.power }, ..*request }).collect();
        let (lit, dark) = (run(config, plain(), &moves), run(config, plain(), &dark));
        prop_assert_eq!(duties(&dark), []);
        prop_assert!(steps(&lit) == steps(&dark), "steps differ");
    }

    #[test]
    fn delays_shift_edges_and_nothing_else((picture, config) in pictures_on_machines(), on in 0..400_000_i32, off in 0..400_000_i32) {
        // Every delay is longer than some pixels; lost ones are told.
        let (moves, _) = picture.moves();
        let plain_rig = run(config, plain(), &moves);
        let mut late = run(config, LaserConfig { on_delay: on, off_delay: off, ..plain() }, &moves);
        prop_assert!(steps(&plain_rig) == steps(&late), "steps differ");
        let (before, after) = (duties(&plain_rig), duties(&late));
        prop_assert!(after.windows(2).all(|pair| pair[0].0 <= pair[1].0), "in order");
        prop_assert_eq!(after.last().map_or(0, |last| last.1), 0);
        if late.motion().counters().swallowed == 0 {
            let (before, after) = (switches(&before), switches(&after));
            prop_assert_eq!(before.len(), after.len());
            for ((at, is_on), (then, _)) in before.into_iter().zip(after) {
                let shift = f64::from(if is_on { on } else { off }) * 5.0;
                prop_assert!((then - at - shift).abs() < 11.0, "{at} became {then}, not {shift} later");
            }
        }
    }
}

/// Pixels of 0.05 mm, every other one lit, at 500 mm/s.
fn long_row(by_speed: bool) -> Picture {
    let row = (0..3_000).map(|n| if n % 2 == 0 { 50_000 } else { 0 }).collect();
    Picture { rows: std::vec![row], pixel: 0.05, overscan: 0.0, speed: 500.0, by_speed }
}

#[test]
fn three_thousand_pixels_take_no_longer_than_one_line() {
    for by_speed in [false, true] {
        let config = MotionConfig { queue_size: 64, ..printer() };
        let picture = long_row(by_speed);
        let rig = run(config, plain(), &picture.moves().0);
        let (first, last) = (rig.events.first().expect("steps").0, rig.events.last().expect("steps").0);
        let seconds = (last - first) as f64 / 200e6;
        let worst = worst_place(&rig, config, &picture).expect("in place");
        std::println!("3000 pixels: {seconds:.3} s, worst edge {:.2} um", worst * 1e3);
        assert!(seconds < 0.84, "{seconds} s");
    }
}

#[test]
fn without_a_laser_power_means_nothing_and_moves_stay_apart() {
    let (moves, _) = long_row(false).moves();
    let plain_moves: Vec<Move> = moves.iter().map(|request| Move { power: Power::OFF, ..*request }).collect();
    let run = |moves: &[Move]| {
        let mut rig = Rig::new(printer());
        moves.iter().for_each(|request| rig.submit(request));
        rig.finish();
        rig
    };
    let rig = run(&moves);
    let seconds = (rig.events.last().expect("steps").0 - rig.events[0].0) as f64 / 200e6;
    std::println!("3000 pixels as moves of their own: {seconds:.3} s");
    assert!(rig.events == run(&plain_moves).events && seconds > 0.84);
}

#[test]
fn progress_within_a_grown_block_is_told() {
    let mut rig = with_laser(printer(), plain());
    let picture = long_row(false);
    for request in &picture.moves().0 {
        rig.submit(request);
    }
    rig.motion().flush();
    let mut seen = std::vec![];
    while !rig.motion().is_idle() {
        rig.tick();
        let tag = rig.motion().passed().tag.0;
        if seen.last() != Some(&tag) {
            seen.push(tag);
        }
    }
    assert!(seen.is_sorted() && seen.len() > 200, "{} lines seen", seen.len());
}
