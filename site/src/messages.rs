//! Last messages of the machine: faults, warnings and what it told, without the answers to lines, which would
//! soon be all that is left of what was said.

use heapless::{Deque, String};
use http::json::Writer;

use crate::remedies::remedy;

/// Messages that are kept.
pub const MESSAGES: usize = 5;

/// Longest text of a message, bytes.
pub const TEXT_BYTES: usize = 120;

/// Kinds of messages: how their lines begin, whether that is part of the text, and their level.
const KINDS: [(&str, bool, &str); 6] = [
    ("ALARM:", true, "error"),
    ("ERROR:", true, "error"),
    ("error:", false, "error"),
    ("WARNING:", false, "warning"),
    ("//", false, "info"),
    ("echo:", false, "info"),
];

#[derive(Debug)]
struct Message {
    text: String<TEXT_BYTES>,
    level: &'static str,
    /// What to do; empty where nothing is to be done.
    remedy: &'static str,
    /// Time since the start, seconds.
    at_s: u32,
}

/// Last messages, the oldest one first.
#[derive(Debug, Default)]
pub struct Messages {
    kept: Deque<Message, MESSAGES>,
    /// Messages so far.
    taken: u32,
}

impl Messages {
    /// Makes the messages of a machine that has said nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { kept: Deque::new(), taken: 0 }
    }

    /// Takes a line that everybody hears, if it is a message. A text that is too long is cut: the console has
    /// it whole.
    pub fn take(&mut self, line: &str, at_s: u32) {
        let mut kinds = KINDS.iter();
        let Some((begin, is_text, level)) = kinds.find(|(begin, ..)| line.starts_with(begin)) else { return };
        let words = line.get(if *is_text { 0 } else { begin.len() }..).unwrap_or_default().trim();
        let mut text = String::new();
        words.chars().for_each(|letter| drop(text.push(letter)));
        if self.kept.is_full() {
            self.kept.pop_front();
        }
        // Room was made.
        let remedy = if *is_text { remedy(words) } else { "" };
        let _ = self.kept.push_back(Message { text, level, remedy, at_s });
        self.taken = self.taken.wrapping_add(1);
    }

    /// Returns the number of messages so far.
    #[must_use]
    pub const fn taken(&self) -> u32 {
        self.taken
    }

    /// Writes the message at a place, if there is one.
    pub fn write(&self, place: usize, json: &mut Writer<'_, '_>) {
        let Some(Message { text, level, remedy, at_s }) = self.kept.iter().nth(place) else { return };
        json.begin_object();
        json.key("time");
        json.number(u64::from(*at_s));
        for (key, text) in [("level", *level), ("text", text), ("remedy", remedy)] {
            json.key(key);
            json.text(text);
        }
        json.end_object();
    }
}
