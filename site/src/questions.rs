//! Questions and changes about files that visitors have asked for, over either way: as many at a time as
//! there is memory for. Whoever has asked goes on to be heard meanwhile: a stop waits for no list.

use base::ports::Storage;
use http::Role;
use http::json::{Next, Writer};

use crate::calls::Id;
use crate::files::{Ask, Files, Question, Refusal, Telling, Text, Visitor};

/// Questions at a time.
const QUESTIONS: usize = 3;
/// Refusal of a question while there are as many.
pub const FULL: &str = "other lists are being made: ask again";

/// Visitor who has asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Asker {
    /// Visitor of a WebSocket, at this seat.
    Seat(u8),
    /// Connection at this place.
    Connection(u8),
}

/// Question that is carried out or answered.
#[derive(Debug)]
struct Asked {
    asker: Asker,
    question: Question,
    text: Text,
    /// Id of the call, where it is one that wants an answer.
    id: Option<Id>,
}

/// Questions of all visitors.
#[derive(Debug, Default)]
pub struct Questions([Option<Asked>; QUESTIONS]);

impl Questions {
    /// Takes a question about what is named by a text. Returns its number, none if there are as many as can
    /// be.
    pub fn ask(&mut self, asker: Asker, ask: Ask, text: &str, id: Option<Id>) -> Option<u8> {
        let (number, free) = self.0.iter_mut().enumerate().find(|(_, asked)| asked.is_none())?;
        let text = Text::try_from(text).ok()?;
        *free = Some(Asked { asker, question: Question::new(ask), text, id });
        Some(number as u8)
    }

    fn get(&self, number: u8) -> Option<&Asked> {
        self.0.get(usize::from(number))?.as_ref()
    }

    fn get_mut(&mut self, number: u8) -> Option<&mut Asked> {
        self.0.get_mut(usize::from(number))?.as_mut()
    }

    /// Returns the numbers of questions that visitors of WebSockets have asked and that are not answered,
    /// with their seats.
    pub fn seats(&self) -> impl Iterator<Item = (u8, u8)> + use<> {
        let seats: [Option<u8>; QUESTIONS] = core::array::from_fn(|number| match self.get(number as u8) {
            Some(Asked { asker: Asker::Seat(seat), question, .. }) if !question.is_answered => Some(*seat),
            _ => None,
        });
        (0..).zip(seats).filter_map(|(number, seat)| Some((number, seat?)))
    }

    /// Returns the id of a question's call.
    pub fn id(&self, number: u8) -> Option<Id> {
        self.get(number).and_then(|asked| asked.id.clone())
    }

    /// Returns whether a question is carried out, and being answered.
    pub fn is_answered(&self, number: u8) -> bool {
        self.get(number).is_some_and(|asked| asked.question.is_answered)
    }

    /// Goes on with a question. None while there is more to do, and when it was done before.
    pub fn go_on(
        &mut self,
        number: u8,
        role: Role,
        files: &mut Files,
        card: &mut impl Storage,
        now_ms: u64,
    ) -> Option<Result<(), Refusal>> {
        let Asked { question, text, .. } = self.get_mut(number).filter(|asked| !asked.question.is_answered)?;
        let done = question.go_on((Visitor::Question(number), role), text, files, card, now_ms)?;
        question.is_answered = done.is_ok();
        Some(done)
    }

    /// Writes a part of the answer.
    pub fn write(
        &mut self,
        number: u8,
        part: u32,
        files: &mut Files,
        card: &mut impl Storage,
        now_ms: u64,
        json: &mut Writer<'_, '_>,
    ) -> Next {
        let Some(Asked { question, text, .. }) = self.get_mut(number) else { return Next::End };
        Telling { question, text, visitor: Visitor::Question(number), files, card, now_ms }.write(part, json)
    }

    /// Ends a question, answered or not.
    pub fn end(&mut self, number: u8, files: &mut Files, card: &mut impl Storage) {
        if let Some(asked) = self.0.get_mut(usize::from(number)) {
            *asked = None;
        }
        files.end_question(Visitor::Question(number), card);
    }

    /// Ends the questions of somebody who goes.
    pub fn leave(&mut self, asker: Asker, files: &mut Files, card: &mut impl Storage) {
        for number in 0..QUESTIONS as u8 {
            if self.get(number).is_some_and(|asked| asked.asker == asker) {
                self.end(number, files, card);
            }
        }
    }
}
