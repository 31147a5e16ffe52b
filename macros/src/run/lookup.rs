//! Lengths, elements, attributes and subscripts.

use super::{Run, order, undefined, wrong};
use crate::chars;
use crate::digits::product;
use crate::fault::{Result, Words};
use crate::memory::Text;
use crate::names;
use crate::value::{Map, SIZE, Seq, Value, View, types};

impl Run<'_, '_> {
    /// Whether a value counts as true.
    pub fn truth(&mut self, value: Value) -> bool {
        if value.is(types::NUMBER) {
            return self.memory.whole(value) != Some(0) && value.as_float() != Some(0.0);
        }
        if value.is(types::ONCE | types::LOOKUP) {
            return true;
        }
        !value.is_none() && self.length(value).is_none_or(|length| length > 0)
    }

    /// Number of elements; none where a value has none.
    pub fn length(&mut self, value: Value) -> Option<usize> {
        match value.view() {
            View::Undefined(_) => Some(0),
            View::Str(text) => Some(crate::chars::count(self.memory.text(text))),
            View::Seq(_, head) | View::Map(Map::Dict, head) => Some(self.memory.count(head)),
            View::Range(at) => Some(self.range_length(at)),
            View::Object(object) => Some(self.machine.length(object)),
            View::Loop(place) => self.loop_length(place),
            _ => None,
        }
    }

    /// Bounds of a range: start, end and step.
    pub fn range(&self, at: u16) -> [i64; 3] {
        [0, 8, 16].map(|offset| self.memory.eight(usize::from(at) + offset) as i64)
    }

    /// Makes a range of three bounds.
    pub fn new_range(&mut self, bounds: [i64; 3]) -> Value {
        let at = self.memory.top;
        bounds.iter().for_each(|bound| self.memory.push_bytes(&bound.to_le_bytes()));
        Value::range(at)
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
        let types =
            types::UNDEFINED | types::STR | types::SEQ | types::DICT | types::RANGE | types::OBJECT | types::LOOP;
        value.is(types)
    }

    /// Number of elements of what is gone through; a fault where it cannot be.
    pub fn iterate(&mut self, value: Value) -> Result<usize> {
        if matches!(value.view(), View::Loop(_)) || !self.is_iterable(value) {
            return Err(wrong(&self.memory, Words::NotIterable, value));
        }
        match self.length(value).unwrap_or(0) {
            length if length > usize::from(u16::MAX) => self.memory.fail(Words::LongRange),
            length => Ok(length),
        }
    }

    /// Element of what is gone through, by its number from 0: of dicts a key.
    pub fn element(&mut self, value: Value, index: usize) -> Result<Value> {
        match value.view() {
            View::Str(text) => Ok(Value::str(self.character(text, index))),
            View::Seq(_, head) => Ok(self.memory.element(head, index)),
            View::Map(_, head) => Ok(self.memory.value(self.memory.place(head, index, 2 * SIZE))),
            View::Range(at) => {
                let [start, _, step] = self.range(at);
                let element = product(step, index as i64).and_then(|offset| start.checked_add(offset));
                Ok(self.memory.int(element.unwrap_or(i64::MAX)))
            }
            View::Object(object) => self.part(object, index),
            _ => Ok(Value::MISSING),
        }
    }

    /// The character with a number.
    pub fn character(&self, text: Text, index: usize) -> Text {
        let string = self.memory.text(text);
        text.part(chars::place(string, index), chars::place(string, index + 1))
    }

    /// Attribute of a value by name: `value.name`.
    pub fn attribute(&mut self, value: Value, name: Text) -> Result<Value> {
        match value.view() {
            View::Undefined(missing) => Err(undefined(&self.memory, missing)),
            View::Loop(place) => self.loop_attribute(place, name),
            View::Map(Map::Namespace, head) => self.get(head, Value::str(name), name),
            _ if names::method(value, self.memory.bytes(name)).is_some() => Ok(Value::METHOD),
            View::Object(object) => self.kept_member(object, name),
            View::Map(Map::Dict, head) => self.get(head, Value::str(name), name),
            _ => Ok(Value::undefined(name)),
        }
    }

    /// Member of a dict, or the undefined value of that name.
    fn get(&mut self, head: u16, key: Value, name: Text) -> Result<Value> {
        Ok(self.find(head, key)?.map_or(Value::undefined(name), |at| self.memory.value(at + SIZE)))
    }

    /// Element of a value by its key: `value[key]`.
    pub fn item(&mut self, value: Value, key: Value) -> Result<Value> {
        if value.is_undefined() {
            return Err(undefined(&self.memory, value.missing_name()));
        }
        if let View::Map(Map::Dict, head) = value.view()
            && order::is_hashable(self, key)
            && let Some(at) = self.find(head, key)?
        {
            return Ok(self.memory.value(at + SIZE));
        }
        let Some(name) = key.text() else {
            return if value.is(types::INDEXED) { self.element_at(value, key) } else { Ok(Value::MISSING) };
        };
        if value.is(types::LOOKUP | types::DICT)
            && let Some(object) = value.as_object()
        {
            let found = self.kept_member(object, name)?;
            if !found.is_undefined() {
                return Ok(found);
            }
        }
        self.attribute(value, name)
    }

    /// Element of a sequence by number, from its end if negative.
    fn element_at(&mut self, value: Value, key: Value) -> Result<Value> {
        let Some(index) = self.memory.whole(key) else { return Ok(Value::MISSING) };
        let length = self.length(value).unwrap_or(0) as i64;
        let index = if index < 0 { index.saturating_add(length) } else { index };
        if index < 0 || index >= length {
            return Ok(Value::MISSING);
        }
        self.element(value, index as usize)
    }

    /// A part of a sequence: `value[from:to:step]`.
    pub fn slice(&mut self, value: Value, bounds: [Value; 3]) -> Result<Value> {
        if !value.is(types::INDEXED) {
            return Err(wrong(&self.memory, Words::NoSlices, value));
        }
        let length = self.length(value).unwrap_or(0) as i64;
        let [from, to, step] = bounds;
        let step = self.bound(step)?.unwrap_or(1);
        if step == 0 {
            return self.memory.fail(Words::ZeroStep);
        }
        let (least, most) = if step < 0 { (-1, length - 1) } else { (0, length) };
        let clamp = |bound: i64| (if bound < 0 { bound.saturating_add(length) } else { bound }).max(least).min(most);
        let from = self.bound(from)?.map_or(if step < 0 { most } else { least }, clamp);
        let to = self.bound(to)?.map_or(if step < 0 { least } else { most }, clamp);
        if let View::Range(at) = value.view() {
            let [start, _, pace] = self.range(at);
            let place = |index: i64| start.saturating_add(product(pace, index).unwrap_or(i64::MAX));
            return Ok(self.new_range([place(from), place(to), product(pace, step).unwrap_or(i64::MAX)]));
        }
        self.copy_slice(value, from, to, step)
    }

    fn bound(&self, bound: Value) -> Result<Option<i64>> {
        match self.memory.whole(bound) {
            None if !bound.is_none() => Err(wrong(&self.memory, Words::WantsWhole, bound)),
            whole => Ok(whole),
        }
    }

    fn copy_slice(&mut self, value: Value, from: i64, to: i64, step: i64) -> Result<Value> {
        let is_on = |index: i64| if step > 0 { index < to } else { index > to };
        if let Some(text) = value.text() {
            let start = self.memory.top;
            let mut index = from;
            while is_on(index) {
                let part = self.character(text, index as usize);
                self.memory.push_text(part);
                index = index.saturating_add(step);
            }
            return Ok(Value::str(self.memory.text_since(start)));
        }
        let kind = if value.is(types::TUPLE) { Seq::Tuple } else { Seq::List };
        let head = self.memory.new_list();
        let mut index = from;
        while is_on(index) {
            let element = self.element(value, index as usize)?;
            self.append(head, element);
            index = index.saturating_add(step);
        }
        Ok(Value::seq(kind, head))
    }
}
