//! The sections of the file, each with its struct and its settings.

pub(crate) mod motion;
