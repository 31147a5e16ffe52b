//! The schema: one table that names every setting once.
//!
//! The rows come from the declarations in `crate::sections`. The reader fills a description with the
//! defaults through the setters of those declarations, so what the reference says is what a missing line
//! means.

#[cfg(any(test, feature = "std"))]
mod examples;
#[cfg(any(test, feature = "std"))]
mod json;
#[cfg(any(test, feature = "std"))]
mod markdown;
mod section;
mod table;

pub use crate::setting::{ByName, Docs, Fallback, Kind, KlipperSection, PinRole, Setting, Since, Support, Unit, Words};
#[cfg(any(test, feature = "std"))]
pub use json::json_schema;
#[cfg(any(test, feature = "std"))]
pub(crate) use json::quoted;
#[cfg(any(test, feature = "std"))]
pub use markdown::markdown;
pub(crate) use section::UNREAD;
pub use section::{CannotCreate, Form, Instances, Scope, Section};
pub(crate) use table::instance_of;
pub use table::{SECTIONS, by_v1_name, section};
