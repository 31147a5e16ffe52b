//! The dialect of GRBL 1.1 where text meets a sender: its numbers, and its one answer for each line.

pub mod framing;
pub mod numbers;
