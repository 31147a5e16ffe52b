//! Properties that hold for every canned cycle.

use gcode::{Code, Decoder, Line};
use proptest::prelude::*;
use units::{Axis, AxisSet, MmPerSecond, PerAxis, Plane, SwitchId};

use crate::state::cycle::drilling_axis;
use crate::{Action, Claim, Dialect, Facts, Fault, Interpreter, Meaning, Move, Rate, Setup, Spindle};

const FACTS: Facts = Facts { homed: AxisSet::PRIMARY, can_home: AxisSet::PRIMARY, probe_height: 0.0 };

fn program() -> Interpreter {
    let mut setup = Setup { feed_rate: MmPerSecond(5.0), seek_rate: MmPerSecond(50.0), ..Setup::default() };
    for code in [3, 4, 5] {
        // Two outputs: one turns the spindle, the other releases its brake.
        for switch in [0, 1].map(SwitchId) {
            let claim = if code == 5 { Claim::SwitchOff(switch) } else { Claim::SwitchOn(switch) };
            assert!(setup.claims.add(Code::m(code), claim));
        }
    }
    Interpreter::new(setup)
}

/// Returns the first action of a line; the actions of earlier codes of the line are taken.
fn begin(program: &mut Interpreter, line: &str) -> Result<Option<Action<'static>>, Fault> {
    let mut decoder = Decoder::new();
    let Ok(Line::Code(blocks)) = decoder.decode(line.as_bytes()) else { panic!("{line}") };
    let mut first = None;
    for block in blocks {
        let block = block.unwrap();
        let row = program.row(&block, Dialect::Smoothie).unwrap();
        first = match program.run(&block, row, FACTS, Dialect::Grbl)? {
            Meaning::Action(Action::Move(request)) => Some(Action::Move(request)),
            Meaning::Action(Action::Dwell(time)) => Some(Action::Dwell(time)),
            _ => first,
        };
    }
    Ok(first)
}

/// Returns all actions of a line.
fn run(program: &mut Interpreter, line: &str) -> Vec<Action<'static>> {
    let first = begin(program, line).unwrap_or_else(|fault| panic!("{line}: {fault}"));
    first.into_iter().chain(std::iter::from_fn(|| program.next_action())).collect()
}

fn moves(actions: &[Action<'static>]) -> Vec<Move> {
    let request = |action: &Action<'_>| if let Action::Move(request) = action { Some(*request) } else { None };
    actions.iter().filter_map(request).collect()
}

const fn is_rapid(request: &Move) -> bool {
    matches!(request.rate, Rate::Rapid(_))
}

/// Returns the smallest box around positions.
fn around(places: impl IntoIterator<Item = PerAxis<f64>>) -> [PerAxis<f64>; 2] {
    let mut ends = [PerAxis([f64::INFINITY; 6]), PerAxis([f64::NEG_INFINITY; 6])];
    for place in places {
        for axis in Axis::ALL {
            ends[0][axis] = ends[0][axis].min(place[axis]);
            ends[1][axis] = ends[1][axis].max(place[axis]);
        }
    }
    ends
}

#[derive(Clone, Debug)]
struct Any {
    code: u16,
    plane: Plane,
    retract: u16,
    is_relative: bool,
    start: f64,
    /// R, and the depth below it.
    r: f64,
    depth: f64,
    peck: f64,
    holes: u32,
}

impl Any {
    /// Writes the cycle as a line, for a program at the start.
    fn line(&self) -> String {
        let along = drilling_axis(self.plane).letter();
        let [over, beside] = match self.plane {
            Plane::Xy => ['X', 'Y'],
            Plane::Xz => ['X', 'Z'],
            Plane::Yz => ['Y', 'Z'],
        };
        let (distance, r, bottom) = if self.is_relative {
            ("G91", self.r - self.start, -self.depth)
        } else {
            ("G90", self.r, self.r - self.depth)
        };
        let words = match self.code {
            73 | 83 => format!(" Q{}", self.peck),
            82 | 86 | 88 | 89 => " P0.5".to_string(),
            _ => String::new(),
        };
        let (code, retract, holes) = (self.code, self.retract, self.holes);
        format!("{distance} G{retract} G{code} {over}3 {beside}4 {along}{bottom} R{r}{words} L{holes}")
    }

    fn started(&self) -> Interpreter {
        let mut program = program();
        let g = match self.plane {
            Plane::Xy => 17,
            Plane::Xz => 18,
            Plane::Yz => 19,
        };
        let spindle = if self.code == 74 { 4 } else { 3 };
        run(&mut program, &format!("M{spindle} G{g} G0 {}{}", drilling_axis(self.plane).letter(), self.start));
        while program.next_effect().is_some() {}
        program
    }

    fn pecks(&self) -> usize {
        if matches!(self.code, 73 | 83) { (self.depth / self.peck - 1e-6).ceil().max(1.0) as usize } else { 1 }
    }

    /// Returns the height to which a hole is left.
    fn clear(&self) -> f64 {
        if self.retract == 98 { self.r.max(self.start) } else { self.r }
    }
}

/// Generates cycles whose depths far exceed the rounding of a peck.
fn any_cycle() -> impl Strategy<Value = Any> {
    let codes = prop::sample::select(vec![73_u16, 74, 81, 82, 83, 84, 85, 86, 88, 89]);
    let planes = prop::sample::select(vec![Plane::Xy, Plane::Xz, Plane::Yz]);
    let heights = (-20.0..20.0_f64, -20.0..20.0_f64, 0.01..30.0_f64, 0.3..10.0_f64);
    (codes, planes, 98..=99_u16, any::<bool>(), heights, 1..4_u32).prop_map(
        |(code, plane, retract, is_relative, (start, r, depth, peck), holes)| {
            // Rounds to a hundredth, as programs are written, so that Q divides depths too.
            let [start, r, depth, peck] = [start, r, depth, peck].map(|mm| (mm * 100.0).round() / 100.0);
            Any { code, plane, retract, is_relative, start, r, depth, peck, holes }
        },
    )
}

const ROUNDING: f64 = 1e-9;

proptest! {
    /// Cycles cut to Z in every hole and no deeper, leave each hole to the right height, and never move
    /// rapidly into uncut material.
    #[test]
    fn every_hole_is_cut_to_its_bottom_and_left_as_it_should_be(cycle in any_cycle()) {
        let (mut program, along) = (cycle.started(), drilling_axis(cycle.plane));
        let all = moves(&run(&mut program, &cycle.line()));
        let (bottom, clear) = (cycle.r - cycle.depth, cycle.clear());
        prop_assert_eq!(*program.position(), all.last().unwrap().target);
        prop_assert!((program.position()[along] - clear).abs() < ROUNDING);
        let (mut deepest, mut finished) = (cycle.r, 0);
        let (mut height, mut over) = (cycle.start, PerAxis([0.0; 6]));
        for request in &all {
            let (to, mut beside) = (request.target[along], request.target);
            beside[along] = 0.0;
            if beside != over {
                prop_assert!(is_rapid(request) && height >= cycle.r - ROUNDING, "goes over at {height}");
                (deepest, over) = (cycle.r, beside);
            } else if is_rapid(request) {
                prop_assert!(to >= deepest - ROUNDING, "rapid to {to}, cut to {deepest}");
            } else if to < height {
                let peck = if cycle.pecks() > 1 { cycle.peck } else { cycle.depth };
                prop_assert!(to >= deepest - peck * (1.0 + 1e-5) - ROUNDING, "{to} is more than a peck below {deepest}");
                deepest = deepest.min(to);
                finished += usize::from((to - bottom).abs() < 1e-5);
                prop_assert!(to >= bottom - ROUNDING);
            }
            height = to;
        }
        prop_assert_eq!(finished, cycle.holes as usize);
    }

    /// Cycles have as many moves as the standard says, apart from moves of no length.
    #[test]
    fn it_has_the_moves_of_the_standard(cycle in any_cycle()) {
        let mut program = cycle.started();
        let actions = run(&mut program, &cycle.line());
        let pecks = cycle.pecks();
        let lift = usize::from(cycle.start < cycle.r);
        // Moves over the hole, unless the same hole is drilled again; then down to R, unless the tool is
        // there.
        let over = if cycle.is_relative { cycle.holes as usize } else { 1 };
        let clear_is_r = cycle.clear() <= cycle.r;
        let down = if cycle.start <= cycle.r { 0 } else if clear_is_r { 1 } else { cycle.holes as usize };
        // Each peck but the last adds a move out and a move back, or the move back alone.
        let back = |peck: usize| usize::from(cycle.peck * peck as f64 > 0.254 + ROUNDING);
        let cut = match cycle.code {
            83 => pecks + (1..pecks).map(|peck| 1 + back(peck)).sum::<usize>(),
            73 => pecks + pecks - 1,
            _ => 1,
        };
        let leave = match cycle.code {
            85 if !clear_is_r => 2,
            _ => 1,
        };
        // Each hole has dwells, and changes of the spindle's outputs, overrides and operator.
        let others = match cycle.code {
            82 | 89 => 1,
            74 | 84 => 10,
            86 => 5,
            88 => 6,
            _ => 0,
        };
        let wanted = lift + over + down + cycle.holes as usize * (cut + leave);
        prop_assert_eq!(moves(&actions).len(), wanted, "{}", cycle.line());
        prop_assert_eq!(actions.len() - wanted, others * cycle.holes as usize);
        let spindle = if cycle.code == 74 { Spindle::CounterClockwise } else { Spindle::Clockwise };
        prop_assert_eq!(program.modal().auxiliary.spindle, spindle);
    }

    /// The predicted bounds match the moves at every action: no position lies outside, and the box is as
    /// small as possible.
    #[test]
    fn what_is_to_come_is_known_before_it_begins(cycle in any_cycle()) {
        let mut program = cycle.started();
        let mut action = begin(&mut program, &cycle.line()).unwrap();
        let all = moves(&run(&mut cycle.started(), &cycle.line()));
        let mut taken = 0;
        while let Some(now) = action {
            taken += moves(&[now]).len();
            let said = around(program.moves_to_come());
            let comes = around(all[taken..].iter().map(|request| request.target));
            prop_assert_eq!(program.is_last_action(), program.clone().next_action().is_none());
            for axis in Axis::ALL {
                prop_assert!(said[0][axis] <= comes[0][axis] + ROUNDING && said[1][axis] >= comes[1][axis] - ROUNDING);
            }
            if taken == 1 {
                let here = around(all.iter().map(|request| request.target).chain([all[0].target]));
                for axis in Axis::ALL {
                    prop_assert!(said[0][axis] >= here[0][axis] - ROUNDING && said[1][axis] <= here[1][axis] + ROUNDING);
                }
            }
            action = program.next_action();
        }
    }

    /// A refused move leaves the program's position at the end of the move before.
    #[test]
    fn a_refused_move_leaves_the_program_where_the_one_before_it_ended(cycle in any_cycle(), at in 0..20_usize) {
        let mut program = cycle.started();
        let mut end = *program.position();
        let mut action = begin(&mut program, &cycle.line()).unwrap();
        for _ in 0..at {
            if let Some(Action::Move(request)) = action {
                end = request.target;
            }
            let Some(next) = program.next_action() else { return Ok(()) };
            action = Some(next);
        }
        program.take_back();
        prop_assert_eq!(*program.position(), end);
        prop_assert!(program.is_last_action() && program.next_action().is_none());
        prop_assert_eq!(program.moves_to_come().len(), 0);
    }
}

#[test]
fn a_block_refused_at_its_first_move_leaves_the_words_that_held() {
    let mut program = program();
    run(&mut program, "G0 Z10");
    run(&mut program, "G99 G81 X1 Z-5 R2");
    let first = begin(&mut program, "X2 Z-50 R1").unwrap();
    assert!(matches!(first, Some(Action::Move(_))));
    program.take_back();
    let all = moves(&run(&mut program, "G98 X3"));
    assert_eq!(all.iter().map(|request| request.target[Axis::Z]).collect::<Vec<_>>(), [2.0, -5.0, 10.0]);
    // A block that was carried out in part leaves its words in force.
    begin(&mut program, "X4 Z-50").unwrap();
    program.next_action().unwrap();
    program.take_back();
    assert!(moves(&run(&mut program, "X5")).iter().any(|request| request.target[Axis::Z] == -50.0));
}

#[test]
fn words_that_are_no_places_are_refused() {
    let far = "9".repeat(200);
    for line in [format!("G81 X1 Z-{far}{far} R1"), format!("G20 G91 G81 X1 Z-{far}9 R{far} L2")] {
        let mut program = program();
        let first = begin(&mut program, &line);
        let is_far = |action: &Option<Action<'_>>| matches!(action, Some(Action::Move(request)) if !request.target.0.iter().all(|mm| mm.is_finite()));
        assert!(!first.as_ref().is_ok_and(is_far), "{line}: {first:?}");
    }
}

#[test]
fn a_halt_ends_cycles_and_what_held() {
    let mut program = program();
    run(&mut program, "G99 G81 X1 Z-5 R2");
    program.halt();
    assert_eq!(
        begin(&mut program, "X2").unwrap_err().to_string().split(':').next(),
        Some("no motion code is in force")
    );
    assert!(begin(&mut program, "G81 X2").unwrap_err().to_string().starts_with("G81 needs Z"));
}

#[test]
fn a_person_who_drills_while_a_job_is_suspended_leaves_its_words_alone() {
    let mut program = program();
    run(&mut program, "G0 Z10");
    run(&mut program, "G99 G81 X1 Z-5 R2");
    let kept = program.keep();
    run(&mut program, "G0 Z30");
    run(&mut program, "G98 G81 X50 Z-20 R3");
    program.come_back_to(kept);
    let depths = moves(&run(&mut program, "G98 X2")).iter().map(|request| request.target[Axis::Z]).collect::<Vec<_>>();
    assert!(depths.contains(&-5.0) && depths.last() == Some(&10.0), "{depths:?}");
}
