//! ezpz: a function of constraints and guesses. Nothing is kept between calls.

use ezpz::datatypes::AngleKind;
use ezpz::datatypes::inputs::{DatumCircle, DatumCircularArc, DatumDistance, DatumLineSegment, DatumPoint};
use ezpz::{Config, Constraint, ConstraintRequest, Id, IdGenerator, solve, solve_analysis};

use crate::drawing::{Drawing, Found, Rule, repeated};

struct System {
    points: Vec<DatumPoint>,
    lines: Vec<DatumLineSegment>,
    circles: Vec<DatumCircle>,
    arcs: Vec<DatumCircularArc>,
    /// Requests of a rule begin here.
    first: Vec<usize>,
    requests: Vec<ConstraintRequest>,
    guesses: Vec<(Id, f64)>,
}

impl System {
    fn new(d: &Drawing) -> System {
        let mut ids = IdGenerator::default();
        let mut guesses = Vec::new();
        let mut points = Vec::new();
        for &(x, y) in &d.points {
            let p = DatumPoint::new(&mut ids);
            guesses.extend([(p.id_x(), x), (p.id_y(), y)]);
            points.push(p);
        }
        let lines = d.lines.iter().map(|&(a, b)| DatumLineSegment::new(points[a], points[b])).collect();
        let mut circles = Vec::new();
        for &(c, r) in &d.circles {
            let radius = DatumDistance::new(ids.next_id());
            guesses.push((radius.id, r));
            circles.push(DatumCircle { center: points[c], radius });
        }
        let arcs: Vec<DatumCircularArc> = d
            .arcs
            .iter()
            .map(|&(c, s, e)| DatumCircularArc { center: points[c], start: points[s], end: points[e] })
            .collect();
        let mut system = System { points, lines, circles, arcs, first: vec![], requests: vec![], guesses };
        for arc in system.arcs.clone() {
            system.requests.push(ConstraintRequest::highest_priority(Constraint::Arc(arc)));
        }
        for rule in &d.rules {
            system.first.push(system.requests.len());
            let made = system.of(d, rule);
            system.requests.extend(made);
        }
        system
    }

    fn of(&self, d: &Drawing, rule: &Rule) -> Vec<ConstraintRequest> {
        let of = &rule.of;
        let value = rule.values.first().copied().unwrap_or(0.0);
        let radius = |k: usize| DatumLineSegment::new(self.arcs[k].center, self.arcs[k].start);
        let made = match rule.kind.as_str() {
            "lock" => {
                let p = self.points[of[0]];
                vec![
                    Constraint::Fixed(p.id_x(), rule.values[0]),
                    Constraint::Fixed(p.id_y(), rule.values[1]),
                ]
            }
            "horizontal" => vec![Constraint::Horizontal(self.lines[of[0]])],
            "vertical" => vec![Constraint::Vertical(self.lines[of[0]])],
            "length" => {
                let line = self.lines[of[0]];
                vec![Constraint::Distance(line.p0, line.p1, value)]
            }
            "distance" => {
                vec![Constraint::Distance(self.points[of[0]], self.points[of[1]], value)]
            }
            "equal" => vec![Constraint::LinesEqualLength(self.lines[of[0]], self.lines[of[1]])],
            "radius" => vec![Constraint::CircleRadius(self.circles[of[0]], value)],
            "equal_radius" => vec![Constraint::ScalarEqual(
                self.circles[of[0]].radius.id,
                self.circles[of[1]].radius.id,
            )],
            "arc_radius" => {
                let arc = self.arcs[of[0]];
                vec![Constraint::Distance(arc.center, arc.start, value)]
            }
            "equal_arcs" => vec![Constraint::LinesEqualLength(radius(of[0]), radius(of[1]))],
            "tangent" => {
                let (a, b) = d.lines[of[0]];
                let (center, start, end) = d.arcs[of[1]];
                let shared = if start == a || start == b { start } else { end };
                let arm = DatumLineSegment::new(self.points[center], self.points[shared]);
                vec![Constraint::LinesAtAngle(self.lines[of[0]], arm, AngleKind::Perpendicular)]
            }
            other => panic!("no kind {other}"),
        };
        made.into_iter().map(ConstraintRequest::highest_priority).collect()
    }

    fn put(&mut self, values: &[f64]) {
        for (guess, value) in self.guesses.iter_mut().zip(values) {
            guess.1 = *value;
        }
    }

    /// Solve from where everything is; the words say how it ended.
    fn solve(&mut self, requests: &[ConstraintRequest]) -> String {
        match solve(requests, self.guesses.clone(), Config::default()) {
            Ok(o) => {
                let values = o.final_values().to_vec();
                self.put(&values);
                words(o.converged(), o.unsatisfied().len())
            }
            Err(e) => format!("error: {}", e.error),
        }
    }

    /// The same with the analysis of freedom; how many numbers can still move.
    fn analyse(&mut self, requests: &[ConstraintRequest]) -> (String, Option<usize>) {
        match solve_analysis(requests, self.guesses.clone(), Config::default()) {
            Ok(o) => {
                let values = o.outcome.final_values().to_vec();
                self.put(&values);
                let said = words(o.outcome.converged(), o.outcome.unsatisfied().len());
                (said, Some(o.analysis.underconstrained().len()))
            }
            Err(e) => (format!("error: {}", e.error), None),
        }
    }

    fn answer(&self, d: &Drawing) -> Vec<(&'static str, Vec<f64>)> {
        let values: Vec<f64> = self.guesses.iter().map(|g| g.1).collect();
        let (points, radii) = values.split_at(2 * d.points.len());
        vec![("points", points.to_vec()), ("radii", radii.to_vec())]
    }
}

fn words(converged: bool, unsatisfied: usize) -> String {
    match (converged, unsatisfied) {
        (true, 0) => "solved".to_string(),
        (false, 0) => "solved, not converged".to_string(),
        (_, n) => format!("{n} constraints unsatisfied"),
    }
}

pub fn run(task: &str, d: &Drawing, budget: f64) -> Found {
    if task == "freedom" && d.points.len() > 2000 {
        return Found::absent("not asked: QR of a dense matrix; by its growth more than a minute".to_string());
    }
    let mut system = System::new(d);
    let mut requests = system.requests.clone();
    let mut said = String::new();
    let mut found = Found { settings: "largest residual 1e-8".to_string(), ..Found::default() };
    match task {
        "resolve" => {
            let at = system.first[d.changed];
            let mut rule = d.rules[d.changed].clone();
            let mut last = 0;
            found.times = repeated(budget, |turn| {
                rule.values = vec![d.targets[turn % d.targets.len()]];
                requests[at] = system.of(d, &rule)[0];
                said = system.solve(&requests);
                last = turn;
            });
            if last % d.targets.len() == 0 {
                rule.values = vec![d.targets[1]]; // the answer is that of the second value
                requests[at] = system.of(d, &rule)[0];
                said = system.solve(&requests);
            }
        }
        "freedom" => {
            system.solve(&requests);
            let mut free = None;
            found.times = repeated(budget, |_| (said, free) = system.analyse(&requests));
            found.freedoms = None;
            said = format!("{} numbers can move", free.map_or("?".to_string(), |n| n.to_string()));
        }
        "edit" => {
            system.solve(&requests);
            let at = system.first[d.changed];
            let taken = requests[at];
            let mut inside = true;
            found.times = repeated(budget, |_| {
                if inside {
                    let _ = requests.remove(at);
                } else {
                    requests.insert(at, taken);
                }
                inside = !inside;
                said = system.analyse(&requests).0;
            });
            if !inside {
                requests.insert(at, taken);
                said = system.analyse(&requests).0;
            }
        }
        "redundant" | "contradicting" => {
            system.solve(&requests);
            let rule = &d.candidates.iter().find(|c| c.0 == task).expect("a candidate").1;
            requests.extend(system.of(d, rule));
            let from = system.guesses.clone();
            found.times = repeated(budget, |_| {
                system.guesses = from.clone();
                said = system.solve(&requests);
            });
            found.settings = String::new();
        }
        "drag" => {
            let p = system.points[d.grabbed];
            for &(x, y) in &d.frames {
                let mut framed = requests.clone();
                framed.push(ConstraintRequest::highest_priority(Constraint::Fixed(p.id_x(), x)));
                framed.push(ConstraintRequest::highest_priority(Constraint::Fixed(p.id_y(), y)));
                let start = std::time::Instant::now();
                said = system.solve(&framed);
                found.times.push(start.elapsed().as_secs_f64());
            }
        }
        _ => return Found::absent(format!("no {task} in ezpz")),
    }
    found.said = said;
    found.answer = system.answer(d);
    found
}
