//! Renders templates on a desk: one question a line as JSON, one answer a line. `scripts/macros.py` compares
//! the answers with those of Jinja2.
//!
//! A question is `{"template": text, "contexts": [variables, ...]}` or `{"literal": text}`.

#[path = "../tests/desk/mod.rs"]
mod desk;

use std::io::{BufRead, Write};

use serde_json::{Value, json};

use desk::Desk;

/// Memory as large as the board's.
const MEMORY: usize = 28 * 1024;
const OUTPUT: usize = 12 * 1024;

fn render(program: &macros::Program, memory: &mut [u8], output: &mut [u8], variables: &Value) -> Value {
    let Some(variables) = variables.as_object() else { return json!({"error": "no variables"}) };
    let mut desk = Desk::new(variables);
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
