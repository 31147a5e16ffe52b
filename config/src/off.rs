//! Parts of the machine that stay off because of an error in the file.

use crate::names::Name;
use heapless::String;

/// Parts that can be out of service at once; one more, and the machine does not start.
pub const MAX_OFF: usize = 24;

/// A part of the machine that stays off until the file is mended.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct OffModule {
    /// Section of the part.
    pub section: &'static str,
    /// Name of the instance; empty for the section as a whole.
    pub name: Name,
    /// Line of the finding; 0 when it concerns something the file does not say.
    pub line: u16,
    /// The setting, as `[switch] fan.output_pin`; empty when the finding is about none.
    pub key: String<56>,
}
