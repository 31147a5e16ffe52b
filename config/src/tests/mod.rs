//! Tests of the schema as a whole.

mod facts;
mod schema;
