//! Findings about a bed from its mesh, in words that a person can act on.

use core::fmt::{self, Write as _};

use heapless::String;

use super::form::Form;

/// Least deviation, mm, that is worth a sentence.
const WORTH_SAYING: f64 = 0.02;
/// Least deviation, mm, at which mending a bed is better than following it.
const WORTH_MENDING: f64 = 0.1;
/// Greatest ratio of the bends along both axes at which the bed counts as bent along a single axis.
const ONE_WAY: f64 = 0.35;

/// A sentence of the findings.
pub type Sentence = String<160>;

/// Means of leveling that a machine has, on which the advice depends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Means {
    /// Number of Z motors that turn alone: G34.
    pub z_motors: usize,
    /// Whether the places of bed screws are known: G35.
    pub screws: bool,
}

/// Returns the sentence of a mesh with this number, from 0; `None` behind the last.
#[must_use]
pub fn sentence(form: &Form, means: Means, number: usize) -> Option<Sentence> {
    let mut text = Sentence::new();
    // Every sentence fits: see the test.
    let written = match number {
        0 => ends(&mut text, form),
        1 => tilt(&mut text, form),
        2 => bend(&mut text, form),
        3 => rest(&mut text, form),
        4 => advice(&mut text, form, means),
        _ => return None,
    };
    written.ok().map(|()| text)
}

fn ends(text: &mut Sentence, form: &Form) -> fmt::Result {
    let ([hx, hy, high], [lx, ly, low]) = (form.highest, form.lowest);
    write!(
        text,
        "Highest {high:.3} mm at X{hx:.1} Y{hy:.1}, lowest {low:.3} mm at X{lx:.1} Y{ly:.1}: {:.3} mm apart",
        form.range()
    )
}

fn tilt(text: &mut Sentence, form: &Form) -> fmt::Result {
    let [right, rear] = form.tilt;
    let is_said = |mm: f64| libm::fabs(mm) >= WORTH_SAYING;
    if !is_said(right) && !is_said(rear) {
        return write!(text, "Tilt: none worth mending");
    }
    write!(text, "Tilt: ")?;
    if is_said(right) {
        write!(text, "the {} side is {:.3} mm higher", if right > 0.0 { "right" } else { "left" }, libm::fabs(right))?;
    }
    if is_said(rear) {
        let and = if is_said(right) { ", " } else { "" };
        write!(text, "{and}the {} is {:.3} mm higher", if rear > 0.0 { "rear" } else { "front" }, libm::fabs(rear))?;
    }
    Ok(())
}

fn bend(text: &mut Sentence, form: &Form) -> fmt::Result {
    let [x, y] = form.bend;
    let [across, along] = form.bend.map(libm::fabs);
    if across < WORTH_SAYING && along < WORTH_SAYING {
        return write!(text, "Bend: none worth mending");
    }
    write!(text, "Bend: ")?;
    let word = |mm: f64| if mm > 0.0 { "higher" } else { "lower" };
    if across <= ONE_WAY * along {
        write!(text, "from front to rear the bed is {:.3} mm {} in the middle than at its ends", along, word(y))
    } else if along <= ONE_WAY * across {
        write!(text, "from left to right the bed is {:.3} mm {} in the middle than at its ends", across, word(x))
    } else if x * y > 0.0 {
        let shape = if x > 0.0 { "domed" } else { "hollow" };
        write!(
            text,
            "the bed is {shape} by {:.3} mm: so much {} in the middle than at its corners",
            across + along,
            word(x)
        )
    } else {
        write!(
            text,
            "the bed is a saddle: in the middle {across:.3} mm {} than left and right, {along:.3} mm {} than front and rear",
            word(x),
            word(y)
        )
    }
}

fn rest(text: &mut Sentence, form: &Form) -> fmt::Result {
    let twist = libm::fabs(form.twist);
    if twist >= WORTH_SAYING {
        let corners = if form.twist > 0.0 { "front left and rear right" } else { "front right and rear left" };
        write!(text, "Twist: the corners {corners} are {twist:.3} mm higher than the others; ")?;
    }
    write!(text, "What is left beside that: {:.3} mm (standard deviation)", form.rest)
}

fn advice(text: &mut Sentence, form: &Form, means: Means) -> fmt::Result {
    let (tilted, bent) = (form.tilt_range(), libm::fabs(form.bend[0]) + libm::fabs(form.bend[1]));
    let twisted = libm::fabs(form.twist);
    if form.range() < WORTH_MENDING {
        return write!(text, "To do: nothing, the mesh takes care of the rest");
    }
    if twisted >= WORTH_MENDING && twisted >= tilted && means.z_motors >= 4 {
        return write!(text, "To do: G34 takes out the twist and the tilt, then measure again");
    }
    if tilted >= WORTH_MENDING && tilted >= bent {
        return match means {
            Means { z_motors: 2.., .. } => {
                write!(text, "To do: G34 turns the Z motors until the bed is level, then measure again")
            }
            Means { screws: true, .. } => {
                write!(text, "To do: G35 says how far to turn each screw, then measure again")
            }
            _ => write!(
                text,
                "To do: level the bed by its screws ([bed screws] and G35 say how far), then measure again"
            ),
        };
    }
    if bent >= WORTH_MENDING {
        let how = if form.dome() > 0.0 {
            "heat the bed through and look for what pushes it up"
        } else {
            "heat the bed through and look at its clamps"
        };
        return write!(text, "To do: {how}; the mesh follows what is left");
    }
    if twisted >= WORTH_MENDING {
        return write!(text, "To do: look whether bed and gantry stand without strain; the mesh follows what is left");
    }
    write!(text, "To do: look for dirt under the probe or on the bed; the mesh follows what is left")
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn told(form: &Form, means: Means) -> std::string::String {
        (0..).map_while(|number| sentence(form, means, number)).map(|text| std::format!("{text}\n")).collect()
    }

    fn flat() -> Form {
        Form { highest: [10.0, 20.0, 0.01], lowest: [30.0, 40.0, -0.01], ..Form::default() }
    }

    #[test]
    fn a_flat_bed_needs_nothing() {
        let text = told(&flat(), Means::default());
        assert!(text.starts_with("Highest 0.010 mm at X10.0 Y20.0, lowest -0.010 mm at X30.0 Y40.0: 0.020 mm apart\n"));
        assert!(
            text.contains("Tilt: none") && text.contains("Bend: none") && text.contains("To do: nothing"),
            "{text}"
        );
    }

    #[test]
    fn a_tilt_is_mended_by_what_the_machine_has() {
        let form = Form { tilt: [0.3, -0.1], highest: [200.0, 0.0, 0.3], ..flat() };
        let with = |z_motors, screws| told(&form, Means { z_motors, screws });
        let text = with(1, false);
        assert!(text.contains("Tilt: the right side is 0.300 mm higher, the front is 0.100 mm higher\n"), "{text}");
        assert!(text.contains("[bed screws] and G35"), "{text}");
        assert!(with(1, true).contains("To do: G35 says") && with(3, true).contains("To do: G34 turns"));
    }

    #[test]
    fn a_bend_has_its_name() {
        let of = |bend| told(&Form { bend, highest: [0.0, 0.0, 0.3], ..flat() }, Means::default());
        assert!(of([0.1, 0.11]).contains("Bend: the bed is domed by 0.210 mm: so much higher in the middle"));
        assert!(of([-0.1, -0.11]).contains("hollow by 0.210 mm: so much lower in the middle"));
        assert!(of([0.2, 0.01]).contains("from left to right the bed is 0.200 mm higher in the middle"));
        assert!(of([0.01, -0.2]).contains("from front to rear the bed is 0.200 mm lower in the middle"));
        assert!(
            of([0.1, -0.2]).contains("a saddle: in the middle 0.100 mm higher than left and right, 0.200 mm lower")
        );
        assert!(of([0.1, 0.1]).contains("To do: heat the bed through"));
        let twisted = Form { twist: -0.4, highest: [0.0, 0.0, 0.3], ..flat() };
        assert!(told(&twisted, Means::default()).contains("Twist: the corners front right and rear left are 0.400 mm"));
        assert!(told(&twisted, Means { z_motors: 4, screws: false }).contains("To do: G34 takes out the twist"));
    }

    proptest! {
        #[test]
        fn every_sentence_is_whole(
            numbers in prop::array::uniform12(-9.0..9.0_f64), far in 100.0..9999.0_f64, z_motors in 0_usize..5, screws: bool,
        ) {
            let [a, b, c, d, e, f, g, h, i, j, k, l] = numbers;
            let form = Form { highest: [-far, -far, a], lowest: [-far, -far, b], mean: c, tilt: [d, e], twist: f + g, bend: [h, i + j], rest: k * k + l };
            prop_assert_eq!(told(&form, Means { z_motors, screws }).lines().count(), 5);
        }
    }
}
