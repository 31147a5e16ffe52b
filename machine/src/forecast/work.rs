//! The work on a forecast: the file's lines, one after the other, through preflight.

use core::future::poll_fn;
use core::pin::{Pin, pin};

use motion::{Mode, Motion, Passage};
use program::Next;

use super::foresight::{Answer, Desk, Foresight, Stage, Wanted};
use crate::files::Path;
use crate::jobs;
use crate::preflight::{Finding, Listener, Preflight};
use crate::sessions::LineBytes;
use crate::wait::yield_once;

/// Runs `executor`, and the work on forecasts whenever that waits.
pub(crate) async fn beside<F: Future>(executor: Pin<&mut F>, foresight: &Foresight<'_>) -> F::Output {
    let mut executor = executor;
    let mut work = pin!(None);
    poll_fn(move |context| {
        let polled = executor.as_mut().poll(context);
        if foresight.take_dropped() {
            work.set(None);
        }
        if foresight.has_its_turn() {
            if work.is_none() {
                work.set(Some(run(foresight)));
            }
            if let Some(going_on) = work.as_mut().as_pin_mut()
                && going_on.poll(context).is_ready()
            {
                work.set(None);
            }
            // There is more to do than to wait for interrupts.
            context.waker().wake_by_ref();
        }
        polled
    })
    .await
}

/// Hears what preflight finds.
struct Hearing<'f, 'a>(&'f Foresight<'a>);

impl Listener for Hearing<'_, '_> {
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
}

#[allow(clippy::await_holding_refcell_ref, reason = "the executor only tries to borrow it, and drops the work first")]
async fn run(foresight: &Foresight<'_>) {
    let Ok(mut desk) = foresight.desk.try_borrow_mut() else { return };
    let Some(Desk { preflight, motion }) = &mut *desk else { return };
    foresight.stage.set(Stage::Running);
    let ended = read(preflight, motion, foresight).await;
    foresight.count(preflight.totals());
    foresight.stage.set(match ended {
        Ok(()) => {
            foresight.course_is_whole();
            Stage::Done
        }
        Err(why) => Stage::Failed(why),
    });
}

async fn read(
    preflight: &mut Preflight<'_>,
    motion: &mut Motion,
    foresight: &Foresight<'_>,
) -> Result<(), &'static str> {
    let (listener, mut line) = (&mut Hearing(foresight), LineBytes::new());
    while !preflight.has_ended() {
        while !foresight.has_room() {
            yield_once().await;
        }
        let here = foresight.lines.borrow().place();
        let mut next = foresight.lines.borrow_mut().next_at_hand(&mut line);
        while next.is_none() {
            next = match ask(foresight, Wanted::More).await? {
                true => foresight.lines.borrow_mut().next_at_hand(&mut line),
                false => Some(foresight.lines.borrow_mut().last(&mut line)),
            };
        }
        let after = foresight.lines.borrow().place();
        match next {
            Some(jobs::Next::Line) => {
                let next = preflight.line(&line, (here, after), motion, listener).await;
                go_on(preflight, foresight, next).await?;
            }
            Some(jobs::Next::TooLong) => preflight.too_long(here, listener),
            _ => break,
        }
        if preflight.is_endless(listener) {
            break;
        }
        foresight.count(preflight.totals());
    }
    preflight.end(motion, listener).await;
    Ok(())
}

/// To where the next line stands.
async fn go_on(preflight: &mut Preflight<'_>, foresight: &Foresight<'_>, next: Next) -> Result<(), &'static str> {
    match next {
        Next::Following => {}
        Next::At(place) => {
            if foresight.lines.borrow().is_at_hand(place) {
                foresight.lines.borrow_mut().go_to_at_hand(place);
            } else {
                ask(foresight, Wanted::At(place)).await?;
            }
        }
        Next::FirstOf(name) => {
            let name = Path::try_from(name.as_str()).unwrap_or_default();
            let there_is_one = ask(foresight, Wanted::Call(name)).await?;
            preflight.enter_file(there_is_one);
        }
        Next::Returned => {
            if ask(foresight, Wanted::Caller).await? {
                preflight.leave_file();
            }
        }
    }
    Ok(())
}

/// Has the executor bring something; whether there is such a thing.
async fn ask(foresight: &Foresight<'_>, wanted: Wanted) -> Result<bool, &'static str> {
    foresight.wanted.replace(Some(wanted));
    while foresight.wants() {
        yield_once().await;
    }
    match foresight.answer.get() {
        Answer::Here => Ok(true),
        Answer::None => Ok(false),
        Answer::Failed(why) => Err(why),
    }
}
