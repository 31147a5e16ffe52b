//! Messages to the operator, and pauses that wait for him: M0, M1, M60.

use base::Ports;
use base::failure::{Answer, Failure, Outcome, ShortText};
use base::hands::Hands;
use base::ports::Wake;
use base::safety::Event;
use base::sessions::Recipient;
use base::wait::Waited;
use program::{Interpreter, Pause, Remark, ScriptModes, State};
use units::Micros;

use crate::machine::frames::{Frame, Frames};
use crate::machine::hands::MachineHands;
use crate::machine::moments::Featured;
use crate::machine::work_hands::{HaltHands, ProgramHands};
use crate::machine::{Machine, program_logs};

/// The machine for remarks of a program.
pub(crate) trait RemarkHands<'c>: ProgramHands<'c> + HaltHands<'c> {
    /// Whether lines of a job are read over.
    fn reads_over(&self) -> bool;

    /// Writes a remark to the files of the program, or opens and closes these.
    ///
    /// # Errors
    /// The fault of the file, by its name.
    fn log(&mut self, remark: &Remark<'_>) -> Result<(), Failure>;
}

impl<'c, P: Ports> RemarkHands<'c> for Machine<'c, P> {
    fn reads_over(&self) -> bool {
        self.passed.is_some()
    }

    fn log(&mut self, remark: &Remark<'_>) -> Result<(), Failure> {
        let Self { logs, files, program, world, .. } = self;
        program_logs::carry_out(logs, files, program, world, remark)
    }
}

/// Carries out a comment that says something, or writes it to a file.
///
/// # Errors
/// When that cannot be written.
pub(crate) fn remark<'c>(hands: &mut impl RemarkHands<'c>, comment: &[u8]) -> Result<(), Failure> {
    if hands.reads_over() {
        // The remark was heard when the job ran before.
        return Ok(());
    }
    match Remark::read(comment) {
        Some(Remark::Message(said)) => hands.announce(format_args!("// {said}\n")),
        Some(Remark::Debug(_)) if !hands.program().debugs() => {}
        Some(Remark::Printed(said) | Remark::Debug(said)) => {
            let mut text = ShortText::NONE;
            // Text that does not fit is cut.
            let _ = program::write_values(hands.program(), said, &mut text);
            hands.announce(format_args!("// {text}\n"));
        }
        // Programs that are only checked write nothing.
        Some(_) if hands.state() == State::Check => {}
        Some(other) => return hands.log(&other),
        None => {}
    }
    Ok(())
}

/// The machine in the hands of work that the operator takes part in.
pub(crate) trait OperatorHands<'c>: Hands<'c> {
    /// Step of a feature's sequence, among the work that lines have started.
    type Step;

    /// Returns the program.
    fn program(&mut self) -> &mut Interpreter;

    /// Returns the work that lines have started.
    fn frames(&mut self) -> &mut Frames<'c, Self::Step>;

    /// Tells hosts about the job in their own words.
    fn tell_hosts(&mut self, news: &str);

    /// Pauses the job until the operator goes on, with the rest of its line waiting.
    fn pause_job(&mut self);

    /// Notes whether a line of a session waits for the operator.
    fn awaits_operator(&mut self, yes: bool);
}

impl<'c, P: Ports> OperatorHands<'c> for MachineHands<'_, 'c, P> {
    type Step = <P as Featured>::Step;

    fn program(&mut self) -> &mut Interpreter {
        &mut self.machine.program
    }

    fn frames(&mut self) -> &mut Frames<'c, Self::Step> {
        &mut self.machine.frames
    }

    fn tell_hosts(&mut self, news: &str) {
        self.machine.world.sessions.tell_hosts(news, Recipient::Nobody);
    }

    fn pause_job(&mut self) {
        self.machine.jobs.wait_for_operator();
    }

    fn awaits_operator(&mut self, yes: bool) {
        self.machine.urgent.awaits_operator = yes;
    }
}

/// Waits until the operator goes on (M0, M1, M60), or so long.
pub(crate) fn pause<'c>(
    hands: &mut impl OperatorHands<'c>,
    why: Pause,
    time: Option<Micros>,
    text: Option<&str>,
) -> Outcome {
    hands.standstill()?;
    if let Some(text) = text {
        hands.announce(format_args!("// {text}\n"));
    }
    if let Some(time) = time {
        return wait_for(hands, time, |hands| hands.wait_is_over()).map(|_| Answer::Ok);
    }
    let code = match why {
        Pause::Program => "M0",
        Pause::Optional => "M1",
        Pause::Pallet => "M60",
    };
    wait(hands, format_args!("the program waits ({code})"))
}

/// Dwells once nothing moves (G4). A pause leaves a dwell that is the whole line of a job.
pub(crate) fn dwell<'c>(hands: &mut impl Hands<'c>, time: Micros) -> Result<(), Failure> {
    hands.standstill()?;
    if wait_for(hands, time, |hands| hands.leaves_wait())? { Err(Failure::HALTED) } else { Ok(()) }
}

/// Waits for a length of time, or until something ends the wait; returns whether it has.
fn wait_for<'c, H: Hands<'c>>(hands: &mut H, time: Micros, ends: fn(&mut H) -> bool) -> Result<bool, Failure> {
    let since = hands.now();
    hands.begin_wait();
    while hands.now().since(since) < time {
        hands.wait(Wake::Time).unless_halted()?;
        if ends(hands) {
            return Ok(true);
        }
    }
    Ok(false)
}

/// Waits for the operator: a job is paused, with the rest of its line; lines of a session are held.
pub(crate) fn wait<'c>(hands: &mut impl OperatorHands<'c>, what: core::fmt::Arguments<'_>) -> Outcome {
    if hands.is_playing() {
        hands.announce(format_args!("// {what}: ~ or M24 goes on, abort ends the job\n"));
        hands.tell_hosts("paused");
        let modes = ScriptModes::beside(hands.program());
        if !hands.frames().push(Frame::Operator(modes)) {
            return Err(Failure::refused(&"scripts start each other without end"));
        }
        hands.pause_job();
        return Ok(Answer::Ok);
    }
    hands.announce(format_args!("// {what}: ~ goes on\n"));
    // The state is that of a hold by `!`, so that everybody sees why nothing moves, and `~` goes on.
    if !hands.apply(Event::Started) || !hands.apply(Event::Hold) {
        return Err(Failure::HALTED);
    }
    hands.awaits_operator(true);
    let mut waited = Waited::Held;
    while waited != Waited::Halted && matches!(hands.state(), State::Hold | State::Door) {
        waited = hands.wait(Wake::Any);
    }
    hands.awaits_operator(false);
    waited.unless_halted().map(|()| Answer::Ok)
}
