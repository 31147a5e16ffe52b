//! Energy for each millimetre, where power follows the speed.

use std::vec::Vec;

use proptest::prelude::*;
use units::{Axis, MmPerSecond, PerAxis};

use super::{by_speed, duties, machines, plain, raster::Picture, with_laser};
use crate::{
    MotionConfig, Move,
    tests::{
        laws::ideal,
        rig::{Rig, at, cases},
    },
};

/// Lines out and back from a point, in every direction.
fn star(speed: f64, level: u16) -> Vec<Move> {
    let spike = |n: usize| {
        let angle = n as f64 * 0.7;
        let out = at(8.0 * angle.cos(), 8.0 * angle.sin(), 0.0, 0.0);
        [out, at(0.0, 0.0, 0.0, 0.0)]
    };
    let feed = |target| Move { power: by_speed(level), ..Move::feed(target, MmPerSecond(speed)) };
    (0..5).flat_map(spike).map(feed).collect()
}

/// A spiral of short chords.
fn spiral(speed: f64, level: u16) -> Vec<Move> {
    let place = |n: usize| {
        let angle = n as f64 * 0.15;
        at(0.5 * angle * angle.cos(), 0.5 * angle * angle.sin(), 0.0, 0.0)
    };
    (1..150).map(|n| Move { power: by_speed(level), ..Move::feed(place(n), MmPerSecond(speed)) }).collect()
}

/// A photo: rows of pixels of every grey, there and back, away from the corners that shapers round.
fn photos() -> impl Strategy<Value = Picture> {
    let rows = (60_usize..150)
        .prop_flat_map(|width| prop::collection::vec(prop::collection::vec(3_000..30_000_u16, width..=width), 2..4));
    (rows, 0.05..0.3_f64, 40.0..300.0_f64).prop_map(|(rows, pixel, speed)| Picture {
        rows,
        pixel,
        overscan: 0.12 * speed,
        speed,
        by_speed: true,
    })
}

/// The least and the greatest energy for a millimetre, over windows of a millimetre, relative to what the
/// program asks for, everywhere the same.
fn energy(rig: &Rig, config: MotionConfig, speed: f64, level: u16) -> (f64, f64) {
    energy_of(rig, config, speed, |_| f64::from(level))
}

/// The same, where the program asks for the level that `asked` returns for a place.
fn energy_of(rig: &Rig, config: MotionConfig, speed: f64, asked: impl Fn(&PerAxis<f64>) -> f64) -> (f64, f64) {
    let (ideal, duties) = (ideal(rig, config), duties(rig));
    let step = 20_000.0;
    let (mut at, end) = (duties[0].0 - 1e6, duties.last().expect("power").0 + 1e6);
    let (mut index, mut duty) = (0, 0.0);
    let (mut way, mut sum, mut wanted) = (0.0, 0.0, 0.0);
    let (mut least, mut most) = (f64::INFINITY, 0.0_f64);
    while at < end {
        // Exact within the step: the duty may change in it.
        let mut from = at;
        while let Some((then, next)) = duties.get(index).filter(|(then, _)| *then < at + step) {
            sum += duty * (then - from) * 1e-9;
            (from, duty, index) = (*then, f64::from(*next) / 65_535.0, index + 1);
        }
        sum += duty * (at + step - from) * 1e-9;
        if let Some((place, velocity)) = ideal.machine(at + 0.5 * step) {
            let velocity = Axis::PRIMARY.map(|axis| velocity[axis]);
            let (made, level) =
                (velocity.iter().map(|part| part * part).sum::<f64>().sqrt() * step * 1e-9, asked(&place));
            // Dark ways are no part of a window.
            way += if level > 0.0 { made } else { 0.0 };
            wanted += made * level / 65_535.0;
        }
        at += step;
        if way >= 1.0 {
            let share = sum * speed / wanted;
            (least, most) = (least.min(share), most.max(share));
            (way, sum, wanted) = (0.0, 0.0, 0.0);
        }
    }
    (least, most)
}

proptest! {
    #![proptest_config(cases(16))]

    #[test]
    fn energy_for_a_millimetre_is_even(
        config in machines(), speed in 40.0..300.0_f64, level in 3_000..30_000_u16, feed in 0.1..2.0_f64, is_star in any::<bool>(),
    ) {
        let mut rig = with_laser(config, plain());
        rig.motion().set_overrides(feed, 1.0);
        let moves = if is_star { star(speed, level) } else { spiral(speed, level) };
        moves.iter().for_each(|request| rig.submit(request));
        rig.finish();
        let (least, most) = energy(&rig, config, speed, level);
        prop_assert!(least > 0.97 && most < 1.03, "{least} to {most} of the energy asked for");
    }

    #[test]
    fn a_photo_gets_the_energy_of_its_greys(photo in photos(), config in machines(), feed in 0.1..2.0_f64) {
        let mut rig = with_laser(config, plain());
        rig.motion().set_overrides(feed, 1.0);
        photo.moves().0.iter().for_each(|request| rig.submit(request));
        rig.finish();
        let (least, most) = energy_of(&rig, config, photo.speed, |place| photo.level_at(place));
        prop_assert!(least > 0.97 && most < 1.03, "{least} to {most} of the energy asked for");
    }
}

#[test]
fn the_override_of_power_scales_what_comes_next() {
    let config = crate::tests::rig::printer();
    let mut rig = with_laser(config, plain());
    rig.motion().set_power_override(0.5);
    star(100.0, 20_000).iter().for_each(|request| rig.submit(request));
    rig.finish();
    let (least, most) = energy(&rig, config, 100.0, 10_000);
    assert!(least > 0.97 && most < 1.03, "{least} to {most}");
    rig.motion().set_power_override(1e9);
    assert_eq!(rig.motion().power_override(), 10.0);
    rig.motion().set_power_override(f32::NAN);
    assert_eq!(rig.motion().power_override(), 0.0);
}
