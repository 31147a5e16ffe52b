//! Renders templates on a desk: one question a line as JSON, one answer a line. `scripts/macros.py` compares the
//! answers with those of Jinja2.
//!
//! A question is `{"template": text, "contexts": [variables, ...]}`. In the variables `{"lookup": {...}}` is an
//! object without methods like `printer`, `{"tuple": [...]}` a tuple and `{"literal": text}` a Python literal.

use std::io::{BufRead, Write};

use macros::{Action, Environment, Given, Kind, Object};
use serde_json::{Map, Value, json};

/// Memory as large as the board's.
const MEMORY: usize = 28 * 1024;
const OUTPUT: usize = 12 * 1024;

/// A machine of JSON.
struct Desk<'a> {
    variables: &'a Map<String, Value>,
    objects: Vec<&'a Value>,
    said: Vec<Value>,
}

impl<'a> Desk<'a> {
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

fn render(program: &macros::Program, memory: &mut [u8], output: &mut [u8], variables: &Value) -> Value {
    let Some(variables) = variables.as_object() else { return json!({"error": "no variables"}) };
    let mut desk = Desk { variables, objects: Vec::new(), said: Vec::new() };
    match program.render(memory, output, &mut desk) {
        Ok(length) => json!({"text": String::from_utf8_lossy(&output[..length]), "said": desk.said}),
        Err(error) => json!({"error": error.to_string(), "said": desk.said}),
    }
}

fn answer(question: &Value) -> Value {
    if let Some(text) = question["literal"].as_str() {
        let (mut memory, mut output) = (vec![0; MEMORY], vec![0; OUTPUT]);
        return match macros::rewrite_literal(text, &mut memory, &mut output) {
            Ok(length) => json!({"text": String::from_utf8_lossy(&output[..length])}),
            Err(error) => json!({"error": error.to_string()}),
        };
    }
    let template = question["template"].as_str().unwrap_or_default();
    let contexts = question["contexts"].as_array().map_or(&[][..], Vec::as_slice);
    let board = all(template, contexts, (MEMORY, OUTPUT));
    if !board.to_string().contains(": bytes of ") {
        return board;
    }
    let mut answer = all(template, contexts, (60 * 1024, 1024 * 1024));
    answer["large"] = json!(true);
    answer
}

/// Answers with memory and output of these sizes.
fn all(template: &str, contexts: &[Value], (memory, output): (usize, usize)) -> Value {
    let (mut memory, mut output) = (vec![0; memory], vec![0; output]);
    let program = match macros::compile(&mut template.bytes(), &mut memory) {
        Ok(program) => program,
        Err(error) => return json!({"refused": error.to_string()}),
    };
    let mut render = |context| render(&program, &mut memory, &mut output, context);
    let results: Vec<Value> = contexts.iter().map(&mut render).collect();
    json!({"size": program.size(), "results": results})
}

fn main() -> std::io::Result<()> {
    let mut output = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let question = serde_json::from_str(&line?).map_err(std::io::Error::other)?;
        writeln!(output, "{}", answer(&question))?;
    }
    Ok(())
}
