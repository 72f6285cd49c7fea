//! `sketch-peer SYSTEM TASK FILE BUDGET`: measure one task on one sketch, print one JSON object.

mod ezpz_peer;
mod drawing;
mod framework;

use drawing::{Drawing, Found};

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let [_, system, task, file, budget] = words.as_slice() else {
        eprintln!("usage: sketch-peer ezpz|rust TASK FILE SECONDS");
        std::process::exit(2);
    };
    let text = std::fs::read_to_string(file).expect("the file of a sketch");
    let drawing = Drawing::read(&text);
    let budget: f64 = budget.parse().expect("seconds");
    let found = match system.as_str() {
        "ezpz" => ezpz_peer::run(task, &drawing, budget),
        "rust" => framework::run(task, &drawing, budget),
        other => Found::absent(format!("no system {other}")),
    };
    println!("{}", found.json());
}
