//! A machine of JSON. `{"lookup": {...}}` is an object without methods like `printer`, `{"tuple": [...]}` a
//! tuple and `{"literal": text}` a Python literal.

use macros::{Action, Environment, Given, Kind, Object};
use serde_json::{Map, Value, json};

/// A machine of JSON.
pub struct Desk<'a> {
    variables: &'a Map<String, Value>,
    objects: Vec<&'a Value>,
    /// Actions that were asked for, and their texts.
    pub said: Vec<Value>,
}

impl<'a> Desk<'a> {
    pub fn new(variables: &'a Map<String, Value>) -> Self {
        Self { variables, objects: Vec::new(), said: Vec::new() }
    }

    fn give(&mut self, value: &'a Value) -> Given<'a> {
        let kind = match value {
            Value::Null => return Given::None,
            Value::Bool(is) => return Given::Bool(*is),
            Value::Number(number) => {
                let float = || Given::Float(number.as_f64().unwrap_or(0.0));
                return number.as_i64().map_or_else(float, Given::Int);
            }
            Value::String(text) => return Given::Text(text),
            Value::Array(_) => Kind::List,
            Value::Object(map) => match map.iter().next() {
                Some((key, Value::String(text))) if key == "literal" => return Given::Literal(text),
                Some((key, _)) if key == "lookup" => Kind::Lookup,
                Some((key, _)) if key == "tuple" => Kind::Tuple,
                _ => Kind::Dict,
            },
        };
        let inner = match kind {
            Kind::Lookup => &value["lookup"],
            Kind::Tuple => &value["tuple"],
            Kind::Dict | Kind::List => value,
        };
        let known = self.objects.iter().position(|object| std::ptr::eq(*object, inner));
        let id = known.unwrap_or_else(|| {
            self.objects.push(inner);
            self.objects.len() - 1
        });
        Given::Object(Object { id: id as u32, kind })
    }
}

impl Environment for Desk<'_> {
    fn variable(&mut self, name: &str) -> Option<Given<'_>> {
        let value = self.variables.get(name)?;
        Some(self.give(value))
    }

    fn member(&mut self, object: Object, name: &str) -> Option<Given<'_>> {
        let value = self.objects[object.id as usize];
        let axis = ["x", "y", "z", "e"].iter().position(|axis| *axis == name);
        let member = match (object.kind, axis) {
            (Kind::Tuple, Some(index)) => value.get(index)?,
            _ => value.get(name)?,
        };
        Some(self.give(member))
    }

    fn length(&mut self, object: Object) -> usize {
        match self.objects[object.id as usize] {
            Value::Array(list) => list.len(),
            Value::Object(map) => map.len(),
            _ => 0,
        }
    }

    fn element(&mut self, object: Object, index: usize) -> Option<Given<'_>> {
        match self.objects[object.id as usize] {
            Value::Array(list) => list.get(index).map(|value| self.give(value)),
            Value::Object(map) => map.keys().nth(index).map(|key| Given::Text(key)),
            _ => None,
        }
    }

    fn act(&mut self, action: Action, text: &str) {
        self.said.push(json!([format!("{action:?}"), text]));
    }

    /// The first element, as the script has Jinja2 take it.
    fn random(&mut self, _: usize) -> usize {
        0
    }
}
