//! Lengths, elements, attributes and subscripts.

use super::{Run, undefined, wrong};
use crate::environment::Kind;
use crate::fault::{Result, Words, fail};
use crate::memory::Text;
use crate::value::{Map, SIZE, Seq, Value};

/// Words about a value that cannot be gone through.
pub const NOT_ITERABLE: Words = &"this cannot be gone through: a list, dict, string or range can";

impl Run<'_, '_> {
    /// Whether a value counts as true.
    pub fn truth(&mut self, value: Value) -> bool {
        match value {
            Value::Undefined(_) | Value::None => false,
            Value::Bool(is) => is,
            Value::Int(int) => int != 0,
            Value::Float(float) => float != 0.0,
            Value::Seq(Seq::Once, _) | Value::Map(Map::Namespace, _) => true,
            Value::Object(object) if object.kind == Kind::Lookup => true,
            Value::Function(_) | Value::Method => true,
            _ => self.length(value).is_none_or(|length| length > 0),
        }
    }

    /// Number of elements; none where a value has none.
    pub fn length(&mut self, value: Value) -> Option<usize> {
        match value {
            Value::Undefined(_) => Some(0),
            Value::Str(text) => Some(crate::chars::count(self.memory.text(text))),
            Value::Seq(_, head) | Value::Map(Map::Dict, head) => Some(self.memory.block(head).len),
            Value::Range(at) => Some(self.range_length(at)),
            Value::Object(object) => Some(self.machine.length(object)),
            Value::Loop(place) => self.loop_length(place),
            _ => None,
        }
    }

    /// Bounds of a range: start, end and step.
    pub fn range(&self, at: u16) -> [i64; 3] {
        [0, 8, 16].map(|offset| {
            let mut bytes = [0; 8];
            for (index, byte) in bytes.iter_mut().enumerate() {
                *byte = self.memory.byte(usize::from(at) + offset + index);
            }
            i64::from_le_bytes(bytes)
        })
    }

    /// Makes a range of three bounds.
    pub fn new_range(&mut self, bounds: [i64; 3]) -> Result<Value> {
        let at = self.memory.top;
        bounds.iter().try_for_each(|bound| self.memory.push_bytes(&bound.to_le_bytes()))?;
        Ok(Value::Range(at as u16))
    }

    fn range_length(&self, at: u16) -> usize {
        let [start, end, step] = self.range(at);
        if step == 0 || (end > start) != (step > 0) || start == end {
            return 0;
        }
        let count = (start.abs_diff(end) - 1) / step.unsigned_abs();
        usize::try_from(count).unwrap_or(usize::MAX).saturating_add(1)
    }

    /// Whether a value can be gone through.
    pub fn is_iterable(&self, value: Value) -> bool {
        matches!(
            value,
            Value::Undefined(_)
                | Value::Str(_)
                | Value::Seq(..)
                | Value::Map(Map::Dict, _)
                | Value::Range(_)
                | Value::Object(_)
                | Value::Loop(_)
        )
    }

    /// Number of elements of what is gone through; a fault where it cannot be.
    pub fn iterate(&mut self, value: Value) -> Result<usize> {
        if matches!(value, Value::Loop(_)) || !self.is_iterable(value) {
            return Err(wrong(&self.memory, NOT_ITERABLE, value));
        }
        match self.length(value).unwrap_or(0) {
            length if length > usize::from(u16::MAX) => fail(&"a range of more than 65535 numbers is too long here"),
            length => Ok(length),
        }
    }

    /// Element of what is gone through, by its number from 0: of dicts a key.
    pub fn element(&mut self, value: Value, index: usize) -> Result<Value> {
        match value {
            Value::Str(text) => Ok(Value::Str(self.character(text, index))),
            Value::Seq(_, head) => Ok(self.memory.value(self.memory.block(head).data + index * SIZE)),
            Value::Map(_, head) => Ok(self.memory.value(self.memory.block(head).data + index * 2 * SIZE)),
            Value::Range(at) => {
                let [start, _, step] = self.range(at);
                let element = step.checked_mul(index as i64).and_then(|offset| start.checked_add(offset));
                Ok(Value::Int(element.unwrap_or(i64::MAX)))
            }
            Value::Object(object) => self.part(object, index),
            _ => Ok(Value::Undefined(Text::default())),
        }
    }

    /// The character with a number.
    pub fn character(&self, text: Text, index: usize) -> Text {
        let string = self.memory.text(text);
        let mut indices = string.char_indices().skip(index).map(|(at, _)| at);
        let from = indices.next().unwrap_or(string.len());
        text.part(from, indices.next().unwrap_or(string.len()))
    }

    /// Attribute of a value by name: `value.name`.
    pub fn attribute(&mut self, value: Value, name: Text) -> Result<Value> {
        match value {
            Value::Undefined(missing) => Err(undefined(&self.memory, missing)),
            Value::Loop(place) => self.loop_attribute(place, name),
            Value::Map(Map::Namespace, head) => self.get(head, Value::Str(name), name),
            _ if crate::method_names::is_method(self.memory.text(name), value) => Ok(Value::Method),
            Value::Object(object) => {
                let member = self.kept_member(object, name)?;
                Ok(member.unwrap_or(Value::Undefined(name)))
            }
            Value::Map(Map::Dict, head) => self.get(head, Value::Str(name), name),
            _ => Ok(Value::Undefined(name)),
        }
    }

    /// Member of a dict, or the undefined value of that name.
    fn get(&mut self, head: u16, key: Value, name: Text) -> Result<Value> {
        Ok(self.find(head, key)?.map_or(Value::Undefined(name), |at| self.memory.value(at + SIZE)))
    }

    /// Element of a value by its key: `value[key]`.
    pub fn item(&mut self, value: Value, key: Value) -> Result<Value> {
        let name = if let Value::Str(text) = key { text } else { Text::default() };
        match value {
            Value::Undefined(missing) => return Err(undefined(&self.memory, missing)),
            Value::Map(Map::Dict, head) => {
                if super::order::is_hashable(self, key)
                    && let Some(at) = self.find(head, key)?
                {
                    return Ok(self.memory.value(at + SIZE));
                }
            }
            Value::Object(object) => match (object.kind, key) {
                (Kind::Lookup | Kind::Dict, Value::Str(name)) => {
                    if let Some(found) = self.kept_member(object, name)? {
                        return Ok(found);
                    }
                }
                (Kind::List | Kind::Tuple, _) => return self.element_at(value, key),
                _ => {}
            },
            Value::Str(_) | Value::Seq(Seq::List | Seq::Tuple, _) | Value::Range(_)
                if !matches!(key, Value::Str(_)) =>
            {
                return self.element_at(value, key);
            }
            _ => {}
        }
        if let Value::Str(name) = key { self.attribute(value, name) } else { Ok(Value::Undefined(name)) }
    }

    /// Element of a sequence by number, from its end if negative.
    fn element_at(&mut self, value: Value, key: Value) -> Result<Value> {
        let index = match key {
            Value::Int(index) => index,
            Value::Bool(is) => i64::from(is),
            Value::Str(name) => return self.attribute(value, name),
            _ => return Ok(Value::Undefined(Text::default())),
        };
        let length = self.length(value).unwrap_or(0) as i64;
        let index = if index < 0 { index.saturating_add(length) } else { index };
        if index < 0 || index >= length {
            return Ok(Value::Undefined(Text::default()));
        }
        self.element(value, index as usize)
    }

    /// A part of a sequence: `value[from:to:step]`.
    pub fn slice(&mut self, value: Value, bounds: [Value; 3]) -> Result<Value> {
        let is_sequence = match value {
            Value::Str(_) | Value::Seq(Seq::List | Seq::Tuple, _) | Value::Range(_) => true,
            Value::Object(object) => matches!(object.kind, Kind::List | Kind::Tuple),
            _ => false,
        };
        if !is_sequence {
            return Err(wrong(&self.memory, &"this has no slices: a list, tuple or string has", value));
        }
        let length = self.length(value).unwrap_or(0) as i64;
        let [from, to, step] = bounds;
        let step = self.bound(step)?.unwrap_or(1);
        if step == 0 {
            return fail(&"the step of a slice may not be 0");
        }
        let (least, most) = if step < 0 { (-1, length - 1) } else { (0, length) };
        let clamp = |bound: i64| (if bound < 0 { bound.saturating_add(length) } else { bound }).max(least).min(most);
        let from = self.bound(from)?.map_or(if step < 0 { most } else { least }, clamp);
        let to = self.bound(to)?.map_or(if step < 0 { least } else { most }, clamp);
        if let Value::Range(at) = value {
            let [start, _, pace] = self.range(at);
            let place = |index: i64| start.saturating_add(pace.saturating_mul(index));
            return self.new_range([place(from), place(to), pace.saturating_mul(step)]);
        }
        self.copy_slice(value, from, to, step)
    }

    fn bound(&self, bound: Value) -> Result<Option<i64>> {
        match bound {
            Value::None => Ok(None),
            Value::Int(index) => Ok(Some(index)),
            Value::Bool(is) => Ok(Some(i64::from(is))),
            _ => Err(wrong(&self.memory, &"the bounds of a slice are whole numbers", bound)),
        }
    }

    fn copy_slice(&mut self, value: Value, from: i64, to: i64, step: i64) -> Result<Value> {
        let is_on = |index: i64| if step > 0 { index < to } else { index > to };
        if let Value::Str(text) = value {
            let start = self.memory.top;
            let mut index = from;
            while is_on(index) {
                let part = self.character(text, index as usize);
                self.memory.push_text(part)?;
                index = index.saturating_add(step);
            }
            return Ok(Value::Str(self.memory.text_since(start)));
        }
        let kind = match value {
            Value::Seq(kind, _) => kind,
            Value::Object(object) if object.kind == Kind::Tuple => Seq::Tuple,
            _ => Seq::List,
        };
        let head = self.memory.new_block(0, SIZE)?;
        let mut index = from;
        while is_on(index) {
            let element = self.element(value, index as usize)?;
            self.append(head, element)?;
            index = index.saturating_add(step);
        }
        Ok(Value::Seq(kind, head))
    }
}
