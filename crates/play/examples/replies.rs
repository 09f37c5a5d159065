//! What the playground answers natively, for comparison with the same as WebAssembly: reads JSON, an
//! array of sequences of commands, and prints the answers in the same form, as texts.

use std::io::Read as _;

use lafet_play::{Playground, call};
use serde_json::Value;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut asked = String::new();
    std::io::stdin().read_to_string(&mut asked)?;
    let sequences: Vec<Vec<Value>> = serde_json::from_str(&asked)?;
    let mut all = Vec::new();
    for commands in sequences {
        let mut playground = Playground::default();
        let mut answers = Vec::new();
        for command in commands {
            let answer = call(&mut playground, command.to_string().as_bytes());
            answers.push(String::from_utf8(answer)?);
        }
        all.push(answers);
    }
    println!("{}", serde_json::to_string(&all)?);
    Ok(())
}
