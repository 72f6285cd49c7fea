//! Solves one problem from its start, in short and in long runs, and shows the answer:
//!
//!     peer SUITE PROBLEM SHORT LONG RUNS THREADS LIMIT OUT
//!
//! prints one JSON object, like every system of the benchmarks (see `../runner.py`).

mod bundle;
mod columns;
mod endings;
mod localization;
mod plane;
mod pose_graph_2d;
mod pose_graph_3d;
mod slam;

use std::time::Instant;

use arael::simple_lm::{LmConfig, LmResult, SolveResult, SolverReport};
use columns::{Answer, Columns, fail};

/// A problem in this framework, fresh from its file.
pub trait Problem {
    fn solve(&mut self, config: &LmConfig<f64>) -> SolveResult<f64>;
    fn answer(&self, out: &mut Answer);
}

// As in `../runner.py`: when no further slope is begun.
const BUDGET: f64 = 6.0;
const LEAST: usize = 3;
const BRIEF: f64 = 1.0;
const MOST: usize = 51;

type Load = fn(&Columns) -> Box<dyn Problem>;

fn main() {
    let words: Vec<String> = std::env::args().collect();
    if words.len() == 8 && words[1] == "optimum" {
        return endings::run(&words);
    }
    if words.len() != 9 {
        fail("peer SUITE PROBLEM SHORT LONG RUNS THREADS LIMIT OUT");
    }
    let count = |k: usize| words[k].parse::<usize>().unwrap_or_else(|_| fail("expected a number"));
    let (short, long, runs, threads, limit) = (count(3), count(4), count(5), count(6), count(7));
    let data = Columns::read(&words[2]);
    let (load, damping) = suite(&words[1], &data);
    let timed = |iterations: usize| {
        let mut problem = load(&data);
        let mut config = LmConfig::conservative()
            .with_max_iters(iterations)
            .with_initial_lambda(damping)
            .with_num_threads(threads);
        config = if iterations < limit {
            config.with_abs_precision(0.0).with_rel_precision(0.0).with_patience(1_000_000)
        } else {
            config.with_abs_precision(0.0).with_rel_precision(1e-9)
        };
        let began = Instant::now();
        let result = problem.solve(&config);
        let seconds = began.elapsed().as_secs_f64();
        match result {
            Ok(done) => (seconds, done, problem),
            Err(failure) => fail(&format!("{failure}")),
        }
    };

    timed(short);
    let mut slopes = Vec::new();
    let began = Instant::now();
    for done in 0..MOST {
        let spent = began.elapsed().as_secs_f64();
        if spent > BRIEF && (done >= runs || (done >= LEAST && spent > BUDGET)) {
            break;
        }
        let (a, n) = brief(timed(short));
        let (b, m) = brief(timed(long));
        if m > n {
            slopes.push(format!("{:e}", (b - a) / (m - n) as f64));
        }
    }
    let memory = peak_megabytes();
    let (_, result, problem) = timed(limit);
    let mut answer = Answer::default();
    problem.answer(&mut answer);
    if let Err(error) = answer.write(&words[8]) {
        fail(&format!("{}: {error}", words[8]));
    }
    println!(
        "{{\"slopes\": [{}], \"iterations\": {}, \"memory\": {memory}, \"cost\": {:e}, \"plan\": \"{}\"}}",
        slopes.join(", "),
        result.iterations,
        result.end_cost,
        plan(&result),
    );
}

/// How a suite's problems are loaded, and the damping that all systems start with.
fn suite(name: &str, data: &Columns) -> (Load, f64) {
    match name {
        "slam" => (slam::load, 1e-4),
        "localization" => (localization::load, 1e-4),
        "pose_graph" if data.has("poses.q") => (pose_graph_3d::load, 1e-9),
        "pose_graph" => (pose_graph_2d::load, 1e-9),
        "bundle" => (bundle::load, 1e-4),
        "plane" => (plane::load, 1e-4),
        other => fail(&format!("no suite {other}")),
    }
}

fn brief((seconds, result, _): (f64, LmResult<f64>, Box<dyn Problem>)) -> (f64, usize) {
    (seconds, result.iterations)
}

/// What the linear solver did.
fn plan(result: &LmResult<f64>) -> String {
    let Some(SolverReport::Schur(plan)) = &result.solver else {
        return String::from("LM, default solver");
    };
    let taken = if plan.reduced { "landmarks or points eliminated" } else { "whole system" };
    let by = match (plan.envelope, plan.block_supernodal) {
        (true, _) => "envelope Cholesky",
        (false, true) => "block supernodal Cholesky",
        (false, false) => "scalar Cholesky",
    };
    format!("LM, solve_sparse: {taken}, {by}")
}

/// Peak resident memory of this process [MB].
fn peak_megabytes() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find(|l| l.starts_with("VmHWM:")).unwrap_or("VmHWM: 0 kB");
    line.split_whitespace().nth(1).and_then(|w| w.parse::<f64>().ok()).unwrap_or(0.0) / 1024.0
}
