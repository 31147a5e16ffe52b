//! Tests of the service with a minimal card; a full model is tested in `sim`.

mod card;
mod order;
mod reading;
mod users;
