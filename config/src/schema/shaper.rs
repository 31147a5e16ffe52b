//! `[input shaper]`

use super::build::{number, word};
use super::{Docs, Form, Section, Setting, Words};
use crate::machine::InputShaper;

/// The words of `shaper_type_x` and its like, and what they mean.
const SHAPERS: &Words = &Words(&["zv", "mzv", "zvd", "ei", "2hump_ei", "3hump_ei"]);

const fn shaper(word: usize) -> InputShaper {
    match word {
        0 => InputShaper::Zv,
        2 => InputShaper::Zvd,
        3 => InputShaper::Ei,
        4 => InputShaper::TwoHumpEi,
        5 => InputShaper::ThreeHumpEi,
        _ => InputShaper::Mzv,
    }
}

pub const INPUT_SHAPER: Section = Section {
    name: "input shaper",
    docs: Docs::new(
        "Moves X, Y and Z so that resonances of the frame cancel themselves. All axes then lag behind the plan by the \
              longest shaper's mean delay, about 0.2 (zv) to 0.8 (3hump_ei) periods of its resonance.",
    ),
    form: Form::Plain,
    settings: &[
        kind("shaper_type_x", |c, _, v| c.input_shapers[0].shaper = shaper(v), "Shaper of X."),
        frequency(
            "shaper_freq_x",
            |c, _, v| c.input_shapers[0].frequency_hz = some_frequency(v),
            "Resonance of X; 0: X is not shaped.",
        ),
        damping(
            "damping_ratio_x",
            |c, _, v| c.input_shapers[0].damping_ratio = v,
            "Damping ratio of the resonance of X.",
        ),
        kind("shaper_type_y", |c, _, v| c.input_shapers[1].shaper = shaper(v), "Shaper of Y."),
        frequency(
            "shaper_freq_y",
            |c, _, v| c.input_shapers[1].frequency_hz = some_frequency(v),
            "Resonance of Y; 0: Y is not shaped.",
        ),
        damping(
            "damping_ratio_y",
            |c, _, v| c.input_shapers[1].damping_ratio = v,
            "Damping ratio of the resonance of Y.",
        ),
        kind("shaper_type_z", |c, _, v| c.input_shapers[2].shaper = shaper(v), "Shaper of Z."),
        frequency(
            "shaper_freq_z",
            |c, _, v| c.input_shapers[2].frequency_hz = some_frequency(v),
            "Resonance of Z; 0: Z is not shaped.",
        ),
        damping(
            "damping_ratio_z",
            |c, _, v| c.input_shapers[2].damping_ratio = v,
            "Damping ratio of the resonance of Z.",
        ),
    ],
};

fn some_frequency(hertz: f64) -> Option<f64> {
    (hertz > 0.0).then_some(hertz)
}

const fn kind(key: &'static str, set: super::Set<usize>, summary: &'static str) -> Setting {
    word(key, "mzv", SHAPERS, set, summary).klipper("[input_shaper] shaper_type").velvet()
}

const fn frequency(key: &'static str, set: super::Set<f64>, summary: &'static str) -> Setting {
    number(key, "0", &(0.0, 1_000.0), set, summary)
        .unit("Hz")
        .typical(&(5.0, 200.0))
        .klipper("[input_shaper] shaper_freq_<axis>")
        .velvet()
}

const fn damping(key: &'static str, set: super::Set<f64>, summary: &'static str) -> Setting {
    number(key, "0.1", &(0.0, 0.99), set, summary).klipper("[input_shaper] damping_ratio_<axis>").velvet()
}
