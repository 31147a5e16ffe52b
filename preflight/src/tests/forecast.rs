//! Forecasts beside other work: the file comes piece by piece, from whoever has it open.

use core::cell::RefCell;
use core::pin::pin;

use base::bench::Card;
use base::ports::{FileHandle, OpenMode, Storage, Workspace};
use base::safety::travel::Travel;
use base::taken_codes::TakenCodes;
use base::tuning::Tuning;
use jobs::player::FileLines;
use motion::Motion;
use units::{AxisSet, Celsius, MAX_HEATERS};

use super::{Desk as Sample, Kind, assert_near};
use crate::forecast::{Answer, Desk, Forecaster, Purpose, SharedForecast, Stage, Wanted, Work, read_file};
use crate::{AsItIs, Finding, Totals};

/// Files that the executor would have open: the job's own, and the ones that have called it.
struct Files {
    card: Card,
    callers: Vec<FileLines>,
}

impl Files {
    fn open(&mut self, path: &str) -> Option<FileHandle> {
        self.card.open(path, OpenMode::Beside).ok()
    }

    fn bring(&mut self, wanted: &Wanted, forecast: &SharedForecast) -> Answer {
        let is_there = match wanted {
            Wanted::More => match forecast.lines(|lines| lines.fill(&mut self.card)) {
                Ok(there) => there,
                Err(error) => return Answer::Failed(error.text()),
            },
            Wanted::At(place) => forecast.lines(|lines| lines.go_to(*place, &mut self.card)).is_ok(),
            Wanted::Call(name) => match self.open(&format!("/sd/{name}.ngc")) {
                Some(file) => {
                    self.callers.push(forecast.lines(|lines| core::mem::replace(lines, FileLines::new(file))));
                    true
                }
                None => false,
            },
            Wanted::Macro(..) | Wanted::MacroLine | Wanted::Called(_) | Wanted::Line(..) => {
                panic!("no macros are configured")
            }
            Wanted::Caller => self.callers.pop().is_some_and(|caller| {
                forecast.lines(|lines| *lines = caller);
                true
            }),
        };
        if is_there { Answer::Here } else { Answer::None }
    }
}

/// Makes a forecast of `/sd/job.g` on this card, for a homed sample printer; calls `look` at its end.
fn forecast_of<R>(card: Card, purpose: Purpose, look: impl FnOnce(&SharedForecast, Vec<Finding>, usize) -> R) -> R {
    let sample = Sample::new();
    let (mut workspace, forecast) = (Workspace::new(Motion::new()), SharedForecast::new());
    let mut standing = Motion::new();
    standing.configure(base::motion_config::motion_config(&sample.config).unwrap()).unwrap();
    let desk = RefCell::new(Some(Desk::new(&sample.config, &sample.texts, &mut workspace)));
    let place = pin!(None);
    let mut work = Work::new(&forecast, &desk, || read_file(&forecast, &desk), place);
    assert!(work.stand_as(&standing));
    let program = program::Interpreter::new(base::program_setup::setup(&sample.config));
    let (tuning, travel) = (Tuning::new(&sample.config), Travel::default());
    let machine = AsItIs {
        program: &program,
        tuning: &tuning,
        travel: &travel,
        homed: AxisSet::PRIMARY,
        targets: [Celsius(0.0); MAX_HEATERS],
        most_celsius: [Celsius(290.0); MAX_HEATERS],
        dialect: None,
        taken: TakenCodes::None,
        goes_on: false,
    };
    let mut files = Files { card, callers: Vec::new() };
    let file = files.open("/sd/job.g").expect("the job");
    work.begin(purpose, file, &machine);
    work.read_as(None);
    let (mut found, mut turns) = (Vec::new(), 0);
    while forecast.is_under_way() {
        forecast.allow(turns % 3 != 0);
        turns += 1;
        assert!(turns < 100_000, "it does not end");
        assert_eq!(work.take_turn(), turns % 3 != 1 && forecast.stage() != Stage::Free);
        if let Some(wanted) = forecast.take_wanted(false) {
            let answer = files.bring(&wanted, &forecast);
            forecast.answer(answer);
        }
        found.extend(core::iter::from_fn(|| forecast.take_finding()));
    }
    look(&forecast, found, turns)
}

fn square() -> String {
    "G1 X50 F6000\nG1 Y50\nG1 X0\nG1 Y0\n".repeat(60)
}

#[test]
fn a_forecast_in_turns_is_that_of_the_whole_file() {
    let text = square();
    let (found, whole): (_, Totals) = Sample::new().read(&format!("G28\n{text}"));
    assert!(found.is_empty());
    forecast_of(Card::with(&[("/sd/job.g", &text)]), Purpose::Job, |forecast, found, turns| {
        assert_eq!((forecast.stage(), found), (Stage::Done, Vec::new()));
        assert!(turns > 100, "others have their turns: {turns}");
        let totals = forecast.totals();
        assert_eq!(totals.lines, 240);
        assert_near(totals.seconds(), whole.seconds() - whole.homing_seconds);
        let left = forecast.course(|course| course.left(120).seconds(1.0)).expect("the job's course");
        let half = 0.5 * totals.seconds();
        assert!((f64::from(left) - half).abs() < 0.05 * half, "{left} s, {half} s");
    });
}

#[test]
fn subroutines_and_loops_are_fetched_where_they_are() {
    let job = "O<way> call\nO9 repeat [3]\nG1 Z5 F600\nG1 Z1\nO9 endrepeat\nG1 X999 F6000\n";
    let sub = "O<way> sub\nG1 X20 F6000\nG1 X900\nO<way> endsub\n";
    let card = Card::with(&[("/sd/job.g", job), ("/sd/way.ngc", sub)]);
    forecast_of(card, Purpose::Check, |forecast, found, _| {
        assert_eq!(forecast.stage(), Stage::Done);
        let told: Vec<String> = found.iter().map(ToString::to_string).collect();
        assert_eq!(found.iter().filter(|finding| finding.kind == Kind::OutOfTravel).count(), 2, "{told:?}");
        assert!(told[0].starts_with("way.ngc, line 3: stops"), "{told:?}");
        assert!(told[1].starts_with("line 6: stops"), "{told:?}");
        assert_near(forecast.totals().travelled, 20.0 + 5.0 + 4.0 * 5.0);
    });
}

#[test]
fn many_findings_wait_for_whoever_hears_them() {
    let text = "G777\n".repeat(100);
    forecast_of(Card::with(&[("/sd/job.g", &text)]), Purpose::Check, |forecast, found, _| {
        assert_eq!((found.len(), forecast.missed(), forecast.totals().stops), (100, 0, 100));
    });
}

#[test]
fn a_card_that_fails_ends_the_forecast_with_its_words() {
    let mut card = Card::with(&[("/sd/job.g", &square())]);
    card.fails = true;
    forecast_of(card, Purpose::Job, |forecast, _, _| {
        assert!(matches!(forecast.stage(), Stage::Failed(why) if !why.is_empty()));
        assert!(forecast.course(|_| ()).is_none());
    });
}
