//! Codec of events: to words of memory, and back.
//!
//! A firmware may find events that another version wrote: a change of a kind's meaning, or of its number,
//! must change [`crate::ring::FORMAT`] too. A test holds both.

use crate::ring::PAYLOAD_WORDS;
use crate::{Cause, DateTime, Event, TEXT_BYTES, Text};

/// The words of an event.
#[derive(Clone, Copy, Debug)]
pub struct Words {
    words: [u32; PAYLOAD_WORDS],
    /// Number of words that were written, or read.
    pub count: usize,
}

impl Words {
    /// Creates a reader of these words, or a writer over them.
    pub const fn new(words: [u32; PAYLOAD_WORDS]) -> Self {
        Self { words, count: 0 }
    }

    /// Returns the words that were written.
    pub fn written(&self) -> &[u32] {
        self.words.get(..self.count).unwrap_or_default()
    }

    fn put(&mut self, word: u32) {
        if let Some(place) = self.words.get_mut(self.count) {
            *place = word;
            self.count += 1;
        }
    }

    fn put_text(&mut self, text: &Text) {
        let bytes = text.as_str().as_bytes();
        self.put(bytes.len() as u32);
        for four in bytes.chunks(4) {
            self.put(four.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte)));
        }
    }

    fn take(&mut self) -> Option<u32> {
        let word = self.words.get(self.count).copied()?;
        self.count += 1;
        Some(word)
    }

    fn take_text(&mut self) -> Option<Text> {
        let length = usize::try_from(self.take()?).ok().filter(|length| *length <= TEXT_BYTES)?;
        let mut bytes = [0; TEXT_BYTES];
        for four in bytes.get_mut(..length)?.chunks_mut(4) {
            let word = self.take()?.to_le_bytes();
            four.copy_from_slice(word.get(..four.len())?);
        }
        core::str::from_utf8(bytes.get(..length)?).ok().map(Text::from)
    }

    fn put_date(&mut self, date: Option<&DateTime>) {
        let Some(DateTime { year, month, day, hour, minute, second }) = date else { return self.put(0) };
        self.put(u32::from(*year) << 16 | u32::from(*month) << 8 | u32::from(*day));
        self.put(u32::from(*hour) << 16 | u32::from(*minute) << 8 | u32::from(*second));
    }

    fn take_date(&mut self) -> Option<Option<DateTime>> {
        let day = self.take()?;
        if day == 0 {
            return Some(None);
        }
        let time = self.take()?;
        let [day, month, year @ ..] = day.to_le_bytes();
        let [second, minute, hour, _] = time.to_le_bytes();
        Some(Some(DateTime { year: u16::from_le_bytes(year), month, day, hour, minute, second }))
    }

    fn take_flag(&mut self) -> Option<bool> {
        Some(self.take()? != 0)
    }
}

/// Encodes an event into words; returns its kind.
pub fn encode(event: &Event, words: &mut Words) -> u8 {
    match event {
        Event::Started { cause, date } => {
            words.put(*cause as u32);
            words.put_date(date.as_ref());
            1
        }
        Event::Ended(text) => put_text(words, text, 2),
        Event::ResetAsked => 3,
        Event::Silent(tasks) => put(words, [u32::from(*tasks)], 4),
        Event::ConfigurationRead { took_ms, findings } => put(words, [*took_ms, *findings], 5),
        Event::ConfigurationFlawed { errors } => put(words, [*errors], 6),
        Event::ConfigurationUnreadable(text) => put_text(words, text, 7),
        Event::State(text) => put_text(words, text, 8),
        Event::Halted(text) => put_text(words, text, 9),
        Event::Released => 10,
        Event::JobBegan(text) => put_text(words, text, 11),
        Event::JobSuspended { line } => put(words, [*line], 12),
        Event::JobResumed { line } => put(words, [*line], 13),
        Event::JobEnded { complete, line } => put(words, [u32::from(*complete), *line], 14),
        Event::Target { heater, celsius } => {
            words.put(celsius.to_bits());
            put_text(words, heater, 15)
        }
        Event::Driver { motor, trouble } => {
            words.put(u32::from(*motor));
            put_text(words, trouble, 16)
        }
        Event::MotorSupply { on } => put(words, [u32::from(*on)], 17),
        Event::HeaterSupply { on } => put(words, [u32::from(*on)], 18),
        Event::CardMounted => 19,
        Event::CardFailed(text) => put_text(words, text, 20),
        Event::Homed { axes } => put(words, [u32::from(*axes)], 21),
        Event::SessionOpened { session } => put(words, [u32::from(*session)], 22),
        Event::SessionClosed { session } => put(words, [u32::from(*session)], 23),
        Event::Warned(text) => put_text(words, text, 24),
        Event::Noted(text) => put_text(words, text, 25),
        Event::UpdateAsked(text) => put_text(words, text, 26),
        Event::UpdateRefused(text) => put_text(words, text, 27),
        Event::FirmwareTried { start } => put(words, [u32::from(*start)], 28),
        Event::FirmwareConfirmed => 29,
        Event::FirmwareFellBack(text) => put_text(words, text, 30),
    }
}

fn put<const N: usize>(words: &mut Words, numbers: [u32; N], kind: u8) -> u8 {
    numbers.into_iter().for_each(|number| words.put(number));
    kind
}

fn put_text(words: &mut Words, text: &Text, kind: u8) -> u8 {
    words.put_text(text);
    kind
}

/// Decodes the event of this kind from these words; `None` when there is no such kind, or it has other words.
pub fn decode(kind: u8, words: &mut Words) -> Option<Event> {
    Some(match kind {
        1 => Event::Started { cause: *Cause::ALL.get(words.take()? as usize)?, date: words.take_date()? },
        2 => Event::Ended(words.take_text()?),
        3 => Event::ResetAsked,
        4 => Event::Silent(words.take()? as u8),
        5 => Event::ConfigurationRead { took_ms: words.take()?, findings: words.take()? },
        6 => Event::ConfigurationFlawed { errors: words.take()? },
        7 => Event::ConfigurationUnreadable(words.take_text()?),
        8 => Event::State(words.take_text()?),
        9 => Event::Halted(words.take_text()?),
        10 => Event::Released,
        11 => Event::JobBegan(words.take_text()?),
        12 => Event::JobSuspended { line: words.take()? },
        13 => Event::JobResumed { line: words.take()? },
        14 => Event::JobEnded { complete: words.take_flag()?, line: words.take()? },
        15 => {
            let celsius = f32::from_bits(words.take()?);
            Event::Target { heater: words.take_text()?, celsius }
        }
        16 => {
            let motor = char::from_u32(words.take()?)?;
            Event::Driver { motor, trouble: words.take_text()? }
        }
        17 => Event::MotorSupply { on: words.take_flag()? },
        18 => Event::HeaterSupply { on: words.take_flag()? },
        19 => Event::CardMounted,
        20 => Event::CardFailed(words.take_text()?),
        21 => Event::Homed { axes: words.take()? as u8 },
        22 => Event::SessionOpened { session: words.take()? as u8 },
        23 => Event::SessionClosed { session: words.take()? as u8 },
        24 => Event::Warned(words.take_text()?),
        25 => Event::Noted(words.take_text()?),
        26 => Event::UpdateAsked(words.take_text()?),
        27 => Event::UpdateRefused(words.take_text()?),
        28 => Event::FirmwareTried { start: words.take()? as u8 },
        29 => Event::FirmwareConfirmed,
        30 => Event::FirmwareFellBack(words.take_text()?),
        _ => return None,
    })
}

#[cfg(test)]
pub mod tests {
    use super::*;
    use crate::ring::FORMAT;
    use proptest::prelude::*;

    fn text() -> impl Strategy<Value = Text> {
        "[ -~é€]{0,120}".prop_map(|text| Text::from(text.as_str()))
    }

    /// Generates any event, of every kind.
    pub fn event() -> impl Strategy<Value = Event> {
        let date = proptest::option::of((2001..2100_u16, 1..13_u8, 1..32_u8, 0..24_u8, 0..60_u8, 0..60_u8));
        let date = date.prop_map(|date| {
            date.map(|(year, month, day, hour, minute, second)| DateTime { year, month, day, hour, minute, second })
        });
        let words = (text(), date, any::<u32>(), any::<u32>(), any::<bool>(), any::<char>(), 0..6_usize, 1..31_u8);
        words.prop_map(|(text, date, a, b, flag, letter, cause, kind)| match kind {
            1 => Event::Started { cause: Cause::ALL[cause], date },
            2 => Event::Ended(text),
            3 => Event::ResetAsked,
            4 => Event::Silent(a as u8),
            5 => Event::ConfigurationRead { took_ms: a, findings: b },
            6 => Event::ConfigurationFlawed { errors: a },
            7 => Event::ConfigurationUnreadable(text),
            8 => Event::State(text),
            9 => Event::Halted(text),
            10 => Event::Released,
            11 => Event::JobBegan(text),
            12 => Event::JobSuspended { line: a },
            13 => Event::JobResumed { line: a },
            14 => Event::JobEnded { complete: flag, line: a },
            15 => Event::Target { heater: text, celsius: a as f32 },
            16 => Event::Driver { motor: letter, trouble: text },
            17 => Event::MotorSupply { on: flag },
            18 => Event::HeaterSupply { on: flag },
            19 => Event::CardMounted,
            20 => Event::CardFailed(text),
            21 => Event::Homed { axes: a as u8 },
            22 => Event::SessionOpened { session: a as u8 },
            23 => Event::SessionClosed { session: a as u8 },
            24 => Event::Warned(text),
            25 => Event::Noted(text),
            26 => Event::UpdateAsked(text),
            27 => Event::UpdateRefused(text),
            28 => Event::FirmwareTried { start: a as u8 },
            29 => Event::FirmwareConfirmed,
            _ => Event::FirmwareFellBack(text),
        })
    }

    proptest! {
        #[test]
        fn what_was_put_into_words_comes_out_of_them(event in event()) {
            let mut words = Words::new([0xDEAD_BEEF; PAYLOAD_WORDS]);
            let kind = encode(&event, &mut words);
            let written = words.count;
            words.count = 0;
            prop_assert_eq!(decode(kind, &mut words), Some(event));
            prop_assert_eq!(words.count, written, "every word is read, and no other");
        }

        #[test]
        fn words_of_anything_are_read_without_a_panic(kind: u8, words in proptest::array::uniform28(any::<u32>())) {
            let _any = decode(kind, &mut Words::new(words));
        }
    }

    /// The events of a firmware can be read by the next, unless the format's number changes.
    #[test]
    fn the_format_is_what_its_number_says() {
        let mut sum = 0_u32;
        let mut kinds = 0;
        for kind in 0..=u8::MAX {
            // A length of 4, then letters; and no date.
            let mut words = Words::new([4; PAYLOAD_WORDS]);
            let Some(event) = decode(kind, &mut words) else { continue };
            kinds += 1;
            for byte in std::format!("{kind} {} {event:?}", words.count).bytes() {
                sum = (sum ^ u32::from(byte)).wrapping_mul(0x0100_0193);
            }
        }
        assert_eq!(
            (FORMAT, kinds, sum),
            (1, 30, 3_309_594_260),
            "change FORMAT with the meaning of a kind, and then this"
        );
    }
}
