//! The features of the machine, a folder each, and the list that has them all.
//!
//! A new feature is a folder, a line in `features!`, a field in [`States`] if it has a state, and a row in
//! [`Step`] if its sequences wait for scripts. The order of the list is the order in which they act.

pub(crate) mod automatic_outputs;
pub(crate) mod axis_tests;
pub(crate) mod brown_out;
pub(crate) mod commands;
pub(crate) mod door;
pub(crate) mod editing;
pub(crate) mod event_log;
pub(crate) mod filament;
pub(crate) mod file_commands;
pub(crate) mod forecast;
pub(crate) mod functions;
pub(crate) mod grbl;
pub(crate) mod lights;
pub(crate) mod objects;
pub(crate) mod paper;
pub(crate) mod periodic_reports;
pub(crate) mod play_from;
pub(crate) mod power_loss;
pub(crate) mod stalls;
pub(crate) mod state;
pub(crate) mod statistics;
pub(crate) mod update;
pub(crate) mod usb_disk;

use base::Ports;
use base::failure::{Failure, Outcome};
use base::ports::Running;
use base::sessions::{LineBytes, Listing, Recipient, Reply, SessionId};
use config::MachineConfig;
use gcode::{Code, Line, realtime::Realtime};
use jobs::player::StalledJob;
use program::{BEGINNING_BYTES, LightChange, Move, State, Words};
use units::Micros;

use state::{States, Step};

use crate::machine::Machine;
use crate::machine::moments::{Featured, JobBegins, JobStart, Moments, StartupLine};
use crate::machine::source::Source;

/// All features, as one.
#[derive(Debug)]
pub(crate) struct List;

/// Has the list do at each moment what its features do, one after the other.
macro_rules! features {
    ($($feature:ident),+ $(,)?) => {
        impl<P: Ports> Moments<P> for List {
            fn greet(running: &Running, reply: &mut Reply<'_>) {
                $(<$feature::Feature as Moments<P>>::greet(running, reply);)+
            }
            fn banner(config: &MachineConfig) -> Option<&'static str> {
                None$(.or_else(|| <$feature::Feature as Moments<P>>::banner(config)))+
            }
            fn wired(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::wired(machine);)+
            }
            fn read_files(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::read_files(machine);)+
            }
            fn started(machine: &mut Machine<'_, P>, is_usable: bool) {
                $(<$feature::Feature as Moments<P>>::started(machine, is_usable);)+
            }
            fn each_250_us(machine: &mut Machine<'_, P>, now: Micros) {
                $(<$feature::Feature as Moments<P>>::each_250_us(machine, now);)+
            }
            fn each_10_ms(machine: &mut Machine<'_, P>, now: Micros) {
                $(<$feature::Feature as Moments<P>>::each_10_ms(machine, now);)+
            }
            fn each_turn(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::each_turn(machine);)+
            }
            fn idle(machine: &mut Machine<'_, P>) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::idle(machine))+
            }
            fn take_request(machine: &mut Machine<'_, P>, request: Realtime, id: SessionId) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::take_request(machine, request, id))+
            }
            fn owns_console_line(machine: &Machine<'_, P>, line: &str, to: Recipient) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::owns_console_line(machine, line, to))+
            }
            fn run_console_line(machine: &mut Machine<'_, P>, line: &str, to: Recipient) -> Option<Outcome> {
                None$(.or_else(|| <$feature::Feature as Moments<P>>::run_console_line(machine, line, to)))+
            }
            fn refuse_codes(machine: &mut Machine<'_, P>, to: Recipient) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::refuse_codes(machine, to))+
            }
            fn session_line_begins(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::session_line_begins(machine);)+
            }
            fn session_line_ends(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::session_line_ends(machine);)+
            }
            fn line(machine: &Machine<'_, P>) -> Option<&'static str> {
                None$(.or_else(|| <$feature::Feature as Moments<P>>::line(machine)))+
            }
            fn take_line(machine: &mut Machine<'_, P>) -> Option<&'static str> {
                None$(.or_else(|| <$feature::Feature as Moments<P>>::take_line(machine)))+
            }
            fn hold_moves_back(machine: &Machine<'_, P>) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::hold_moves_back(machine))+
            }
            fn block_begins(machine: &mut Machine<'_, P>, source: Source) {
                $(<$feature::Feature as Moments<P>>::block_begins(machine, source);)+
            }
            fn leave_move_out(machine: &mut Machine<'_, P>, request: &Move) -> Result<bool, Failure> {
                Ok(false $(|| <$feature::Feature as Moments<P>>::leave_move_out(machine, request)?)+)
            }
            fn may_move(machine: &mut Machine<'_, P>, request: &Move) -> Result<(), Failure> {
                $(<$feature::Feature as Moments<P>>::may_move(machine, request)?;)+
                Ok(())
            }
            fn accepts(code: Code) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::accepts(code))+
            }
            fn startup_line_ended(machine: &mut Machine<'_, P>, number: u8, outcome: &Outcome) {
                $(<$feature::Feature as Moments<P>>::startup_line_ended(machine, number, outcome);)+
            }
            fn startup_line(machine: &Machine<'_, P>, number: u8) -> Option<StartupLine> {
                None$(.or_else(|| <$feature::Feature as Moments<P>>::startup_line(machine, number)))+
            }
            fn job_may_start(machine: &mut Machine<'_, P>) -> JobStart {
                $(match <$feature::Feature as Moments<P>>::job_may_start(machine) {
                    JobStart::Now => {}
                    other => return other,
                })+
                JobStart::Now
            }
            fn take_session_line(machine: &mut Machine<'_, P>, id: SessionId, line: &LineBytes) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::take_session_line(machine, id, line))+
            }
            fn answer_in_upload(machine: &mut Machine<'_, P>, line: Line<'_>, to: Recipient) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::answer_in_upload(machine, line.clone(), to))+
            }
            fn long_answer(
                machine: &mut Machine<'_, P>,
                listing: &mut Listing,
                to: Recipient,
            ) -> Option<Result<bool, Failure>> {
                None$(.or_else(|| <$feature::Feature as Moments<P>>::long_answer(machine, listing, to)))+
            }
            fn job_may_begin(machine: &mut Machine<'_, P>) -> bool {
                true $(&& <$feature::Feature as Moments<P>>::job_may_begin(machine))+
            }
            fn job_begins(machine: &mut Machine<'_, P>, from: JobBegins) {
                $(<$feature::Feature as Moments<P>>::job_begins(machine, from);)+
            }
            fn job_goes_on(machine: &mut Machine<'_, P>, beginning: [u8; BEGINNING_BYTES]) {
                $(<$feature::Feature as Moments<P>>::job_goes_on(machine, beginning);)+
            }
            fn job_is_unreadable(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::job_is_unreadable(machine);)+
            }
            fn job_is_read(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::job_is_read(machine);)+
            }
            fn job_ends(machine: &mut Machine<'_, P>, is_done: bool, to: Recipient) {
                $(<$feature::Feature as Moments<P>>::job_ends(machine, is_done, to);)+
            }
            fn explains_stop(machine: &Machine<'_, P>) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::explains_stop(machine))+
            }
            fn suspend(
                machine: &mut Machine<'_, P>,
                heaters_stay: bool,
                words: &Words<'_>,
                to: Recipient,
            ) -> Option<Outcome> {
                None$(.or_else(|| <$feature::Feature as Moments<P>>::suspend(machine, heaters_stay, words, to)))+
            }
            fn may_resume(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
                $(<$feature::Feature as Moments<P>>::may_resume(machine)?;)+
                Ok(())
            }
            fn before_going_back(machine: &mut Machine<'_, P>) -> Result<(), Failure> {
                $(<$feature::Feature as Moments<P>>::before_going_back(machine)?;)+
                Ok(())
            }
            fn goes_back(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::goes_back(machine);)+
            }
            fn arrives(machine: &mut Machine<'_, P>, stall: &StalledJob) -> Result<(), Failure> {
                $(<$feature::Feature as Moments<P>>::arrives(machine, stall)?;)+
                Ok(())
            }
            fn leaves_for_heights(machine: &mut Machine<'_, P>, heights: [f64; 2]) {
                $(<$feature::Feature as Moments<P>>::leaves_for_heights(machine, heights);)+
            }
            fn keeps_thermal_z(machine: &Machine<'_, P>) -> bool {
                false $(|| <$feature::Feature as Moments<P>>::keeps_thermal_z(machine))+
            }
            fn extruders_count_anew(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::extruders_count_anew(machine);)+
            }
            fn objects_change(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::objects_change(machine);)+
            }
            fn may_go_on(machine: &mut Machine<'_, P>) -> bool {
                true $(&& <$feature::Feature as Moments<P>>::may_go_on(machine))+
            }
            fn goes_on(machine: &mut Machine<'_, P>, from: State) {
                $(<$feature::Feature as Moments<P>>::goes_on(machine, from);)+
            }
            fn change_light(machine: &mut Machine<'_, P>, change: &LightChange) -> Result<(), Failure> {
                $(<$feature::Feature as Moments<P>>::change_light(machine, change)?;)+
                Ok(())
            }
            fn arm(machine: &mut Machine<'_, P>, rule: u8, armed: bool) {
                $(<$feature::Feature as Moments<P>>::arm(machine, rule, armed);)+
            }
            fn pass_light(machine: &mut Machine<'_, P>, change: &LightChange) {
                $(<$feature::Feature as Moments<P>>::pass_light(machine, change);)+
            }
            fn drop_effects(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::drop_effects(machine);)+
            }
            fn stops(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::stops(machine);)+
            }
            fn halts(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::halts(machine);)+
            }
            fn job_is_dropped(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::job_is_dropped(machine);)+
            }
            fn rests(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::rests(machine);)+
            }
            fn work_was_ended(machine: &mut Machine<'_, P>) {
                $(<$feature::Feature as Moments<P>>::work_was_ended(machine);)+
            }
        }
    };
}

features![
    usb_disk,
    grbl,
    event_log,
    power_loss,
    statistics,
    brown_out,
    door,
    stalls,
    paper,
    objects,
    automatic_outputs,
    lights,
    filament,
    update,
    forecast,
    periodic_reports,
    editing,
];

impl<P: Ports> Featured for P {
    type List = List;
    type States = States;
    type Step = Step;

    fn states(config: &MachineConfig) -> States {
        States::new(config)
    }

    fn go_on(machine: &mut Machine<'_, P>, step: Step) -> Result<(), Failure> {
        match step {
            Step::Recover(step, to) => power_loss::job_recovery::go_on(machine, step, to),
            Step::Stalled(step) => stalls::recovery::go_on(machine, step),
            Step::PlayFrom(to) => play_from::go_on(machine, to),
        }
    }

    fn give_up(machine: &mut Machine<'_, P>, step: Step, why: Failure) {
        match step {
            // A recovery cannot go on from where the machine is.
            Step::Recover(..) if why.is_refusal() => power_loss::job_recovery::give_up(machine),
            Step::Recover(..) | Step::Stalled(_) | Step::PlayFrom(_) => {}
        }
    }
}
