//! `pprint`: values as text, dicts in the order of their keys.

use crate::fault::Result;
use crate::run::{DEEPEST, Run};
use crate::value::Value;

/// A value as `pprint` writes it, on one line.
pub fn pretty(run: &mut Run<'_, '_>, value: Value) -> Result<Value> {
    let value = run.settle(value, DEEPEST)?;
    run.to_repr(value).map(Value::Str)
}
