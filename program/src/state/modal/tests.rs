//! Properties that hold for all offsets.

use super::*;
use proptest::prelude::*;

fn modal() -> Modal {
    Modal::new(MmPerSecond(50.0), MmPerSecond(100.0))
}

proptest! {
    /// Work and machine coordinates convert back and forth for all offsets.
    #[test]
    fn work_and_machine_coordinates_are_inverse(
        offsets in proptest::array::uniform3(-500.0..500.0_f64), word in -500.0..500.0_f64,
    ) {
        let mut modal = modal();
        modal.systems[0][0] = offsets[0];
        modal.g92[0] = offsets[1];
        modal.tool_offset[0] = offsets[2];
        let mut machine = PerAxis([0.0; 6]);
        machine[Axis::X] = modal.machine(Axis::X, word, 12.0);
        let back = modal.work(&machine)[Axis::X];
        prop_assert!((back - word).abs() < 1e-9, "{word} came back as {back}");
    }

    /// After G92 and after G10 L20 the position reads as given, at every machine position.
    #[test]
    fn g92_and_g10_l20_make_the_position_read_as_given(
        place in -500.0..500.0_f64, reading in -500.0..500.0_f64, before in -500.0..500.0_f64,
        degrees in prop_oneof![Just(0.0), -360.0..360.0_f64],
    ) {
        for use_g92 in [true, false] {
            let mut modal = modal();
            modal.system = 3;
            modal.systems[3][1] = before;
            modal.g92[1] = before / 2.0;
            modal.rotations.set(3, degrees);
            let machine = PerAxis([12.0, place, 7.0, 0.0, 0.0, 0.0]);
            let [x, _, z, ..] = modal.work(&machine).0;
            if use_g92 {
                modal.set_g92(Axis::Y, reading, &machine);
            } else {
                modal.set_system_here(3, [None, Some(reading), None], &machine);
            }
            let work = modal.work(&machine);
            prop_assert!((work[Axis::Y] - reading).abs() < 1e-9, "{reading} reads {}", work[Axis::Y]);
            prop_assert!((work[Axis::X] - x).abs() < 1e-9 && (work[Axis::Z] - z).abs() < 1e-9);
        }
    }

    /// Positions convert back and forth under every rotation, and lengths stay the same.
    #[test]
    fn a_turned_system_goes_to_the_machine_and_back(
        offsets in proptest::array::uniform6(-500.0..500.0_f64), words in proptest::array::uniform2(-500.0..500.0_f64),
        degrees in -720.0..720.0_f64,
    ) {
        let mut modal = modal();
        let [sx, sy, gx, gy, tx, ty] = offsets;
        modal.systems[0] = [sx, sy, 0.0];
        modal.g92 = [gx, gy, 0.0];
        modal.tool_offset = [tx, ty, 0.0];
        modal.rotations.set(0, degrees);
        let place = |[x, y]: [f64; 2]| PerAxis([x, y, 0.0, 0.0, 0.0, 0.0]);
        let machine = modal.target_xy(words.map(Some), [3.0, 4.0]);
        let [x, y, ..] = modal.work(&place(machine)).0;
        prop_assert!((x - words[0]).abs() < 1e-8 && (y - words[1]).abs() < 1e-8);
        // A single word leaves the other coordinate as it was.
        let along = modal.target_xy([Some(words[0] + 10.0), None], machine);
        let [x, y, ..] = modal.work(&place(along)).0;
        prop_assert!((x - words[0] - 10.0).abs() < 1e-8 && (y - words[1]).abs() < 1e-8);
        modal.absolute = false;
        let relative = modal.target_xy([Some(10.0), None], machine);
        prop_assert!((relative[0] - along[0]).abs() < 1e-8 && (relative[1] - along[1]).abs() < 1e-8);
        let way = (along[0] - machine[0]).hypot(along[1] - machine[1]);
        prop_assert!((way - 10.0).abs() < 1e-8, "{way}");
    }
}

#[test]
fn relative_words_add_to_the_machine_position_and_g53_ignores_offsets() {
    let mut modal = modal();
    modal.systems[0][0] = 10.0;
    assert_eq!(modal.machine(Axis::X, 5.0, 100.0), 15.0);
    modal.absolute = false;
    assert_eq!(modal.machine(Axis::X, 5.0, 100.0), 105.0);
    modal.machine_next = true;
    assert_eq!(modal.machine(Axis::X, 5.0, 100.0), 5.0);
}

#[test]
fn coordinate_systems_are_named_as_programs_name_them() {
    let names: Vec<String> = (0..COORDINATE_SYSTEMS)
        .map(|system| {
            let mut name = String::new();
            write_system_name(&mut name, system).unwrap();
            name
        })
        .collect();
    assert_eq!(names, ["G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"]);
}
