//! A code while the function that belongs to it carries it out.

use config::MachineConfig;
use program::Words;

use crate::failure::Texts;
use crate::sessions::Reply;

/// Words of a code, and what every function of the table of codes may take to carry it out.
#[derive(Debug)]
pub struct CodeContext<'a, P> {
    /// Texts of failures.
    pub texts: &'a Texts,
    /// The ports.
    pub ports: &'a mut P,
    /// Configuration of the machine.
    pub config: &'a MachineConfig,
    /// Words of the code.
    pub words: &'a Words<'a>,
    /// Reply to whoever sent the code.
    pub reply: &'a mut Reply<'a>,
}
