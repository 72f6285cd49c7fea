//! The Rust framework's sketch editor, by its commands, as its console and its agents drive it.

use std::time::Instant;

use arael::vect::vect2d;
use arael_sketch_backend::{Action, CommandContext};
use arael_sketch_backend::commands::execute;
use arael_sketch_backend::geometry::{arc_end_pos, arc_start_pos};
use arael_sketch_solver::{DimensionEndpoint, DimensionKind, Sketch};

use crate::drawing::{Drawing, Found, Rule, repeated};

/// Run a command; its words, and whether it was refused.
fn tell(ctx: &mut CommandContext, command: &str) -> (String, bool) {
    let results = execute(ctx, command);
    let refused = results.iter().any(|r| r.is_error);
    let said: Vec<&str> = results.iter().map(|r| r.output.as_str()).filter(|o| !o.is_empty()).collect();
    (said.join("; "), refused)
}

/// The sketch by its script; how many commands were refused, and the first refusal.
fn drawn(d: &Drawing) -> (CommandContext, usize, String) {
    let mut ctx = CommandContext::new();
    let (mut refusals, mut first) = (0, String::new());
    for command in &d.commands {
        let (said, refused) = tell(&mut ctx, command);
        if refused {
            refusals += 1;
            if first.is_empty() {
                first = said;
            }
        }
    }
    (ctx, refusals, first)
}

/// The same sketch by actions that are neither checked nor solved one by one: commands take minutes
/// for hundreds of constraints. Sketches of lines and circles only.
fn built(d: &Drawing) -> CommandContext {
    let mut s = Sketch::new();
    let at = |p: usize| vect2d::new(d.points[p].0, d.points[p].1);
    let mut owners: Vec<Vec<DimensionEndpoint>> = vec![vec![]; d.points.len()];
    let (mut lines, mut circles) = (Vec::new(), Vec::new());
    for &(a, b) in &d.lines {
        let line = s.add_line(at(a), at(b));
        owners[a].push(DimensionEndpoint::LineP1(line));
        owners[b].push(DimensionEndpoint::LineP2(line));
        lines.push(line);
    }
    for &(c, r) in &d.circles {
        let circle = s.add_arc(at(c), r, 0.0, std::f64::consts::TAU, true);
        owners[c].push(DimensionEndpoint::ArcCenter(circle));
        circles.push(circle);
    }
    let mut actions = Vec::new();
    for same in &owners {
        for &other in &same[1..] {
            actions.push(Action::coincident(same[0], other).expect("a pair of ends"));
        }
    }
    for rule in &d.rules {
        let of = &rule.of;
        let dimension = |kind| Action::AddDimension {
            kind,
            value: rule.values[0],
            expr: None,
            derived: false,
            range: None,
        };
        actions.push(match rule.kind.as_str() {
            "lock" => {
                let pos = vect2d::new(rule.values[0], rule.values[1]);
                match owners[of[0]][0] {
                    DimensionEndpoint::LineP1(line) => Action::LockLineP1 { line, pos },
                    DimensionEndpoint::LineP2(line) => Action::LockLineP2 { line, pos },
                    _ => panic!("a lock of a line's end"),
                }
            }
            "horizontal" => Action::ApplyHorizontal { lines: vec![lines[of[0]]] },
            "vertical" => Action::ApplyVertical { lines: vec![lines[of[0]]] },
            "length" => dimension(DimensionKind::LineLength(lines[of[0]])),
            "radius" => dimension(DimensionKind::ArcRadius(circles[of[0]])),
            "equal" => Action::ApplyEqualLength { a: lines[of[0]], b: lines[of[1]] },
            "equal_radius" => Action::ApplyEqualRadius { a: circles[of[0]], b: circles[of[1]] },
            other => panic!("no {other} here"),
        });
    }
    for action in &actions {
        action.apply_without_solve(&mut s);
    }
    s.assign_dimension_ids();
    s.assign_constraint_names();
    s.solve();
    CommandContext::with_sketch(s)
}

fn answer(ctx: &CommandContext, d: &Drawing) -> Vec<(&'static str, Vec<f64>)> {
    let s = &ctx.sketch;
    let mut lines = Vec::new();
    for r in s.lines.refs() {
        let l = &s.lines[r];
        lines.extend([l.p1.value.x, l.p1.value.y, l.p2.value.x, l.p2.value.y]);
    }
    let (mut circles, mut arcs) = (Vec::new(), Vec::new());
    for (i, r) in s.arcs.refs().enumerate() {
        let a = &s.arcs[r];
        if i < d.circles.len() {
            circles.extend([a.center.value.x, a.center.value.y, a.radius.value]);
        } else {
            let (p, q) = (arc_start_pos(a), arc_end_pos(a));
            let ends = if a.ccw { [p, q] } else { [q, p] };
            arcs.extend([a.center.value.x, a.center.value.y]);
            arcs.extend(ends.iter().flat_map(|e| [e.x, e.y]));
            arcs.push(a.radius.value);
        }
    }
    vec![("lines", lines), ("circles", circles), ("arcs", arcs)]
}

/// Degrees of freedom, counted anew.
fn count(ctx: &mut CommandContext) -> Result<usize, String> {
    ctx.sketch.mutate_values(|s| {
        s.clear_cached_dof();
        s.dof()
    })
}

pub fn run(task: &str, d: &Drawing, budget: f64) -> Found {
    let settings = "commands; cost below 1e-8 a parameter, residuals times 1e3".to_string();
    if task == "script" {
        let start = Instant::now();
        let (mut ctx, refusals, first) = drawn(d);
        let times = vec![start.elapsed().as_secs_f64()];
        let said = format!("{} commands, {refusals} refused {first}", d.commands.len());
        let freedoms = count(&mut ctx).ok();
        return Found { times, said: said.trim().to_string(), freedoms, settings, answer: answer(&ctx, d), ..Found::default() };
    }
    let start = Instant::now();
    let mut ctx = if d.commands.len() > 100 {
        built(d)
    } else {
        let (ctx, refusals, first) = drawn(d);
        if refusals > 0 {
            return Found::absent(format!("{refusals} commands refused: {first}"));
        }
        ctx
    };
    eprintln!("drawn in {:.1} s", start.elapsed().as_secs_f64());
    let mut found = Found { settings, ..Found::default() };
    let mut said = String::new();
    match task {
        "resolve" => {
            let commands: Vec<String> = d.targets.iter().map(|v| format!("{} {v:?}", d.stem)).collect();
            let mut last = 0;
            found.times = repeated(budget, |turn| {
                said = tell(&mut ctx, &commands[turn % commands.len()]).0;
                last = turn;
            });
            if last % commands.len() == 0 {
                said = tell(&mut ctx, &commands[1]).0;
            }
        }
        "freedom" => {
            let mut dof = Ok(0);
            found.times = repeated(budget, |_| dof = count(&mut ctx));
            match dof {
                Ok(n) => found.freedoms = Some(n),
                Err(e) => said = e,
            }
        }
        "edit" => {
            let command = format!("{} {:?}", d.stem, d.targets[0]);
            let dimension = |r: &&Rule| r.kind != "lock" && !r.values.is_empty();
            let first = d.rules[..d.changed].iter().filter(dimension).count();
            let mut name = ctx.sketch.dimensions[first].name.clone();
            let mut inside = true;
            found.times = repeated(budget, |_| {
                let next = if inside { format!("delete {name}") } else { command.clone() };
                inside = !inside;
                said = tell(&mut ctx, &next).0;
                if inside {
                    name = ctx.sketch.dimensions.last().expect("a dimension").name.clone();
                }
            });
            if !inside {
                said = tell(&mut ctx, &command).0;
            }
        }
        "redundant" | "contradicting" => {
            let command = &d.asks.iter().find(|a| a.0 == task).expect("a candidate").1;
            found.times = repeated(budget, |_| said = tell(&mut ctx, command).0);
        }
        "drag" => {
            for &(x, y) in &d.frames {
                let command = format!("drag {} {x:?},{y:?}", d.handle);
                let start = Instant::now();
                said = tell(&mut ctx, &command).0;
                found.times.push(start.elapsed().as_secs_f64());
            }
        }
        _ => return Found::absent(format!("no {task} in the Rust framework")),
    }
    found.said = said;
    found.answer = answer(&ctx, d);
    found
}
