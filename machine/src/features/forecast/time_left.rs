//! Time left of the job, as the look at its file knows it.

use base::Ports;
use base::sessions::{Recipient, Reply};
use jobs::player::{Planned, TimeLeft};
use motion::Tag;
use preflight::forecast::Purpose;

use super::{Forecasting, looked_at_share};

/// Returns the time left of the job at the present factor of feed rates, as far as is known.
pub(crate) fn time_left<P: Ports>(ahead: &mut Forecasting<'_, '_, P>) -> TimeLeft {
    let forecast = ahead.forecast;
    if !ahead.jobs.is_open() {
        return TimeLeft::default();
    }
    follow(ahead);
    let (made, since) = ahead.files.made;
    let (waited, now) =
        (ahead.world.ports.now().since(since), ahead.world.ports.motion(|motion| motion.overrides().feed) as f32);
    let is_its = ahead.files.job == ahead.jobs.count();
    let planned = forecast.course(|course| {
        let factor = now / course.factor_at(made);
        let [left, least] = [made, made + 1].map(|lines| course.left(lines).seconds(factor));
        let left = units::within(left - waited.0 as f32 * 1e-6, least.min(left), left);
        Planned { left, total: course.total().seconds(factor) }
    });
    let planned = planned.filter(|_| is_its);
    let goes_on = forecast.is_under_way() && forecast.purpose() == Purpose::Job;
    TimeLeft { planned, looked_at: goes_on.then(|| looked_at_share(ahead, forecast)) }
}

/// Says how far the job is, in bytes (M27).
pub(crate) fn say_bytes<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, to: Recipient) {
    let time_left = time_left(ahead);
    ahead.jobs.say_bytes(&time_left, &mut Reply::new(ahead.world.sessions, to));
}

/// Says how far the job is, in per cent, and the time left (M73).
pub(crate) fn say_progress<P: Ports>(ahead: &mut Forecasting<'_, '_, P>, to: Recipient) {
    let time_left = time_left(ahead);
    ahead.jobs.say_progress(&time_left, &mut Reply::new(ahead.world.sessions, to));
}

/// Notes the line of the job that is made.
pub(crate) fn follow<P: Ports>(ahead: &mut Forecasting<'_, '_, P>) {
    let (made, now) = (made(ahead), ahead.world.ports.now());
    if ahead.files.made.0 != made {
        ahead.files.made = (made, now);
    }
}

/// Returns the number of the job's lines that have been made.
fn made<P: Ports>(ahead: &mut Forecasting<'_, '_, P>) -> u32 {
    let tag = ahead.world.ports.motion(|motion| (!motion.is_idle()).then(|| motion.passed().tag));
    tag.filter(|tag| *tag != Tag::NONE).and_then(|tag| ahead.jobs.made(tag)).unwrap_or_else(|| ahead.jobs.begun())
}
