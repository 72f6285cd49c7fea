//! Files of named columns, as `benchmarks/exchange.py` writes them: a line per column (name, type,
//! dimensions), an empty line, then the values in the same order, little-endian.

use std::collections::HashMap;
use std::fs;
use std::io::{BufWriter, Write};

use arael::matrix::{matrix3, matrix3d};
use arael::quatern::{quatern, quaternd};
use arael::vect::{vect2, vect2d, vect3, vect3d};

pub enum Values {
    Real(Vec<f64>),
    Integer(Vec<i64>),
}

pub struct Columns {
    found: HashMap<String, Values>,
}

impl Columns {
    pub fn read(path: &str) -> Columns {
        let bytes = fs::read(path).unwrap_or_else(|e| fail(&format!("{path}: {e}")));
        let mut found = HashMap::new();
        let mut heads = Vec::new();
        let mut at = 0;
        loop {
            let end = at + bytes[at..].iter().position(|&b| b == b'\n').unwrap_or_else(|| fail("no head"));
            let line = std::str::from_utf8(&bytes[at..end]).unwrap_or_else(|_| fail("head is not text"));
            at = end + 1;
            if line.is_empty() {
                break;
            }
            let words: Vec<&str> = line.split(' ').collect();
            let count: usize = words[2..].iter().map(|w| w.parse::<usize>().unwrap()).product();
            heads.push((words[0].to_string(), words[1].to_string(), count));
        }
        for (name, kind, count) in heads {
            let part = &bytes[at..at + 8 * count];
            at += 8 * count;
            let eights = part.chunks_exact(8).map(|c| c.try_into().unwrap());
            let values = match kind.as_str() {
                "f64" => Values::Real(eights.map(f64::from_le_bytes).collect()),
                _ => Values::Integer(eights.map(i64::from_le_bytes).collect()),
            };
            found.insert(name, values);
        }
        Columns { found }
    }

    pub fn has(&self, name: &str) -> bool {
        self.found.contains_key(name)
    }

    pub fn real(&self, name: &str) -> &[f64] {
        match self.found.get(name) {
            Some(Values::Real(values)) => values,
            _ => fail(&format!("no real column {name}")),
        }
    }

    pub fn index(&self, name: &str) -> &[i64] {
        match self.found.get(name) {
            Some(Values::Integer(values)) => values,
            _ => fail(&format!("no integer column {name}")),
        }
    }

    /// The one value of a column of one row: data of the root.
    pub fn one(&self, name: &str) -> f64 {
        self.real(name)[0]
    }

    pub fn vect2(&self, name: &str, row: usize) -> vect2d {
        let v = &self.real(name)[2 * row..];
        vect2::new(v[0], v[1])
    }

    pub fn vect3(&self, name: &str, row: usize) -> vect3d {
        let v = &self.real(name)[3 * row..];
        vect3::new(v[0], v[1], v[2])
    }

    pub fn quatern(&self, name: &str, row: usize) -> quaternd {
        let v = &self.real(name)[4 * row..];
        quatern::new(v[0], vect3::new(v[1], v[2], v[3]))
    }

    pub fn matrix3(&self, name: &str, row: usize) -> matrix3d {
        let v: &[f64; 9] = self.real(name)[9 * row..9 * row + 9].try_into().unwrap();
        matrix3::from_slice(v)
    }
}

/// Real columns to write, each with the length of its rows.
#[derive(Default)]
pub struct Answer {
    columns: Vec<(&'static str, usize, Vec<f64>)>,
}

impl Answer {
    pub fn add(&mut self, name: &'static str, width: usize, values: Vec<f64>) {
        self.columns.push((name, width, values));
    }

    pub fn write(&self, path: &str) -> std::io::Result<()> {
        let mut out = BufWriter::new(fs::File::create(path)?);
        for (name, width, values) in &self.columns {
            let rows = values.len() / width;
            let tail = if *width > 1 { format!(" {width}") } else { String::new() };
            writeln!(out, "{name} f64 {rows}{tail}")?;
        }
        writeln!(out)?;
        for (_, _, values) in &self.columns {
            for value in values {
                out.write_all(&value.to_le_bytes())?;
            }
        }
        out.flush()
    }
}

pub fn flat3<'a>(vectors: impl Iterator<Item = vect3d> + 'a) -> Vec<f64> {
    vectors.flat_map(|v| [v.x, v.y, v.z]).collect()
}

pub fn flat_matrix3<'a>(matrices: impl Iterator<Item = matrix3d> + 'a) -> Vec<f64> {
    matrices.flat_map(|m| (0..3).flat_map(move |i| [m[i].x, m[i].y, m[i].z])).collect()
}

pub fn fail(message: &str) -> ! {
    eprintln!("{message}");
    std::process::exit(2);
}
