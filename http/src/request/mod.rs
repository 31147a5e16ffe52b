//! Requests: heads, and bodies out of their framing.

mod body;
mod head;
mod query;

pub use body::{BodyDecoder, Length};
pub use head::{Head, Request, Scan, Upgrade, scan};
pub use query::Query;
