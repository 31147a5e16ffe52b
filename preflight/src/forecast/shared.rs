//! Data shared by the executor and the work on a forecast.

use core::cell::{Cell, RefCell};
use core::fmt::Write as _;

use base::paths::Path;
use base::ports::FileHandle;
use base::sessions::LineBytes;
use heapless::Deque;
use jobs::player::FileLines;
use program::Place;

use super::timeline::JobTimeline;
use crate::{Called, Finding, Kind, MacroCall, MacroPlace, Severity, Totals};

/// Greatest number of findings that wait to be told.
const FINDINGS: usize = 16;
/// Free places for findings below which the next line waits until somebody has heard of those before.
const ROOM: usize = 8;

/// Purpose of a forecast.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// `check`: somebody hears the findings.
    Check,
    /// The job that is open.
    Job,
}

/// Progress of a forecast.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stage {
    /// There is no forecast.
    #[default]
    Free,
    /// A forecast is to begin.
    Ready,
    /// The forecast goes on.
    Running,
    /// The file has been read to its end.
    Done,
    /// The file could not be read, for this reason.
    Failed(&'static str),
}

/// Input that the work needs before it can go on.
#[allow(clippy::large_enum_variant, reason = "there is one of it, in place")]
#[derive(Clone, Debug, PartialEq)]
pub enum Wanted {
    /// More of the file.
    More,
    /// The lines at another place of the file.
    At(Place),
    /// The file of a subroutine.
    Call(Path),
    /// The file that called it.
    Caller,
    /// The macro that a line calls; whether it is a code.
    Macro(LineBytes, bool),
    /// The next line of macros.
    MacroLine,
    /// What came of either: the work takes it.
    Called(Called),
    /// Such a line, its place, and whether it does not depend on the state of the machine.
    Line(LineBytes, MacroPlace, bool),
}

/// Result of a request for input.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Answer {
    /// The input is there.
    #[default]
    Here,
    /// There is no such file, or no more of it.
    None,
    /// The file cannot be read, for this reason.
    Failed(&'static str),
}

/// Data shared by the executor and the work on a forecast. Neither keeps a borrow of it while the other runs.
pub struct SharedForecast {
    pub(super) lines: RefCell<FileLines>,
    pub(super) wanted: RefCell<Option<Wanted>>,
    pub(super) answer: Cell<Answer>,
    found: RefCell<Deque<Finding, FINDINGS>>,
    missed: Cell<u32>,
    /// The rest of the file depends on results that only the job has.
    guesses: Cell<bool>,
    course: RefCell<JobTimeline>,
    /// The course is complete for the open job, from its beginning to its end.
    has_course: Cell<bool>,
    totals: Cell<Totals>,
    purpose: Cell<Purpose>,
    pub(super) stage: Cell<Stage>,
    may_run: Cell<bool>,
}

impl SharedForecast {
    /// Makes an empty one. Never inlined, as it is large.
    #[inline(never)]
    #[expect(clippy::new_without_default, reason = "there is one of it")]
    pub fn new() -> Self {
        Self {
            lines: RefCell::new(FileLines::new(FileHandle(0))),
            wanted: RefCell::new(None),
            answer: Cell::default(),
            found: RefCell::default(),
            missed: Cell::new(0),
            guesses: Cell::new(false),
            course: RefCell::default(),
            has_course: Cell::new(false),
            totals: Cell::default(),
            purpose: Cell::new(Purpose::Check),
            stage: Cell::default(),
            may_run: Cell::new(false),
        }
    }

    // --- the executor's side ---

    /// Whether a forecast is being made.
    pub fn is_under_way(&self) -> bool {
        matches!(self.stage.get(), Stage::Ready | Stage::Running)
    }

    /// Returns the progress of the forecast.
    pub const fn stage(&self) -> Stage {
        self.stage.get()
    }

    /// Returns the purpose of the forecast under way, or made last.
    pub const fn purpose(&self) -> Purpose {
        self.purpose.get()
    }

    /// Sets whether the work may have its turns.
    pub fn allow(&self, may_run: bool) {
        self.may_run.set(may_run);
    }

    /// Drops the forecast, which is of no use any more.
    pub fn forget(&self) {
        self.stage.set(Stage::Free);
        self.wanted.replace(None);
    }

    /// Ends a forecast that cannot go on.
    pub fn fail(&self, why: &'static str) {
        self.forget();
        self.stage.set(Stage::Failed(why));
    }

    /// Takes the input that the work waits for, once; of macros only with `of_macros`, else none of them.
    pub fn take_wanted(&self, of_macros: bool) -> Option<Wanted> {
        let mut wanted = self.wanted.borrow_mut();
        let takes = match *wanted {
            Some(Wanted::Macro(..) | Wanted::MacroLine) => of_macros,
            Some(Wanted::Called(_) | Wanted::Line(..)) => false,
            _ => !of_macros,
        };
        if takes { wanted.take() } else { None }
    }

    /// Whether the work waits for input.
    pub fn wants(&self) -> bool {
        !matches!(*self.wanted.borrow(), None | Some(Wanted::Called(_) | Wanted::Line(..)))
    }

    /// Stores what came of a wish about macros.
    pub fn answer_macros(&self, answer: Wanted) {
        self.wanted.replace(Some(answer));
    }

    /// Whether the work may have its turns.
    pub const fn may_run(&self) -> bool {
        self.may_run.get()
    }

    /// Stores the answer to a request for input.
    pub fn answer(&self, answer: Answer) {
        self.answer.set(answer);
    }

    /// Calls `f` with the lines of the file.
    pub fn lines<R>(&self, f: impl FnOnce(&mut FileLines) -> R) -> R {
        f(&mut self.lines.borrow_mut())
    }

    /// Takes the next finding that nobody has heard of.
    pub fn take_finding(&self) -> Option<Finding> {
        self.found.borrow_mut().pop_front()
    }

    /// Returns the number of findings that there was no room for.
    pub const fn missed(&self) -> u32 {
        self.missed.get()
    }

    /// Whether the rest of the file depends on results that only the job has.
    pub const fn guesses(&self) -> bool {
        self.guesses.get()
    }

    /// Returns the totals of the file so far.
    pub fn totals(&self) -> Totals {
        self.totals.get()
    }

    /// Calls `f` with the course of the job, once it is known to its end.
    pub fn course<R>(&self, f: impl FnOnce(&JobTimeline) -> R) -> Option<R> {
        self.has_course.get().then(|| f(&self.course.borrow()))
    }

    /// Forgets the course, as another job begins.
    pub fn forget_course(&self) {
        self.has_course.set(false);
        self.course.borrow_mut().clear();
    }

    // --- the work's side ---

    /// Sets up a forecast of an open file, of which nothing is known yet.
    pub(super) fn begin(&self, purpose: Purpose, file: FileHandle) {
        self.lines(|lines| *lines = FileLines::new(file));
        self.wanted.replace(None);
        self.found.borrow_mut().clear();
        self.missed.set(0);
        self.guesses.set(false);
        self.totals.set(Totals::default());
        self.purpose.set(purpose);
        self.stage.set(Stage::Ready);
    }

    /// Whether the work may have a turn, and has what it needs for it.
    pub(super) fn has_its_turn(&self) -> bool {
        let waits = self.stage.get() == Stage::Ready || (self.stage.get() == Stage::Running && !self.wants());
        waits && self.may_run.get()
    }

    pub(super) fn called(&self, call: MacroCall<'_>) -> Option<Called> {
        let mut wanted = self.wanted.borrow_mut();
        match *wanted {
            Some(Wanted::Called(called)) => {
                *wanted = None;
                Some(called)
            }
            None => {
                let mut line = LineBytes::new();
                // No line is longer; a code with its words is cut, as it is carried out.
                let _ = write!(line, "{call}");
                *wanted = Some(Wanted::Macro(line, call.is_code()));
                None
            }
            _ => None,
        }
    }

    pub(super) fn macro_line(&self, line: &mut LineBytes, place: &mut MacroPlace) -> Option<Called> {
        let mut wanted = self.wanted.borrow_mut();
        match &*wanted {
            Some(Wanted::Called(called)) => {
                let called = *called;
                *wanted = None;
                Some(called)
            }
            Some(Wanted::Line(text, at, is_sure)) => {
                line.clone_from(text);
                place.clone_from(at);
                let is_sure = *is_sure;
                *wanted = None;
                Some(Called::Macro { is_sure })
            }
            None => {
                *wanted = Some(Wanted::MacroLine);
                None
            }
            _ => None,
        }
    }

    pub(super) fn has_room(&self) -> bool {
        let found = self.found.borrow();
        found.capacity() - found.len() >= ROOM
    }

    pub(super) fn found(&self, finding: &Finding) {
        if finding.kind == Kind::Unforeseen {
            self.guesses.set(true);
        }
        // Only findings that stop a job are told of it, and that its bed is not leveled.
        let is_worth_it = finding.kind.severity() == Severity::Stop || finding.kind == Kind::Unleveled;
        let is_told = self.purpose.get() == Purpose::Check || is_worth_it;
        if is_told && self.found.borrow_mut().push_back(finding.clone()).is_err() {
            self.missed.set(self.missed.get().saturating_add(1));
        }
    }

    pub(super) fn with_course(&self, f: impl FnOnce(&mut JobTimeline)) {
        if self.purpose.get() == Purpose::Job {
            f(&mut self.course.borrow_mut());
        }
    }

    pub(super) fn course_is_whole(&self) {
        if self.purpose.get() == Purpose::Job {
            self.has_course.set(true);
        }
    }

    pub(super) fn count(&self, totals: &Totals) {
        self.totals.set(*totals);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use base::failure::short;

    fn finding(kind: Kind) -> Finding {
        Finding { sub: None, line: 1, kind, what: short(format_args!("x")) }
    }

    fn begun(purpose: Purpose) -> SharedForecast {
        let forecast = SharedForecast::new();
        forecast.begin(purpose, FileHandle(1));
        forecast
    }

    #[test]
    fn a_check_tells_all_and_a_job_only_what_stops_it() {
        let kinds = [Kind::Speed, Kind::OutOfTravel, Kind::Unleveled, Kind::PassedOver, Kind::Text];
        let told = |purpose: Purpose| {
            let forecast = begun(purpose);
            kinds.iter().for_each(|kind| forecast.found(&finding(*kind)));
            core::iter::from_fn(|| forecast.take_finding()).map(|finding| finding.kind).collect::<std::vec::Vec<_>>()
        };
        assert_eq!(told(Purpose::Check), kinds);
        assert_eq!(told(Purpose::Job), [Kind::OutOfTravel, Kind::Unleveled, Kind::Text]);
    }

    #[test]
    fn reading_waits_for_room_and_findings_beyond_it_are_counted() {
        let forecast = begun(Purpose::Check);
        for count in 1..=FINDINGS + 3 {
            assert_eq!(forecast.has_room(), count <= FINDINGS - ROOM + 1, "{count}");
            forecast.found(&finding(Kind::Text));
        }
        assert_eq!(forecast.missed(), 3);
        forecast.begin(Purpose::Check, FileHandle(2));
        assert_eq!((forecast.missed(), forecast.take_finding()), (0, None));
    }

    #[test]
    fn a_finding_that_only_the_job_can_settle_makes_the_rest_a_guess() {
        let forecast = begun(Purpose::Job);
        forecast.found(&finding(Kind::OutOfTravel));
        assert!(!forecast.guesses());
        forecast.found(&finding(Kind::Unforeseen));
        assert!(forecast.guesses());
    }

    #[test]
    fn work_has_turns_while_it_may_and_has_its_input() {
        let forecast = SharedForecast::new();
        forecast.allow(true);
        assert!(!forecast.has_its_turn() && !forecast.is_under_way(), "there is nothing to do");
        forecast.begin(Purpose::Job, FileHandle(1));
        assert!(forecast.has_its_turn() && forecast.is_under_way());
        forecast.stage.set(Stage::Running);
        forecast.wanted.replace(Some(Wanted::More));
        assert!(forecast.wants() && !forecast.has_its_turn());
        assert_eq!(forecast.take_wanted(false), Some(Wanted::More));
        assert!(forecast.has_its_turn());
        forecast.allow(false);
        assert!(!forecast.has_its_turn());
        forecast.fail("no card");
        assert!(!forecast.is_under_way() && forecast.stage() == Stage::Failed("no card"));
    }

    #[test]
    fn only_a_jobs_course_is_kept_and_known_at_its_end() {
        let seconds = |purpose: Purpose| {
            let forecast = begun(purpose);
            forecast.with_course(|course| {
                course.line(1);
                course.waited(5.0);
            });
            assert!(forecast.course(|_| ()).is_none(), "it goes on");
            forecast.course_is_whole();
            let seconds = forecast.course(|course| course.left(0).seconds(1.0));
            forecast.forget_course();
            assert!(forecast.course(|_| ()).is_none());
            seconds
        };
        assert_eq!((seconds(Purpose::Job), seconds(Purpose::Check)), (Some(5.0), None));
    }
}
