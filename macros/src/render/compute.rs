//! Operators, comparisons and subscripts of values.

use core::cmp::Ordering;

use super::Machine;
use crate::code::Op;
use crate::fault::{Result, Words};
use crate::number::{Number, number};
use crate::run::order::{contains, equal, order};
use crate::run::{Run, numbers, wrong};
use crate::value::{DEEPEST, Value};

/// Whether a comparison holds.
pub fn compare(run: &mut Run<'_, '_>, op: Op, a: Value, b: Value) -> Result<bool> {
    Ok(match op {
        Op::Equal => equal(run, a, b, DEEPEST)?,
        Op::Unequal => !equal(run, a, b, DEEPEST)?,
        Op::In => contains(run, a, b)?,
        Op::NotIn => !contains(run, a, b)?,
        _ => {
            let order = order(run, a, b, DEEPEST)?;
            match op {
                Op::Less => order == Some(Ordering::Less),
                Op::AtMost => matches!(order, Some(Ordering::Less | Ordering::Equal)),
                Op::Greater => order == Some(Ordering::Greater),
                _ => matches!(order, Some(Ordering::Greater | Ordering::Equal)),
            }
        }
    })
}

impl Machine<'_, '_> {
    /// Carries out an instruction that makes one value of the last ones.
    #[inline(never)]
    pub fn compute(&mut self, op: Op) -> Result<()> {
        let name = if op == Op::Attribute { Some(self.string()) } else { None };
        let last = self.run.memory.pop();
        let run = &mut self.run;
        let result = match (op, name) {
            (_, Some(name)) => run.attribute(last, name)?,
            (Op::Not, _) => Value::bool(!run.truth(last)),
            (Op::Negative | Op::Positive, _) => sign(run, last, op == Op::Negative)?,
            (Op::Slice, _) => {
                let (to, from) = (run.memory.pop(), run.memory.pop());
                let value = run.memory.pop();
                run.slice(value, [from, to, last])?
            }
            _ => {
                let first = run.memory.pop();
                self.two(op, first, last)?
            }
        };
        self.run.memory.push(result);
        Ok(())
    }

    fn two(&mut self, op: Op, a: Value, b: Value) -> Result<Value> {
        let run = &mut self.run;
        if let (Op::Modulo, Some(text)) = (op, a.text()) {
            return crate::format::percent(run, text, b);
        }
        match op {
            Op::Item => run.item(a, b),
            Op::Join => {
                let a = run.text_of(a)?;
                let b = run.text_of(b)?;
                Ok(run.join_two(a, b))
            }
            Op::Add | Op::Subtract | Op::Multiply | Op::Divide | Op::FloorDivide | Op::Modulo | Op::Power => {
                numbers::calculate(run, op, a, b)
            }
            _ => compare(run, op, a, b).map(Value::bool),
        }
    }
}

fn sign(run: &mut Run<'_, '_>, value: Value, is_negative: bool) -> Result<Value> {
    match number(&run.memory, value) {
        Some(Number::Int(int)) => Ok(run.memory.int(if is_negative { int.wrapping_neg() } else { int })),
        Some(Number::Float(float)) => Ok(Value::float(if is_negative { -float } else { float })),
        None => Err(wrong(&run.memory, Words::WantsNumber, value)),
    }
}
