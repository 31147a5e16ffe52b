//! Moves of the program, submitted to motion as [`parts::drawing`] draws them.

use core::fmt::Arguments;

use base::Ports;
use base::failure::Failure;
use base::own_frame::apart;
use base::ports::MotionPort;
use base::reason::Reason;
use base::safety::Event;
use config::MachineConfig;
use motion::Tag;
use motion::geometry::LineSettings;
use motion::laser::Power;
use motion::path::Bounds;
use parts::drawing::{self, Draws};
use program::{Interpreter, Move, Shape, State};
use units::PerAxis;

use crate::machine::Machine;
use crate::machine::moments::{Features, Moments as _};
use crate::machine::work_hands::JobHands;

/// The machine for moves of the program.
pub(crate) trait DrawHands<'c>: JobHands<'c> {
    /// Returns what moves have of the line and the object that they are made for.
    fn label(&self) -> Label;

    /// Returns the interpreter, whose arc settings count.
    fn interpreter(&self) -> &Interpreter;

    /// Returns how straight moves are divided into segments.
    fn line_settings(&self) -> LineSettings;

    /// Whether planned moves are being dropped.
    fn brakes(&self) -> bool;

    /// Whether moves are taken: where the configuration asks for it, only once the machine is homed.
    ///
    /// # Errors
    /// When it is not.
    fn may_move(&self) -> Result<(), Failure>;

    /// Has features refuse a move.
    ///
    /// # Errors
    /// With the reason.
    fn may_make(&mut self, request: &Move) -> Result<(), Failure>;

    /// Whether a place is within the travel, so that a straight move there leaves it nowhere.
    fn reaches(&mut self, place: &PerAxis<f64>) -> bool;

    /// Whether a curve that goes this far along the axes stays within the travel.
    ///
    /// # Errors
    /// Where it does not, with the axis.
    fn curve_stays_within(&mut self, from: &PerAxis<f64>, bounds: &Bounds) -> Result<(), Failure>;

    /// Whether the moves behind a block's first stay within the travel.
    ///
    /// # Errors
    /// Where one does not, with the axis.
    fn rest_stays_within(&mut self, first: &PerAxis<f64>) -> Result<(), Failure>;

    /// Submits a move, waiting while the look-ahead queue is full.
    ///
    /// # Errors
    /// When it is refused, or the machine halts.
    fn submit(&mut self, request: &motion::Move) -> Result<(), Failure>;
}

/// What moves have of the line and the object that they are made for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Label {
    tag: Tag,
    part: u8,
    /// Operator's factors do not count: a tap, and a move under M49, have their own speed alone.
    is_own_speed: bool,
}

impl<'c, P: Ports> DrawHands<'c> for Machine<'c, P> {
    fn label(&self) -> Label {
        Label { tag: self.tag, part: self.jobs.objects.part(), is_own_speed: self.feed_waits.is_some() }
    }

    fn interpreter(&self) -> &Interpreter {
        &self.program
    }

    fn line_settings(&self) -> LineSettings {
        self.tuning.lines
    }

    fn brakes(&self) -> bool {
        self.cut.brakes
    }

    fn may_move(&self) -> Result<(), Failure> {
        if self.world.config.motion.must_be_homed && !self.facts().all_homed() {
            return Err(Failure::alarm(&"Must be homed before moving"));
        }
        Ok(())
    }

    fn may_make(&mut self, request: &Move) -> Result<(), Failure> {
        Features::<P>::may_move(self, request)
    }

    fn reaches(&mut self, place: &PerAxis<f64>) -> bool {
        let homed = self.axes.homed();
        self.travel().has(place, homed)
    }

    fn curve_stays_within(&mut self, from: &PerAxis<f64>, bounds: &Bounds) -> Result<(), Failure> {
        let homed = self.axes.homed();
        self.travel().check_bounds(from, bounds, homed).map_err(|out| out.failure(self.world.texts, self.world.config))
    }

    fn rest_stays_within(&mut self, first: &PerAxis<f64>) -> Result<(), Failure> {
        let (travel, mut from) = (self.safety.travel.up_to_date(self.world.config, &self.tuning), *first);
        for to in &self.program.moves_to_come() {
            travel
                .check(&from, to, self.axes.homed())
                .map_err(|out| out.failure(self.world.texts, self.world.config))?;
            from = *to;
        }
        Ok(())
    }

    fn submit(&mut self, request: &motion::Move) -> Result<(), Failure> {
        self.submit(request)
    }
}

/// Returns a move of the program in motion's terms, without its curve.
pub(crate) fn in_motions_terms(
    label: Label,
    program: &Interpreter,
    ports: &mut impl MotionPort,
    request: &Move,
    power: Power,
) -> motion::Move {
    let factors = if label.is_own_speed { [1.0; 2] } else { program::speed_factor::of_moves(program) };
    let whole = drawing::in_motions_terms(request, label.tag, factors, power, || {
        ports.motion(|motion| motion.config().map_or(0.0, |config| config.limits.junction_deviation.get()))
    });
    motion::Move { part: label.part, ..whole }
}

/// Returns a move as it is made now, in motion's terms, without its curve.
pub(crate) fn made_now<'c>(hands: &mut impl DrawHands<'c>, request: &Move) -> motion::Move {
    let (label, power) = (hands.label(), hands.tuning().laser.power(request));
    let (program, world) = hands.program_in_world();
    in_motions_terms(label, program, &mut world.ports, request, power)
}

/// Submits the commonest move of all: straight, whole, while the look-ahead queue has room. False: nothing
/// has been done, and [`submit`] does it, or says why not.
pub(crate) fn take_at_once<'c>(hands: &mut impl DrawHands<'c>, request: &Move) -> bool {
    let is_whole = matches!(request.shape, Shape::Line { .. }) && !hands.tuning().lines.cut();
    let is_whole = is_whole && !program::objects::is_apart(hands.program()) && !hands.brakes();
    let is_free = hands.state() != State::Check && hands.axes().are_enabled();
    let is_free = is_free && !hands.tuning().guards_filament;
    if !is_whole || !is_free || hands.may_move().is_err() || !hands.reaches(&request.target) {
        return false;
    }
    let own = made_now(hands, request);
    let is_taken = hands.world().ports.motion(|motion| motion.submit(&own)).is_ok();
    if is_taken {
        hands.apply(Event::Started);
    }
    is_taken
}

/// Submits a move of the program.
pub(crate) fn submit<'c>(hands: &mut impl DrawHands<'c>, request: &Move) -> Result<(), Failure> {
    let from = hands.world().ports.motion(|motion| motion.commanded_position());
    let own = made_now(hands, request);
    let config = hands.world().config;
    let drawn = apart(|| drawing::draw(&mut Drawing { hands: &mut *hands, config }, from, request, own))?;
    for piece in drawn {
        hands.submit(&piece)?;
    }
    Ok(())
}

/// The machine as [`Draws`] sees it while a move is drawn.
struct Drawing<'a, 'c, H: DrawHands<'c>> {
    hands: &'a mut H,
    config: &'c MachineConfig,
}

impl<'c, H: DrawHands<'c>> Draws for Drawing<'_, 'c, H> {
    type Failure = Failure;

    fn config(&self) -> &MachineConfig {
        self.config
    }

    fn program(&self) -> &Interpreter {
        self.hands.interpreter()
    }

    fn line_settings(&self) -> LineSettings {
        self.hands.line_settings()
    }

    fn bends(&mut self) -> bool {
        let ports = &mut self.hands.world().ports;
        ports.motion(|motion| motion.config().is_some_and(|config| !config.kinematics.is_linear()))
    }

    fn wrong(&mut self, what: Arguments<'_>) -> Failure {
        self.hands.world().texts.alarm(what).with_reason(Reason::Target)
    }

    fn line_may_be(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Failure> {
        self.hands.stays_within(from, to)
    }

    fn curve_may_be(&mut self, from: &PerAxis<f64>, bounds: &Bounds) -> Result<(), Failure> {
        self.hands.curve_stays_within(from, bounds)
    }
}

/// Makes a move of the program, and waits for room. A refused move leaves the program where the machine is.
///
/// # Errors
/// For a move that is refused, and when the machine halts.
pub(crate) fn go_along<'c>(hands: &mut impl DrawHands<'c>, request: &Move) -> Result<(), Failure> {
    let may_move = hands.may_move().and_then(|()| hands.may_make(request));
    let moved = match may_move.and_then(|()| hands.rest_stays_within(&request.target)) {
        Ok(()) => submit(hands, request),
        Err(failure) => Err(failure),
    };
    if moved.is_err() {
        hands.program().take_back();
        hands.resynchronise_if_still();
    }
    moved
}
