//! The work on a forecast: the file's lines, one after the other, through preflight.

use core::cell::RefCell;
use core::pin::Pin;
use core::task::{Context, Waker};

use base::failure::Texts;
use base::paths::Path;
use base::ports::{FileHandle, Workspace};
use base::sessions::LineBytes;
use config::MachineConfig;
use jobs::player;
use motion::{Mode, Motion, Passage};
use program::{Dialect, Next};

use super::shared::{Answer, Purpose, SharedForecast, Stage, Wanted};
use crate::{AsItIs, Called, Finding, Listener, MacroCall, MacroPlace, Preflight, end_turn};

/// Preflight, with the motion object that makes no steps.
pub struct Desk<'a> {
    preflight: Preflight<'a>,
    motion: &'a mut Motion,
}

impl<'a> Desk<'a> {
    /// Makes a desk in a workspace. Never inlined, as it is large.
    #[inline(never)]
    pub fn new(config: &'a MachineConfig, texts: &'a Texts, workspace: &'a mut Workspace) -> Self {
        let Workspace { motion, program } = workspace;
        Self { preflight: Preflight::of_nothing(config, texts, program), motion }
    }
}

/// Interface of the look ahead for the executor.
pub trait Forecaster {
    /// Does some of the work on a forecast, when it may. True when there is more to do.
    fn take_turn(&mut self) -> bool;

    /// Looks ahead from where `motion` is. False: there is no machine that could move, or no memory.
    fn stand_as(&mut self, motion: &Motion) -> bool;

    /// Begins a forecast of a file that is open, and of the machine as it is, after [`Self::stand_as`].
    fn begin(&mut self, purpose: Purpose, file: FileHandle, machine: &AsItIs<'_>);

    /// Tells the dialect that the file states, if any, before the first turn.
    fn read_as(&mut self, dialect: Option<Dialect>);
}

/// Work on forecasts, one after the other.
pub struct Work<'w, 'a, F, B> {
    forecast: &'w SharedForecast,
    /// Desk for one forecast, held by the one under way; `None` if there is no memory for it.
    desk: &'w RefCell<Option<Desk<'a>>>,
    /// Begins a new forecast.
    begin: B,
    /// The forecast under way, in the middle of a line perhaps.
    under_way: Pin<&'w mut Option<F>>,
}

impl<'w, 'a, F: Future<Output = ()>, B: Fn() -> F> Work<'w, 'a, F, B> {
    /// Makes the work without a forecast; `place` is where that will lie.
    pub const fn new(
        forecast: &'w SharedForecast,
        desk: &'w RefCell<Option<Desk<'a>>>,
        begin: B,
        place: Pin<&'w mut Option<F>>,
    ) -> Self {
        Self { forecast, desk, begin, under_way: place }
    }
}

impl<F: Future<Output = ()>, B: Fn() -> F> Forecaster for Work<'_, '_, F, B> {
    fn take_turn(&mut self) -> bool {
        if !self.forecast.has_its_turn() {
            return false;
        }
        if self.forecast.stage() == Stage::Ready {
            self.under_way.set(Some((self.begin)()));
        }
        let mut context = Context::from_waker(Waker::noop());
        if self.under_way.as_mut().as_pin_mut().is_some_and(|work| work.poll(&mut context).is_ready()) {
            self.under_way.set(None);
        }
        true
    }

    fn stand_as(&mut self, motion: &Motion) -> bool {
        self.under_way.set(None);
        self.desk.borrow_mut().as_mut().is_some_and(|Desk { preflight, motion: own }| {
            preflight.settles_in(motion.config().map_or(0.0, Motion::settling));
            own.pass_as(motion).is_ok()
        })
    }

    fn begin(&mut self, purpose: Purpose, file: FileHandle, machine: &AsItIs<'_>) {
        self.under_way.set(None);
        if let Some(desk) = &mut *self.desk.borrow_mut() {
            desk.preflight.begin(machine);
        }
        self.forecast.begin(purpose, file);
    }

    fn read_as(&mut self, dialect: Option<Dialect>) {
        if let Ok(mut desk) = self.desk.try_borrow_mut()
            && let Some(desk) = &mut *desk
        {
            desk.preflight.read_as(dialect);
        }
    }
}

/// Listener that passes preflight's findings and times to the forecast.
struct Hearing<'f>(&'f SharedForecast);

impl Listener for Hearing<'_> {
    fn found(&mut self, finding: &Finding) {
        self.0.found(finding);
    }

    fn passed(&mut self, passage: &Passage, motion: &Motion) {
        self.0.with_course(|course| {
            course.set_factor(motion.overrides().feed);
            course.line(passage.tag.0);
            course.moved(passage.even_seconds, passage.ramp_seconds, passage.mode == Mode::Feed);
        });
    }

    fn waited(&mut self, line: u32, seconds: f64) {
        self.0.with_course(|course| {
            course.line(line);
            course.waited(seconds);
        });
    }

    fn called(&mut self, call: MacroCall<'_>) -> Option<Called> {
        self.0.called(call)
    }

    fn macro_line(&mut self, line: &mut LineBytes, place: &mut MacroPlace) -> Option<Called> {
        self.0.macro_line(line, place)
    }
}

/// Does the work on one forecast.
#[allow(clippy::await_holding_refcell_ref, reason = "whoever else borrows it drops the work first")]
pub async fn read_file(forecast: &SharedForecast, desk: &RefCell<Option<Desk<'_>>>) {
    let Ok(mut desk) = desk.try_borrow_mut() else { return };
    let Some(Desk { preflight, motion }) = &mut *desk else { return };
    forecast.stage.set(Stage::Running);
    let ended = read(preflight, motion, forecast).await;
    forecast.count(preflight.totals());
    forecast.stage.set(match ended {
        Ok(()) => {
            forecast.course_is_whole();
            Stage::Done
        }
        Err(why) => Stage::Failed(why),
    });
}

async fn read(
    preflight: &mut Preflight<'_>,
    motion: &mut Motion,
    forecast: &SharedForecast,
) -> Result<(), &'static str> {
    let (listener, mut line) = (&mut Hearing(forecast), LineBytes::new());
    while !preflight.has_ended() {
        while !forecast.has_room() {
            end_turn().await;
        }
        let here = forecast.lines.borrow().place();
        let mut next = forecast.lines.borrow_mut().next_at_hand(&mut line);
        while next.is_none() {
            next = match ask(forecast, Wanted::More).await? {
                true => forecast.lines.borrow_mut().next_at_hand(&mut line),
                false => Some(forecast.lines.borrow_mut().last(&mut line)),
            };
        }
        let after = forecast.lines.borrow().place();
        match next {
            Some(player::Next::Line) => {
                let next = preflight.line(&line, (here, after), motion, listener).await;
                preflight.macro_lines(&mut line, motion, listener).await;
                go_on(preflight, forecast, next).await?;
            }
            Some(player::Next::TooLong) => preflight.too_long(here, listener),
            _ => break,
        }
        if preflight.is_endless(listener) {
            break;
        }
        forecast.count(preflight.totals());
    }
    preflight.end(motion, listener).await;
    Ok(())
}

/// Goes to the place of the next line.
async fn go_on(preflight: &mut Preflight<'_>, forecast: &SharedForecast, next: Next) -> Result<(), &'static str> {
    match next {
        Next::Following => {}
        Next::At(place) => {
            if forecast.lines.borrow().is_at_hand(place) {
                forecast.lines.borrow_mut().go_to_at_hand(place);
            } else {
                ask(forecast, Wanted::At(place)).await?;
            }
        }
        Next::FirstOf(name) => {
            let name = Path::try_from(name.as_str()).unwrap_or_default();
            let there_is_one = ask(forecast, Wanted::Call(name)).await?;
            preflight.enter_file(there_is_one);
        }
        Next::Returned => {
            if ask(forecast, Wanted::Caller).await? {
                preflight.leave_file();
            }
        }
    }
    Ok(())
}

/// Has the executor bring some input; returns whether it exists.
async fn ask(forecast: &SharedForecast, wanted: Wanted) -> Result<bool, &'static str> {
    forecast.wanted.replace(Some(wanted));
    while forecast.wants() {
        end_turn().await;
    }
    match forecast.answer.get() {
        Answer::Here => Ok(true),
        Answer::None => Ok(false),
        Answer::Failed(why) => Err(why),
    }
}
