//! What the suite `optimum` asks for, as `../../endings.py` does it for Python:
//!
//!     peer optimum SUITE PROBLEM WAY RUNS LIMIT OUT
//!
//! solves a problem from its start to the framework's own end and prints one JSON object.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::rc::Rc;
use std::time::Instant;

use arael::simple_lm::{LmConfig, LmIter};

use crate::columns::{Answer, Columns, fail};

// As in `../../endings.py`: when no further run is begun.
const BUDGET: f64 = 0.6;
const LONG: f64 = 2.0;

/// A cost an attempt, with seconds of the processor since the run began.
#[derive(Default)]
struct Path {
    costs: Vec<f64>,
    times: Vec<f64>,
}

pub fn run(words: &[String]) {
    let number = |k: usize| words[k].parse::<usize>().unwrap_or_else(|_| fail("expected a number"));
    let (runs, limit) = (number(5), number(6));
    let began = cpu_seconds();
    let data = Columns::read(&words[3]);
    let (load, _) = crate::suite(&words[2], &data);
    let setup = cpu_seconds() - began;
    let mut timed: Vec<String> = Vec::new();
    let mut spent = 0.0;
    let mut last = None;
    for k in 0..=runs {
        if k > 1 && spent > BUDGET {
            break;
        }
        let mut problem = load(&data);
        let path = Rc::new(RefCell::new(Path::default()));
        let (watched, cpu, wall) = (path.clone(), cpu_seconds(), Instant::now());
        let config = match words[4].as_str() {
            "conservative" => LmConfig::conservative(),
            "ill_conditioned" => LmConfig::ill_conditioned(),
            "well_conditioned" => LmConfig::well_conditioned(),
            other => fail(&format!("no way {other}")),
        };
        let config = config.with_max_iters(limit).with_num_threads(1).with_observer(
            move |it: &LmIter<f64>| {
                let mut path = watched.borrow_mut();
                path.costs.push(if it.accepted { it.new_cost } else { it.cost });
                path.times.push(cpu_seconds() - cpu);
                ControlFlow::Continue(())
            },
        );
        let result = match problem.solve(&config) {
            Ok(done) => done,
            Err(failure) => fail(&format!("{failure}")),
        };
        let (passed, taken) = (wall.elapsed().as_secs_f64(), cpu_seconds() - cpu);
        spent += taken;
        let path = path.borrow();
        if k > 0 || taken > LONG {
            let mut times = vec![0.0];
            times.extend(path.times.iter());
            timed.push(format!(
                "{{\"cpu\": {taken:e}, \"wall\": {passed:e}, \"times\": {}}}",
                list(&times)
            ));
        }
        let mut costs = vec![result.start_cost];
        costs.extend(path.costs.iter());
        last = Some((result.iterations, result.end_cost, format!("{:?}", result.status), costs, problem));
    }
    let Some((attempts, cost, status, costs, problem)) = last else { fail("no run") };
    let mut answer = Answer::default();
    problem.answer(&mut answer);
    if let Err(error) = answer.write(&words[7]) {
        fail(&format!("{}: {error}", words[7]));
    }
    let counts: Vec<String> = (0..costs.len()).map(|k| k.to_string()).collect();
    println!(
        "{{\"status\": \"{status}\", \"attempts\": {attempts}, \"cost\": {cost:e}, \"costs\": {}, \
         \"counts\": [{}], \"runs\": [{}], \"setup\": {setup:e}}}",
        list(&costs),
        counts.join(", "),
        timed.join(", "),
    );
}

fn list(values: &[f64]) -> String {
    // JSON has no infinity.
    let words = values.iter().map(|v| format!("{:e}", if v.is_finite() { *v } else { 1e300 }));
    format!("[{}]", words.collect::<Vec<_>>().join(", "))
}

/// Seconds of the processor that this process has taken.
fn cpu_seconds() -> f64 {
    const CLOCK_PROCESS_CPUTIME_ID: i32 = 2;
    unsafe extern "C" {
        fn clock_gettime(clock: i32, time: *mut [i64; 2]) -> i32;
    }
    let mut time = [0; 2];
    // The C library is there wherever the standard library is; its time has two 64-bit numbers on
    // the 64-bit systems that this runs on.
    unsafe { clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &mut time) };
    time[0] as f64 + 1e-9 * time[1] as f64
}
