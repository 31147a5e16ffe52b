//! Moves of the program, submitted to motion as [`parts::drawing`] draws them.

use core::fmt::Arguments;

use base::Ports;
use base::failure::Failure;
use base::own_frame::apart;
use base::reason::Reason;
use base::safety::Event;
use config::MachineConfig;
use motion::geometry::LineSettings;
use motion::path::Bounds;
use parts::drawing::{self, Draws};
use program::{Interpreter, Move, Shape, State};
use units::PerAxis;

use crate::machine::Machine;
use crate::machine::moments::{Features, Moments as _};

/// Returns a move of the program in motion's terms, without its curve.
pub(crate) fn in_motions_terms<P: Ports>(machine: &mut Machine<'_, P>, request: &Move) -> motion::Move {
    let (ports, part) = (&mut machine.world.ports, machine.jobs.objects.part());
    // A tap, and a move under M49, have their own speed alone.
    let factors =
        if machine.feed_waits.is_some() { [1.0; 2] } else { program::speed_factor::of_moves(&machine.program) };
    let whole = drawing::in_motions_terms(request, machine.tag, factors, || {
        ports.motion(|motion| motion.config().map_or(0.0, |config| config.limits.junction_deviation.get()))
    });
    motion::Move { part, ..whole }
}

/// Submits the commonest move of all: straight, whole, while the look-ahead queue has room. False: nothing
/// has been done, and [`submit`] does it, or says why not.
pub(crate) fn take_at_once<P: Ports>(machine: &mut Machine<'_, P>, request: &Move) -> bool {
    let is_whole = matches!(request.shape, Shape::Line { .. }) && !machine.tuning.lines.cut();
    let is_whole = is_whole && !program::objects::is_apart(&machine.program) && !machine.cut.brakes;
    let is_free = machine.safety.state() != State::Check && machine.axes.are_enabled();
    let is_free = is_free && !machine.tuning.guards_cold;
    if !is_whole || !is_free || machine.may_move().is_err() || !machine.reaches(&request.target) {
        return false;
    }
    let own = in_motions_terms(machine, request);
    let is_taken = machine.world.ports.motion(|motion| motion.submit(&own)).is_ok();
    if is_taken {
        machine.safety.apply(Event::Started);
    }
    is_taken
}

/// Submits a move of the program.
pub(crate) fn submit<P: Ports>(machine: &mut Machine<'_, P>, request: &Move) -> Result<(), Failure> {
    let from = machine.world.ports.motion(|motion| motion.commanded_position());
    let own = in_motions_terms(machine, request);
    let drawn = apart(|| drawing::draw(&mut Drawing(machine), from, request, own))?;
    for piece in drawn {
        machine.submit(&piece)?;
    }
    Ok(())
}

/// The machine as [`Draws`] sees it while a move is drawn.
struct Drawing<'a, 'm, P: Ports>(&'a mut Machine<'m, P>);

impl<P: Ports> Draws for Drawing<'_, '_, P> {
    type Failure = Failure;

    fn config(&self) -> &MachineConfig {
        self.0.world.config
    }

    fn program(&self) -> &Interpreter {
        &self.0.program
    }

    fn line_settings(&self) -> LineSettings {
        self.0.tuning.lines
    }

    fn bends(&mut self) -> bool {
        self.0.world.ports.motion(|motion| motion.config().is_some_and(|config| !config.kinematics.is_linear()))
    }

    fn wrong(&mut self, what: Arguments<'_>) -> Failure {
        self.0.world.texts.alarm(what).with_reason(Reason::Target)
    }

    fn line_may_be(&mut self, from: &PerAxis<f64>, to: &PerAxis<f64>) -> Result<(), Failure> {
        self.0.stays_within(from, to)
    }

    fn curve_may_be(&mut self, from: &PerAxis<f64>, bounds: &Bounds) -> Result<(), Failure> {
        self.0.curve_stays_within(from, bounds)
    }
}

/// Makes a move of the program, and waits for room. A refused move leaves the program where the machine is.
///
/// # Errors
/// For a move that is refused, and when the machine halts.
pub(crate) fn go_along<P: Ports>(machine: &mut Machine<'_, P>, request: &Move) -> Result<(), Failure> {
    let may_move = machine.may_move().and_then(|()| Features::<P>::may_move(machine, request));
    let moved = match may_move.and_then(|()| machine.rest_stays_within(&request.target)) {
        Ok(()) => submit(machine, request),
        Err(failure) => Err(failure),
    };
    if moved.is_err() {
        machine.program.take_back();
        machine.resynchronise_if_still();
    }
    moved
}
