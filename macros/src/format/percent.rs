//! Values in the places of `%` signs: `"..." % values`.

use super::{Spec, number, write_text};
use crate::arguments::whole;
use crate::fault::{About, Fault, Result, Words};
use crate::memory::Text;
use crate::number::{Number, number as number_of};
use crate::run::{Run, numbers, wrong};
use crate::value::{Map, Value, View, types};

/// Values that are still to be written.
struct Values {
    all: Value,
    next: usize,
}

/// A text with values in the places of its `%` signs.
pub fn percent(run: &mut Run<'_, '_>, text: Text, all: Value) -> Result<Value> {
    let all = run.settle(all, crate::value::DEEPEST)?;
    let mut values = Values { all, next: 0 };
    let start = run.memory.top;
    let mut at = 0;
    let length = text.len();
    while at < length {
        let byte = run.memory.byte(text.at() + at);
        at += 1;
        if byte != b'%' {
            run.memory.push_byte(byte);
        } else {
            at = field(run, text, at, &mut values)?;
        }
    }
    let may_be_left = types::DICT | types::NAMESPACE | types::LIST | types::RANGE | types::UNDEFINED;
    if !all.is(may_be_left) && values.next < values.count(run) {
        return run.memory.fail(Words::TooManyValues);
    }
    Ok(Value::str(run.memory.text_since(start)))
}

impl Values {
    /// Number of the values: a tuple has several.
    fn count(&self, run: &mut Run<'_, '_>) -> usize {
        if self.all.is(types::TUPLE) { run.length(self.all).unwrap_or(0) } else { 1 }
    }

    fn take(&mut self, run: &mut Run<'_, '_>) -> Result<Value> {
        self.next += 1;
        if self.next > self.count(run) {
            return run.memory.fail(Words::ValueNotGiven);
        }
        if self.all.is(types::TUPLE) { run.element(self.all, self.next - 1) } else { Ok(self.all) }
    }

    /// A number of a form that is given as a value: `%*d`.
    fn take_number(&mut self, run: &mut Run<'_, '_>) -> Result<usize> {
        let value = self.take(run)?;
        Ok(usize::try_from(whole(run, value)?).unwrap_or(0).min(super::MOST))
    }
}

/// Appends one value; returns where its form ends.
fn field(run: &mut Run<'_, '_>, text: Text, mut at: usize, values: &mut Values) -> Result<usize> {
    let byte = |run: &Run<'_, '_>, at: usize| {
        if at < text.len() { run.memory.byte(text.at() + at) } else { 0 }
    };
    let mut spec = Spec::default();
    let mut named = None;
    if byte(run, at) == b'(' {
        let rest = text.rest(at + 1);
        let Some(end) = crate::chars::place_of(run.memory.text(rest), b')') else {
            return run.memory.fail(Words::PercentName);
        };
        let (name, View::Map(Map::Dict, head)) = (rest.part(0, end), values.all.view()) else {
            return run.memory.fail(Words::PercentName);
        };
        let Some(place) = run.find(head, Value::str(name))? else {
            return Err(Fault::about(&run.memory, Words::ValueNotGiven, name));
        };
        named = Some(run.memory.value(place + crate::value::SIZE));
        at += end + 2;
    }
    let is_zero;
    (is_zero, at) = flags(run.memory.bytes(text), at, &mut spec);
    if byte(run, at) == b'*' {
        (spec.width, at) = (values.take_number(run)?, at + 1);
    } else {
        (spec.width, at) = number(run.memory.bytes(text), at);
    }
    if byte(run, at) == b'.' {
        at += 1;
        let precision;
        if byte(run, at) == b'*' {
            (precision, at) = (values.take_number(run)?, at + 1);
        } else {
            (precision, at) = number(run.memory.bytes(text), at);
        }
        spec.precision = Some(precision);
    }
    while matches!(byte(run, at), b'l' | b'h' | b'L') {
        at += 1;
    }
    spec.form = byte(run, at);
    if spec.form == b'%' {
        run.memory.push_byte(b'%');
        return Ok(at + 1);
    }
    if is_zero && spec.align == 0 && !matches!(spec.form, b's' | b'r' | b'c') {
        (spec.fill, spec.align) = ('0', b'=');
    }
    let value = match named {
        Some(value) => value,
        None => values.take(run)?,
    };
    write(run, value, spec)?;
    Ok(at + 1)
}

/// Reads the flags of a form; returns whether it fills with zeros, and where they end.
fn flags(bytes: &[u8], mut at: usize, spec: &mut Spec) -> (bool, usize) {
    let mut is_zero = false;
    loop {
        match bytes.get(at) {
            Some(b'-') => spec.align = b'<',
            Some(b'0') => is_zero = true,
            Some(b'+') => spec.sign = b'+',
            Some(b' ') if spec.sign != b'+' => spec.sign = b' ',
            Some(b' ') => {}
            Some(b'#') => spec.is_alternate = true,
            _ => return (is_zero, at),
        }
        at += 1;
    }
}

fn write(run: &mut Run<'_, '_>, value: Value, mut spec: Spec) -> Result<()> {
    if spec.align == 0 {
        spec.align = b'>';
    }
    let from = run.memory.top;
    match spec.form {
        b's' | b'r' | b'a' => {
            let text = if spec.form == b's' { run.text_of(value)? } else { run.repr_of(value)? };
            let start = run.memory.top;
            write_text(&mut run.memory, text, &spec);
            run.memory.close_gap(from, start);
            Ok(())
        }
        b'd' | b'i' | b'u' | b'x' | b'X' | b'o' => {
            let whole = match number_of(&run.memory, value) {
                Some(Number::Int(value)) => Some(value),
                Some(Number::Float(value)) if matches!(spec.form, b'd' | b'i' | b'u') => numbers::truncate(value),
                _ => None,
            };
            let Some(whole) = whole else {
                return Err(wrong(&run.memory, Words::WantsWhole, value));
            };
            if matches!(spec.form, b'i' | b'u') {
                spec.form = b'd';
            }
            super::number::write_int(&mut run.memory, whole, &spec)
        }
        b'e' | b'E' | b'f' | b'F' | b'g' | b'G' => match number_of(&run.memory, value) {
            Some(number) => super::number::write_real(&mut run.memory, crate::number::float(number), &spec),
            None => Err(wrong(&run.memory, Words::WantsNumber, value)),
        },
        b'c' => {
            let Some(text) = value.text() else {
                let int = whole(run, value)?;
                return super::number::write_int(&mut run.memory, int, &spec);
            };
            if crate::chars::count(run.memory.text(text)) != 1 {
                return Err(wrong(&run.memory, Words::OneCharacter, value));
            }
            spec.precision = None;
            write_text(&mut run.memory, text, &spec);
            Ok(())
        }
        form => Err(Fault::with(&run.memory, Words::NoForm, About::Byte(form))),
    }
}
