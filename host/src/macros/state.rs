//! The printer's state as a macro sees it, of JSON and of the variables in Klipper's files.

use std::ops::Range;

use ::macros::{Action, Environment, Given, Kind, Object};
use serde_json::Value;

/// Names of the first elements of a list, as positions have them.
const AXES: [&str; 4] = ["x", "y", "z", "e"];

/// A value or what has parts, which are numbers of others.
#[derive(Debug)]
pub enum Node {
    Scalar(Value),
    /// Text of a Python literal.
    Literal(String),
    List(Vec<u32>),
    Dict(Vec<(String, u32)>),
    /// Members without the methods of a dict, as `printer` has it.
    Lookup(Vec<(String, u32)>),
}

/// All that a macro can look up, and what it asked for.
#[derive(Debug, Default)]
pub struct State {
    nodes: Vec<Node>,
    /// Variables by name.
    pub variables: Vec<(String, u32)>,
    /// Actions that were asked for, and their texts.
    pub said: Vec<(Action, String)>,
    /// Numbers of objects whose members are otherwise at other times.
    pub changing: Range<u32>,
    /// Variables are otherwise at other times.
    pub variables_change: bool,
    /// Something was asked for that may be otherwise later.
    pub depends_on_state: bool,
}

impl State {
    /// Takes a value in; returns its number.
    pub fn add(&mut self, node: Node) -> u32 {
        self.nodes.push(node);
        self.nodes.len() as u32 - 1
    }

    /// Takes JSON in with all its parts.
    pub fn add_json(&mut self, value: Value) -> u32 {
        let node = match value {
            Value::Array(list) => Node::List(list.into_iter().map(|part| self.add_json(part)).collect()),
            Value::Object(map) => Node::Dict(map.into_iter().map(|(name, part)| (name, self.add_json(part))).collect()),
            scalar => Node::Scalar(scalar),
        };
        self.add(node)
    }

    fn node(&self, id: u32) -> &Node {
        self.nodes.get(id as usize).unwrap_or(&Node::Scalar(Value::Null))
    }

    fn give(&self, id: u32) -> Given<'_> {
        let object = |kind| Given::Object(Object { id, kind });
        match self.node(id) {
            Node::Scalar(Value::Bool(is)) => Given::Bool(*is),
            Node::Scalar(Value::Number(number)) => {
                number.as_i64().map_or_else(|| Given::Float(number.as_f64().unwrap_or(0.0)), Given::Int)
            }
            Node::Scalar(Value::String(text)) => Given::Text(text),
            Node::Scalar(_) => Given::None,
            Node::Literal(text) => Given::Literal(text),
            Node::List(_) => object(Kind::List),
            Node::Dict(_) => object(Kind::Dict),
            Node::Lookup(_) => object(Kind::Lookup),
        }
    }
}

impl Environment for State {
    fn variable(&mut self, name: &str) -> Option<Given<'_>> {
        let id = self.variables.iter().find(|(known, _)| known == name)?.1;
        self.depends_on_state |= self.variables_change && matches!(self.node(id), Node::Literal(_));
        Some(self.give(id))
    }

    fn member(&mut self, object: Object, name: &str) -> Option<Given<'_>> {
        let id = match self.node(object.id) {
            Node::Dict(members) | Node::Lookup(members) => members.iter().find(|(known, _)| known == name)?.1,
            Node::List(list) => *list.get(AXES.iter().position(|axis| *axis == name)?)?,
            Node::Scalar(_) | Node::Literal(_) => return None,
        };
        let is_limit = matches!(name, "axis_minimum" | "axis_maximum");
        let is_variable = self.variables_change && matches!(self.node(id), Node::Literal(_));
        self.depends_on_state |= is_variable || self.changing.contains(&object.id) && !is_limit;
        Some(self.give(id))
    }

    fn length(&mut self, object: Object) -> usize {
        match self.node(object.id) {
            Node::Dict(members) | Node::Lookup(members) => members.len(),
            Node::List(list) => list.len(),
            Node::Scalar(_) | Node::Literal(_) => 0,
        }
    }

    fn element(&mut self, object: Object, index: usize) -> Option<Given<'_>> {
        match self.node(object.id) {
            Node::Dict(members) | Node::Lookup(members) => members.get(index).map(|(name, _)| Given::Text(name)),
            Node::List(list) => list.get(index).map(|id| self.give(*id)),
            Node::Scalar(_) | Node::Literal(_) => None,
        }
    }

    fn act(&mut self, action: Action, text: &str) {
        self.said.push((action, text.to_owned()));
    }

    fn random(&mut self, limit: usize) -> usize {
        self.depends_on_state = true;
        let number = getrandom::u32().unwrap_or(0);
        (number as usize).checked_rem(limit).unwrap_or(0)
    }
}
