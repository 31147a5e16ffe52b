//! `"...".format(values)`

use super::{Spec, number, write_text};
use crate::arguments::Arguments;
use crate::fault::{Fault, Result, Words};
use crate::memory::{Memory, Text};
use crate::number::{Number, number as number_of};
use crate::run::{Run, wrong};
use crate::value::{Value, types};

/// A text with values in the places of its braces.
pub fn braces(run: &mut Run<'_, '_>, text: Text, arguments: &Arguments) -> Result<Value> {
    fill(run, text, arguments, &mut 0, true).map(Value::str)
}

/// Fills the braces of a text, or of the form in braces, which may not have braces within its own.
fn fill(run: &mut Run<'_, '_>, text: Text, arguments: &Arguments, next: &mut usize, may_nest: bool) -> Result<Text> {
    let start = run.memory.top;
    let mut at = 0;
    while at < text.len() {
        let byte = |at: usize| if at < text.len() { run.memory.byte(text.at() + at) } else { 0 };
        let (this, following) = (byte(at), byte(at + 1));
        at += 1;
        match this {
            b'{' | b'}' if following == this => {
                run.memory.push_byte(this);
                at += 1;
            }
            b'{' => {
                let rest = text.rest(at);
                let Some(end) = end_of_field(run.memory.text(rest)) else {
                    return run.memory.fail(Words::BraceMissing);
                };
                field(run, rest.part(0, end), arguments, next, may_nest)?;
                at += end + 1;
            }
            b'}' => return run.memory.fail(Words::BraceMissing),
            _ => run.memory.push_byte(this),
        }
    }
    Ok(run.memory.text_since(start))
}

/// Place of the brace that closes a field.
fn end_of_field(text: &str) -> Option<usize> {
    let mut open = 0;
    text.bytes().position(|byte| match byte {
        b'{' => {
            open += 1;
            false
        }
        b'}' if open == 0 => true,
        b'}' => {
            open -= 1;
            false
        }
        _ => false,
    })
}

fn field(run: &mut Run<'_, '_>, field: Text, arguments: &Arguments, next: &mut usize, may_nest: bool) -> Result<()> {
    let string = run.memory.text(field);
    let name_end = string.bytes().position(|byte| matches!(byte, b':' | b'!')).unwrap_or(string.len());
    let name = field.part(0, name_end);
    let rest = string.get(name_end..).unwrap_or_default();
    let (conversion, form_at) = match rest.as_bytes() {
        [b'!', letter @ (b's' | b'r'), b':', ..] => (*letter, name_end + 3),
        [b'!', letter @ (b's' | b'r')] => (*letter, name_end + 2),
        [b'!', ..] => return run.memory.fail(Words::Conversion),
        [b':', ..] => (0, name_end + 1),
        _ => (0, name_end),
    };
    let word = run.memory.text(name);
    let value = if word.is_empty() {
        *next += 1;
        arguments.position(run, *next - 1)
    } else if word.bytes().all(|byte| byte.is_ascii_digit()) {
        arguments.position(run, number(word.as_bytes(), 0).0)
    } else {
        arguments.keyword(run, name)
    };
    let Some(value) = value else {
        return Err(Fault::about(&run.memory, Words::ValueNotGiven, name));
    };
    let from = run.memory.top;
    let mut form = field.rest(form_at);
    if run.memory.bytes(form).contains(&b'{') {
        if !may_nest {
            return run.memory.fail(Words::NestedBraces);
        }
        form = fill(run, form, arguments, next, false)?;
    }
    let spec = read_spec(&run.memory, run.memory.text(form))?;
    let value = match conversion {
        b'r' => Value::str(run.repr_of(value)?),
        b's' => Value::str(run.text_of(value)?),
        _ => value,
    };
    let start = run.memory.top;
    write(run, value, &spec)?;
    run.memory.close_gap(from, start);
    Ok(())
}

fn read_spec(memory: &Memory<'_>, text: &str) -> Result<Spec> {
    let mut spec = Spec::default();
    let mut chars = text.chars();
    let mut at = 0;
    if let (Some(first), Some(second)) = (chars.next(), chars.next())
        && matches!(second, '<' | '>' | '^' | '=')
    {
        (spec.fill, spec.align) = (first, second as u8);
        at = first.len_utf8() + 1;
    }
    let bytes = text.as_bytes();
    let byte = |at: usize| bytes.get(at).copied().unwrap_or(0);
    if spec.align == 0 && matches!(byte(at), b'<' | b'>' | b'^' | b'=') {
        (spec.align, at) = (byte(at), at + 1);
    }
    if matches!(byte(at), b'+' | b'-' | b' ') {
        (spec.sign, at) = (byte(at), at + 1);
    }
    if byte(at) == b'#' {
        (spec.is_alternate, at) = (true, at + 1);
    }
    if byte(at) == b'0' {
        at += 1;
        if spec.align == 0 {
            (spec.fill, spec.align) = ('0', b'=');
        }
    }
    (spec.width, at) = number(bytes, at);
    if matches!(byte(at), b',' | b'_') {
        (spec.comma, at) = (byte(at), at + 1);
    }
    if byte(at) == b'.' {
        let (precision, end) = number(bytes, at + 1);
        if end == at + 1 {
            return memory.fail(Words::FormPoint);
        }
        (spec.precision, at) = (Some(precision), end);
    }
    spec.form = byte(at);
    if at + 1 < bytes.len() {
        return Err(memory.fault(Words::FormLong));
    }
    Ok(spec)
}

/// Appends a value in the form that its braces ask for.
fn write(run: &mut Run<'_, '_>, value: Value, spec: &Spec) -> Result<()> {
    let from = run.memory.top;
    let is_real = matches!(spec.form, b'e' | b'E' | b'f' | b'F' | b'g' | b'G' | b'%');
    let memory = &mut run.memory;
    if let Some(is) = value.as_bool()
        && spec.form == 0
        && spec.width == 0
    {
        memory.push_bytes(if is { b"True" } else { b"False" });
        return Ok(());
    }
    match number_of(memory, value) {
        Some(Number::Float(float)) => return super::number::write_real(memory, float, spec),
        Some(Number::Int(int)) if is_real => return super::number::write_real(memory, int as f64, spec),
        Some(Number::Int(int))
            if spec.precision.is_none() && matches!(spec.form, 0 | b'd' | b'x' | b'X' | b'o' | b'b' | b'c' | b'n') =>
        {
            return super::number::write_int(memory, int, spec);
        }
        _ => {}
    }
    if let Some(text) = value.text()
        && matches!(spec.form, 0 | b's')
        && spec.align != b'='
        && spec.comma == 0
        && spec.sign == b'-'
    {
        write_text(memory, text, spec);
        return Ok(());
    }
    if spec.form != 0 || spec.width != 0 || value.is(types::STR | types::NUMBER) {
        return Err(wrong(memory, Words::FormMisfit, value));
    }
    let text = run.text_of(value)?;
    run.memory.close_gap(from, text.at());
    Ok(())
}
