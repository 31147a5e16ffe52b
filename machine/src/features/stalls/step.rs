//! Steps of the recovery after a stall.

/// Step of the recovery after a stall has stopped a job.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Z rises, and the file is read up to where the job was.
    Lift,
    /// The job is suspended where it was, with Z raised and the file read.
    Suspend,
}
