//! Bodies of answers and notifications.

use base::snapshot::Snapshot;
use http::json::Next;
use http::{Body, Fields, Made};

use super::{Content, Facts, Reply, Teller, Tells};
use crate::batch::Batch;
use crate::console::Console;
use crate::path::Path;

/// Least room in which a part is made: each is shorter, so none is cut in two between two states of the
/// machine.
const PART_ROOM: usize = 960;
/// Signs around an answer that is one of several.
const SIGNS: usize = 2;

/// Body of a reply, with what it tells of.
pub struct ReplyBody<'r> {
    /// Reply that is made.
    pub reply: &'r mut Reply,
    /// The machine as it was shown last.
    pub snapshot: &'r Snapshot,
    /// Console with what the machine said.
    pub console: &'r Console,
    /// Path that the machine has made.
    pub path: &'r Path,
    /// Facts about the board.
    pub facts: Facts<'r>,
    /// Time since the start, milliseconds.
    pub now_ms: u64,
    /// Teller of content that is not the machine's state.
    pub teller: Option<Teller<'r>>,
    /// Answers that go out with the reply, as one array.
    pub batch: Option<&'r mut Batch>,
    /// Whether the reply is another one than this was made for.
    pub is_over: bool,
}

impl ReplyBody<'_> {
    /// Makes a piece of answers that go out as one array, up to the end of the present one: who tells of the
    /// next one may be somebody else.
    fn make_of_batch(&mut self, room: &mut [u8]) -> Made {
        let (Some(sign), Some(behind)) =
            (self.batch.as_mut().map(|batch| batch.take_sign()), room.len().checked_sub(1))
        else {
            return Made::Part(0);
        };
        let signs = room.iter_mut().zip(sign).map(|(place, sign)| *place = sign).count();
        match self.make_one(room.get_mut(signs..behind).unwrap_or_default()) {
            Made::Failed => Made::Failed,
            Made::Part(count) => Made::Part(signs + count),
            Made::Last(count) => {
                let used = signs + count;
                match self.batch.take().and_then(Batch::next) {
                    Some(next) => {
                        *self.reply = next;
                        self.is_over = true;
                        Made::Part(used)
                    }
                    None => {
                        room.iter_mut().skip(used).take(1).for_each(|place| *place = b']');
                        Made::Last(used + 1)
                    }
                }
            }
        }
    }

    fn make_one(&mut self, room: &mut [u8]) -> Made {
        let Self {
            reply: Reply { id, is_message, content, parts, .. },
            snapshot,
            console,
            path,
            facts,
            now_ms,
            teller,
            ..
        } = self;
        let tells = Tells {
            id: id.as_ref(),
            is_message: *is_message,
            content,
            snapshot,
            console,
            path,
            facts: *facts,
            now_ms: *now_ms,
        };
        parts.make(room, |part, json| match (part.checked_sub(1), teller.as_deref_mut()) {
            (Some(part), Some(teller)) => {
                let next = teller(part, json);
                if next == Next::End {
                    tells.end(json);
                }
                next
            }
            _ => tells.write(part, json),
        })
    }
}

impl Body for ReplyBody<'_> {
    fn fields(&self, fields: &mut Fields<'_, '_>) {
        if let Content::Access(told) = &self.reply.content {
            told.fields(fields);
        }
    }

    fn make(&mut self, room: &mut [u8]) -> Made {
        if room.len() < PART_ROOM + SIGNS || self.is_over {
            return Made::Part(0);
        }
        if self.batch.is_some() { self.make_of_batch(room) } else { self.make_one(room) }
    }
}
