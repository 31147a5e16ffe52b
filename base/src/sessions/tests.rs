use super::*;
use crate::sessions::ConsoleKind;
use std::boxed::Box;
use std::collections::VecDeque;
use std::vec::Vec;

/// Two lines whose other ends are in memory.
struct Desk {
    inboxes: [Box<Inbox>; 2],
    intakes: [Intake; 2],
    /// Output of each line, and the number of bytes that it still takes.
    output: [(VecDeque<u8>, usize); 2],
    kinds: [ConsoleKind; 2],
    /// Nothing is received, and the desk says so.
    is_quiet: bool,
}

impl Desk {
    fn new() -> Self {
        let visited: Box<Inbox> = Box::<InboxOf<1_024>>::default();
        visited.set_open(false);
        Self {
            inboxes: [Box::<InboxOf<INBOX_BYTES>>::default(), visited],
            intakes: [Intake::new(); 2],
            output: [(VecDeque::new(), usize::MAX), (VecDeque::new(), usize::MAX)],
            kinds: [ConsoleKind::Serial, ConsoleKind::Network],
            is_quiet: false,
        }
    }

    fn type_on(&mut self, id: usize, text: &str) {
        text.bytes().for_each(|byte| assert!(self.inboxes[id].receive(&mut self.intakes[id], byte)));
    }

    fn read(&mut self, id: usize) -> String {
        String::from_utf8(self.output[id].0.drain(..).collect()).unwrap()
    }
}

impl Consoles for Desk {
    fn sessions(&self) -> u8 {
        2
    }

    fn inbox(&self, id: SessionId) -> &Inbox {
        &self.inboxes[usize::from(id.0)]
    }

    fn have_news(&self) -> bool {
        !self.is_quiet
    }

    fn profile(&self, id: SessionId) -> SessionProfile {
        let kind = self.kinds[usize::from(id.0)];
        SessionProfile { kind, rights: Rights::Operate, dialect: None, greeting: "hello\n" }
    }

    fn write(&mut self, id: SessionId, bytes: &[u8]) -> usize {
        let (output, room) = &mut self.output[usize::from(id.0)];
        let taken = bytes.len().min(*room);
        *room -= taken;
        output.extend(&bytes[..taken]);
        taken
    }
}

fn sessions(desk: &Desk) -> Sessions {
    let mut sessions = Sessions::new();
    sessions.configure(desk);
    sessions
}

fn gather(sessions: &mut Sessions, desk: &Desk) {
    for id in sessions.ids() {
        sessions.get_mut(id).unwrap().gather(desk.inbox(id));
    }
}

fn greet(sessions: &mut Sessions, desk: &Desk) {
    assert!(sessions.is_visited_anew(desk, SessionId(1)));
    let (visitor, unfinished) = sessions.follow_visitor(desk, SessionId(1));
    assert!(visitor != Visitor::Waits && unfinished.is_none());
    assert!(!sessions.is_visited_anew(desk, SessionId(1)));
}

fn take(sessions: &mut Sessions) -> Option<(u8, Vec<u8>)> {
    let id = sessions.next_ready(false)?;
    let session = sessions.get_mut(id)?;
    let line = session.take_line()?;
    session.answered();
    Some((id.0, line.to_vec()))
}

#[test]
fn a_waiting_line_holds_back_the_bytes_behind_it() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    desk.type_on(1, "G28\nM105\n");
    gather(&mut sessions, &desk);
    gather(&mut sessions, &desk);
    assert_eq!(take(&mut sessions), Some((1, b"G28".to_vec())));
    assert_eq!(take(&mut sessions), None);
    gather(&mut sessions, &desk);
    assert_eq!(take(&mut sessions), Some((1, b"M105".to_vec())));
}

#[test]
fn sessions_take_turns() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    let mut order = Vec::new();
    desk.type_on(0, "a\nb\n");
    desk.type_on(1, "a\nb\n");
    for _ in 0..4 {
        gather(&mut sessions, &desk);
        order.push(take(&mut sessions).unwrap().0);
    }
    assert_eq!(order, [0, 1, 0, 1]);
}

#[test]
fn what_is_said_goes_to_those_who_are_meant() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    sessions.say(Recipient::Session(SessionId(1)), format_args!("ok {}\n", 7));
    sessions.say(Recipient::All, format_args!("x"));
    sessions.say(Recipient::Nobody, format_args!("y"));
    sessions.flush(&mut desk, Micros(0));
    assert_eq!((desk.read(0), desk.read(1)), ("x".into(), "ok 7\nx".into()));
}

#[test]
fn a_session_that_is_not_read_gets_no_turn_until_it_is_or_nobody_listens() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    desk.output[0].1 = 0;
    for _ in 0..100 {
        sessions.say(Recipient::Session(SessionId(0)), format_args!("a long answer\n"));
    }
    desk.type_on(0, "a\n");
    desk.type_on(1, "b\n");
    gather(&mut sessions, &desk);
    sessions.flush(&mut desk, Micros::from_millis(1));
    assert_eq!(take(&mut sessions), Some((1, b"b".to_vec())));
    assert_eq!(take(&mut sessions), None, "its output is full");
    sessions.flush(&mut desk, Micros::from_seconds(3));
    assert_eq!(take(&mut sessions), Some((0, b"a".to_vec())), "nobody listens");
}

#[test]
fn whoever_comes_is_greeted_and_finds_nothing_of_the_one_before() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    desk.inboxes[1].set_open(true);
    greet(&mut sessions, &desk);
    desk.type_on(1, "half a li");
    gather(&mut sessions, &desk);
    sessions.flush(&mut desk, Micros(0));
    assert_eq!(desk.read(1), "hello\n");
    desk.inboxes[1].set_open(false);
    greet(&mut sessions, &desk);
    desk.inboxes[1].set_open(true);
    greet(&mut sessions, &desk);
    desk.type_on(1, "whole\n");
    gather(&mut sessions, &desk);
    assert_eq!(take(&mut sessions), Some((1, b"whole".to_vec())));
}

#[test]
fn what_was_sent_whole_is_carried_out_before_whoever_comes_next() {
    let mut desk = Desk::new();
    let Desk { inboxes, intakes, .. } = &mut desk;
    inboxes[1].open(&mut intakes[1]);
    let mut sessions = sessions(&desk);
    desk.type_on(1, "G28\nG1 X5\nG1 Y");
    gather(&mut sessions, &desk);
    desk.inboxes[1].set_open(false);
    assert_eq!(sessions.follow_visitor(&desk, SessionId(1)).0, Visitor::Left);
    sessions.say(Recipient::Session(SessionId(1)), format_args!("ok\n"));
    let Desk { inboxes, intakes, .. } = &mut desk;
    inboxes[1].open(&mut intakes[1]);
    desk.type_on(1, "M105\n");
    let mut done = Vec::new();
    for _ in 0..4 {
        if sessions.is_visited_anew(&desk, SessionId(1)) {
            sessions.follow_visitor(&desk, SessionId(1));
        }
        gather(&mut sessions, &desk);
        if let Some((_, line)) = take(&mut sessions) {
            done.push(String::from_utf8(line).unwrap());
            sessions.say(Recipient::Session(SessionId(1)), format_args!("ok {}\n", done.len()));
        }
        sessions.flush(&mut desk, Micros(0));
    }
    assert_eq!(done, ["G28", "G1 X5", "M105"], "half a line is none");
    assert_eq!(desk.read(1), "hello\nok 3\n", "answers go to who has asked");
}

#[test]
fn what_is_said_over_usb_waits_as_long_as_somebody_is_there() {
    let mut desk = Desk::new();
    desk.kinds[1] = ConsoleKind::Usb;
    let Desk { inboxes, intakes, .. } = &mut desk;
    inboxes[1].open(&mut intakes[1]);
    let mut sessions = sessions(&desk);
    desk.output[1].1 = 0;
    (0..60).for_each(|_| sessions.say(Recipient::Session(SessionId(1)), format_args!("a long answer\n")));
    sessions.flush(&mut desk, Micros(0));
    assert!(!sessions.have_taken_most(Recipient::All));
    sessions.flush(&mut desk, Micros::from_seconds(100));
    assert!(sessions.have_taken_most(Recipient::All), "the machine does not wait for it");
    desk.type_on(1, "M105\n");
    gather(&mut sessions, &desk);
    assert_eq!(take(&mut sessions), None, "it does for the machine");
    desk.output[1].1 = usize::MAX;
    sessions.flush(&mut desk, Micros::from_seconds(101));
    assert_eq!(desk.read(1).len(), 60 * 14, "and nothing is lost");
}

#[test]
fn whoever_left_and_came_between_two_looks_has_left_first() {
    let mut desk = Desk::new();
    let Desk { inboxes, intakes, .. } = &mut desk;
    inboxes[1].open(&mut intakes[1]);
    let mut sessions = sessions(&desk);
    sessions.notice = "mind the step\n";
    desk.inboxes[1].set_open(false);
    let Desk { inboxes, intakes, .. } = &mut desk;
    inboxes[1].open(&mut intakes[1]);
    assert_eq!(sessions.follow_visitor(&desk, SessionId(1)).0, Visitor::Left);
    assert!(sessions.has_left(Recipient::Session(SessionId(1))), "what he moved by hand stops");
    assert_eq!(sessions.follow_visitor(&desk, SessionId(1)).0, Visitor::Came);
    sessions.flush(&mut desk, Micros(0));
    assert_eq!(desk.read(1), "hello\nmind the step\n");
}

#[test]
fn the_sender_of_a_line_has_left_when_another_peer_is_there() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    let Desk { inboxes, intakes, .. } = &mut desk;
    inboxes[1].open(&mut intakes[1]);
    greet(&mut sessions, &desk);
    let asks = Recipient::Session(SessionId(1));
    desk.type_on(1, "G28\n");
    gather(&mut sessions, &desk);
    assert_eq!(take(&mut sessions), Some((1, b"G28".to_vec())));
    assert!(!sessions.has_left(asks) && !sessions.has_left(Recipient::All));
    desk.inboxes[1].set_open(false);
    assert!(sessions.is_visited_anew(&desk, SessionId(1)));
    sessions.follow_visitor(&desk, SessionId(1));
    assert!(sessions.has_left(asks));
}

#[test]
fn a_session_wants_service_only_while_there_is_something_to_do() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    let wants = |sessions: &Sessions, desk: &Desk| sessions.get(SessionId(0)).unwrap().wants_service(&desk.inboxes[0]);
    assert!(!wants(&sessions, &desk));
    desk.type_on(0, "M105\n");
    gather(&mut sessions, &desk);
    assert!(wants(&sessions, &desk), "a whole line that nobody has looked at");
}

#[test]
fn reports_that_nobody_asked_for_are_not_due() {
    let desk = Desk::new();
    let mut sessions = sessions(&desk);
    assert_eq!(sessions.get_mut(SessionId(0)).unwrap().take_due(Micros::from_seconds(900)), [false; 3]);
}

#[test]
fn silent_sessions_are_not_looked_at_until_something_is_received_or_said() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    sessions.flush(&mut desk, Micros(0));
    desk.is_quiet = true;
    assert!(!sessions.want_service(&desk));
    sessions.say(Recipient::Nobody, format_args!("lines of a file"));
    assert!(!sessions.want_service(&desk));
    sessions.say(Recipient::All, format_args!("a fault\n"));
    assert!(sessions.want_service(&desk));
    desk.type_on(0, "G28\n");
    sessions.flush(&mut desk, Micros(1));
    assert!(sessions.want_service(&desk), "a byte waits that nobody has gathered");
    gather(&mut sessions, &desk);
    sessions.flush(&mut desk, Micros(2));
    assert!(sessions.want_service(&desk), "a line waits");
    assert!(take(&mut sessions).is_some());
    sessions.flush(&mut desk, Micros(3));
    assert!(!sessions.want_service(&desk));
    desk.is_quiet = false;
    assert!(sessions.want_service(&desk));
}

#[test]
fn a_listener_has_as_long_after_a_silence_as_at_any_time() {
    let mut desk = Desk::new();
    let mut sessions = sessions(&desk);
    sessions.flush(&mut desk, Micros(0));
    let after = |seconds: u64| Micros::from_seconds(10 + seconds);
    desk.output[0].1 = 0;
    sessions.say(Recipient::Session(SessionId(0)), format_args!("ok\n"));
    sessions.flush(&mut desk, after(0));
    sessions.flush(&mut desk, after(1));
    desk.output[0].1 = usize::MAX;
    sessions.flush(&mut desk, after(1));
    assert_eq!(desk.read(0), "ok\n");
    desk.output[0].1 = 0;
    sessions.say(Recipient::Session(SessionId(0)), format_args!("ok\n"));
    [2, 3, 5].into_iter().for_each(|seconds| sessions.flush(&mut desk, after(seconds)));
    desk.output[0].1 = usize::MAX;
    sessions.flush(&mut desk, after(6));
    assert_eq!(desk.read(0), "", "nobody listens");
}
