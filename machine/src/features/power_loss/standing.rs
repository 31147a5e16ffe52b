//! State of the program that a session's line may change while the journal notes a job.

use program::BEGINNING_BYTES;

/// State of the program that a session's line may change.
pub(crate) type Standing = ([u8; BEGINNING_BYTES], bool);
