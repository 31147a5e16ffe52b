//! Jobs that go on after a power cut: the journal of a job, and the way back from it.

pub(crate) mod job_recovery;
pub(crate) mod journal;
