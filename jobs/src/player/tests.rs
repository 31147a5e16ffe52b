use super::*;
use base::bench::{Card, Desk};

const ME: Recipient = Recipient::Session(SessionId(0));

fn open(text: &str, starter: Starter) -> (Jobs, Card) {
    let (mut jobs, mut card) = (Jobs::default(), Card::with(&[("/sd/a.g", text)]));
    assert_eq!(jobs.open(&Texts::new(), "/sd/a.g", starter, &mut card, Micros(0)), Ok(text.len() as u32));
    jobs.read_as(Dialect::Smoothie);
    (jobs, card)
}

fn next(jobs: &mut Jobs, card: &mut Card) -> (Next, String) {
    let mut line = LineBytes::new();
    let next = jobs.next_line(card, &mut line);
    (next, String::from_utf8(line.to_vec()).unwrap())
}

fn paused(jobs: &mut Jobs, why: &str) -> String {
    Desk::new().hears(|reply| jobs.pause_at_this_line(why, reply))
}

#[test]
fn lines_come_in_turn_and_the_end_stays() {
    let (mut jobs, mut card) = open("G28\nG1 X1", Starter::default());
    for line in ["G28", "G1 X1"] {
        assert_eq!(next(&mut jobs, &mut card), (Next::Line, line.into()));
    }
    for _ in 0..3 {
        assert_eq!(next(&mut jobs, &mut card).0, Next::End);
    }
}

#[test]
fn comments_take_no_tags() {
    let comments = "; thumbnail\n".repeat(600);
    let text = format!("G1 X1\n{comments}G1 X2\n");
    let (mut jobs, mut card) = open(&text, Starter::default());
    next(&mut jobs, &mut card);
    let first = jobs.begin_line();
    while next(&mut jobs, &mut card).1 != "G1 X2" {
        assert_eq!(jobs.begin_line(), first);
    }
    let last = jobs.begin_line();
    assert_eq!(jobs.tags.executing(first), Some((1, 6)));
    assert_eq!(jobs.tags.executing(last), Some((602, text.len() as u32)));
}

#[test]
fn a_line_that_cannot_be_carried_out_pauses_the_job_and_is_named() {
    let (mut jobs, mut card) = open("G28\nG1 Yfoo\nG1 X1", Starter::default());
    next(&mut jobs, &mut card);
    next(&mut jobs, &mut card);
    let what_to_do = "M24 goes on with the next line, abort ends the job\n";
    let text = format!("error:paused, line 2 of /sd/a.g was not carried out: {what_to_do}");
    assert_eq!(paused(&mut jobs, "was not carried out"), text);
    assert!(!jobs.is_playing());
    next(&mut jobs, &mut card);
    let text = format!("error:paused, line 3 of /sd/a.g is too long: {what_to_do}");
    assert_eq!(paused(&mut jobs, "is too long"), text, "the last line has no end");
    jobs.close(&mut card);
    assert_eq!(paused(&mut jobs, "was not carried out"), "", "it has ended already");
}

#[test]
fn a_session_that_has_gone_hears_of_no_job() {
    let (mut jobs, mut card) = open("G28\n", Starter { echo: ME, tells_end: ME, ..Starter::default() });
    jobs.session_ended(SessionId(1));
    assert_eq!((jobs.echo(), jobs.tells_end()), (ME, ME));
    jobs.session_ended(SessionId(0));
    assert_eq!((jobs.echo(), jobs.tells_end()), (Recipient::Nobody, Recipient::Nobody));
    assert!(jobs.is_playing(), "it goes on");
    assert!(jobs.close(&mut card) && !jobs.close(&mut card));
    assert_eq!(card.open_files(), 0);
}

#[test]
fn the_boot_file_is_played_once_and_need_not_be_there() {
    let mut config = MachineConfig::default();
    config.player.on_boot_gcode_enable = true;
    config.player.on_boot_gcode = "/sd/a.g".try_into().unwrap();
    for there in [true, false] {
        let mut card = if there { Card::with(&[("/sd/a.g", "G28\n")]) } else { Card::default() };
        let mut jobs = Jobs::default();
        jobs.open_boot_file(&Texts::new(), &config, &mut card);
        assert!(!jobs.is_playing(), "it is not due");
        jobs.queue_boot_file(&config);
        jobs.open_boot_file(&Texts::new(), &config, &mut card);
        assert_eq!(jobs.is_playing(), there);
        jobs.close(&mut card);
        jobs.open_boot_file(&Texts::new(), &config, &mut card);
        assert!(!jobs.is_playing(), "once");
    }
}

#[test]
fn a_file_is_read_in_its_own_dialect_or_in_the_one_that_is_forced() {
    let (mut jobs, _) = open("G28\n", Starter::default());
    assert_eq!(jobs.dialect(), Some(Dialect::Smoothie));
    jobs.read_as(Dialect::Marlin);
    assert_eq!(jobs.dialect(), Some(Dialect::Marlin));
    let (mut forced, mut card) = (Jobs::new(Some(Dialect::Grbl)), Card::with(&[("/sd/a.g", "G28\n")]));
    forced.open(&Texts::new(), "/sd/a.g", Starter::default(), &mut card, Micros(0)).unwrap();
    assert_eq!(forced.dialect(), Some(Dialect::Grbl), "before a look at the file");
}

#[test]
fn a_job_that_waits_for_its_operator_goes_on_by_him_and_once() {
    let (mut jobs, mut card) = open("G28\n", Starter::default());
    assert!(!jobs.operator_is_done() && jobs.is_playing());
    jobs.wait_for_operator();
    assert!(jobs.waits_for_operator() && !jobs.is_playing() && jobs.is_open());
    assert!(jobs.operator_is_done() && jobs.is_playing() && !jobs.operator_is_done());
    jobs.wait_for_operator();
    assert!(jobs.set_paused(true));
    assert!(!jobs.waits_for_operator(), "a pause is another wait");
    jobs.close(&mut card);
    assert!(!jobs.set_paused(false) && !jobs.is_open());
}
