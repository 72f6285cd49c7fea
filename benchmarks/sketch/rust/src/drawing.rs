//! A sketch as ../writing.py writes it, and what is printed of it.

use std::time::Instant;

#[derive(Clone, Debug)]
pub struct Rule {
    pub kind: String,
    pub of: Vec<usize>,
    pub values: Vec<f64>,
}

#[derive(Default)]
pub struct Drawing {
    pub points: Vec<(f64, f64)>,
    pub lines: Vec<(usize, usize)>,
    pub circles: Vec<(usize, f64)>,
    pub arcs: Vec<(usize, usize, usize)>,
    pub rules: Vec<Rule>,
    pub candidates: Vec<(String, Rule)>,
    /// Commands that add the candidates.
    pub asks: Vec<(String, String)>,
    pub changed: usize,
    pub targets: Vec<f64>,
    /// The command that changes the dimension, without its value.
    pub stem: String,
    pub grabbed: usize,
    pub handle: String,
    pub frames: Vec<(f64, f64)>,
    pub commands: Vec<String>,
}

impl Rule {
    fn read(text: &str) -> Rule {
        let (names, values) = text.split_once('|').expect("a bar before the values");
        let mut words = names.split_whitespace();
        Rule {
            kind: words.next().expect("a kind").to_string(),
            of: words.map(|w| w.parse().expect("a number")).collect(),
            values: values.split_whitespace().map(|w| w.parse().expect("a value")).collect(),
        }
    }
}

impl Drawing {
    pub fn read(text: &str) -> Drawing {
        let mut d = Drawing::default();
        for line in text.lines() {
            let (word, rest) = line.split_once(' ').unwrap_or((line, ""));
            let numbers = || -> Vec<f64> {
                rest.split_whitespace().filter_map(|w| w.parse().ok()).collect()
            };
            match word {
                "point" | "frame" => {
                    let n = numbers();
                    let list = if word == "point" { &mut d.points } else { &mut d.frames };
                    list.push((n[0], n[1]));
                }
                "line" => {
                    let n = numbers();
                    d.lines.push((n[0] as usize, n[1] as usize));
                }
                "circle" => {
                    let n = numbers();
                    d.circles.push((n[0] as usize, n[1]));
                }
                "arc" => {
                    let n = numbers();
                    d.arcs.push((n[0] as usize, n[1] as usize, n[2] as usize));
                }
                "rule" => d.rules.push(Rule::read(rest)),
                "candidate" => {
                    let (name, rule) = rest.split_once(' ').expect("a name");
                    d.candidates.push((name.to_string(), Rule::read(rule)));
                }
                "ask" => {
                    let (name, command) = rest.split_once(' ').expect("a name");
                    d.asks.push((name.to_string(), command.to_string()));
                }
                "change" => {
                    let n = numbers();
                    d.changed = n[0] as usize;
                    d.targets = n[1..].to_vec();
                }
                "stem" => d.stem = rest.to_string(),
                "grab" => {
                    let (number, name) = rest.split_once(' ').expect("a handle");
                    d.grabbed = number.parse().expect("a number");
                    d.handle = name.to_string();
                }
                "command" => d.commands.push(rest.to_string()),
                other => panic!("no such line: {other}"),
            }
        }
        d
    }
}

/// What was measured: seconds, the answer as named lists, words about it.
#[derive(Default)]
pub struct Found {
    pub absent: String,
    pub times: Vec<f64>,
    pub answer: Vec<(&'static str, Vec<f64>)>,
    pub said: String,
    pub freedoms: Option<usize>,
    pub settings: String,
}

impl Found {
    pub fn absent(reason: String) -> Found {
        Found { absent: reason, ..Found::default() }
    }

    pub fn json(&self) -> String {
        if !self.absent.is_empty() {
            return format!("{{\"absent\": {}}}", quoted(&self.absent));
        }
        let mut parts = vec![
            format!("\"times\": {}", list(&self.times)),
            format!("\"said\": {}", quoted(&self.said)),
            format!("\"settings\": {}", quoted(&self.settings)),
        ];
        if let Some(n) = self.freedoms {
            parts.push(format!("\"freedoms\": {n}"));
        }
        let answer: Vec<String> =
            self.answer.iter().map(|(name, v)| format!("\"{name}\": {}", list(v))).collect();
        if !answer.is_empty() {
            parts.push(format!("\"answer\": {{{}}}", answer.join(", ")));
        }
        format!("{{{}}}", parts.join(", "))
    }
}

fn list(values: &[f64]) -> String {
    let words: Vec<String> = values
        .iter()
        .map(|v| if v.is_finite() { format!("{v:?}") } else { "null".to_string() })
        .collect();
    format!("[{}]", words.join(", "))
}

fn quoted(text: &str) -> String {
    let mut out = String::from("\"");
    for c in text.chars() {
        match c {
            '"' => out.push_str("\\\""),
            '\\' => out.push_str("\\\\"),
            '\n' => out.push_str("\\n"),
            c if (c as u32) < 32 => out.push(' '),
            c => out.push(c),
        }
    }
    out + "\""
}

/// Seconds of repeated runs, after two that do not count; as ../repeating.py.
pub fn repeated(budget: f64, mut action: impl FnMut(usize)) -> Vec<f64> {
    let began = Instant::now();
    let mut turn = 0;
    while turn < 2 && (turn == 0 || began.elapsed().as_secs_f64() < budget) {
        action(turn);
        turn += 1;
    }
    let began = Instant::now();
    let mut times = Vec::new();
    while times.len() < 201 {
        let spent = began.elapsed().as_secs_f64();
        if (spent > budget && times.len() >= 5) || spent > 5.0 * budget {
            break;
        }
        let start = Instant::now();
        action(turn);
        times.push(start.elapsed().as_secs_f64());
        turn += 1;
    }
    times
}
