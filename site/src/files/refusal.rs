//! Reasons why something about files is not done, for HTTP and for calls.

use base::ports::StorageError;
use http::Status;

/// Reason why a request is not carried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Refusal {
    /// Status of the answer; its number is the code of a call's error.
    pub status: Status,
    /// Sentence for a person.
    pub message: &'static str,
}

impl Refusal {
    /// Makes a refusal of this status and text.
    #[must_use]
    pub const fn new(status: Status, message: &'static str) -> Self {
        Self { status, message }
    }

    /// Makes a refusal of something that is malformed.
    #[must_use]
    pub const fn bad(message: &'static str) -> Self {
        Self::new(Status::BadRequest, message)
    }
}

impl From<StorageError> for Refusal {
    fn from(error: StorageError) -> Self {
        use StorageError as E;
        let status = match error {
            E::NotFound => Status::NotFound,
            E::Exists | E::Busy | E::WrongKind => Status::Conflict,
            E::BadPath => Status::BadRequest,
            E::ReadOnly | E::Protected | E::Exfat | E::Secret => Status::Forbidden,
            E::Full | E::DirectoryFull => Status::InsufficientStorage,
            E::NoCard | E::Lent | E::NotResponding | E::TooManyOpen => Status::ServiceUnavailable,
            E::NoFileSystem
            | E::LargerThanCard
            | E::Fat12
            | E::Ntfs
            | E::OddExfat
            | E::WrongCard
            | E::Locked
            | E::NotKept
            | E::Unreadable
            | E::WriteFailed
            | E::Damaged
            | E::Unsupported
            | E::Device => Status::InternalServerError,
        };
        Self::new(status, error.text())
    }
}
