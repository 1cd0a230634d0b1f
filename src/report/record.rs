//! One run as one row of a table.

use crate::pipeline::Summary;
use std::fmt::Write;

/// What was run, how far off it was, and what it cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Name of the scene.
    pub scene: String,
    /// Way to mesh.
    pub mesh: String,
    /// Way to solve.
    pub solver: String,
    /// What an element shows.
    pub basis: String,
    /// Relative error asked for.
    pub asked: f64,
    /// RMS error against the reference over mean irradiance.
    pub rms: f64,
    /// Largest error at any point over mean irradiance.
    pub max: f64,
    /// What it cost, counted.
    pub work: Work,
    /// Wall clock without the measuring, seconds.
    pub seconds: f64,
    /// The most memory in use, bytes, where it is known.
    pub peak_bytes: Option<u64>,
}

/// Work that is the same on every machine.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Work {
    /// Display elements.
    pub elements: u64,
    /// Wedges traced for lines.
    pub wedges: u64,
    /// Exact evaluations of direct light.
    pub evaluations: u64,
    /// Final gathers.
    pub gathers: u64,
    /// Links from nodes to cells.
    pub links: u64,
    /// Sweeps of the solver.
    pub sweeps: u64,
}

impl Work {
    /// Names of the counts, as columns.
    pub const NAMES: [&'static str; 6] = [
        "elements",
        "wedges",
        "evaluations",
        "gathers",
        "links",
        "sweeps",
    ];

    /// The counts of a run.
    pub fn of(s: &Summary) -> Self {
        Self {
            elements: s.elements as u64,
            wedges: s.lines.wedges as u64,
            evaluations: s.adapt.evaluations as u64,
            gathers: s.gathers as u64,
            links: s.solve.links as u64,
            sweeps: s.solve.residuals.len() as u64,
        }
    }

    /// In the order of [`Work::NAMES`].
    pub fn counts(&self) -> [u64; 6] {
        [
            self.elements,
            self.wedges,
            self.evaluations,
            self.gathers,
            self.links,
            self.sweeps,
        ]
    }

    fn from_counts([elements, wedges, evaluations, gathers, links, sweeps]: [u64; 6]) -> Self {
        Self {
            elements,
            wedges,
            evaluations,
            gathers,
            links,
            sweeps,
        }
    }
}

/// Columns before the counts, and after them.
const KEYS: [&str; 7] = ["scene", "mesh", "solver", "basis", "asked", "rms", "max"];
const COSTS: [&str; 2] = ["seconds", "peak_bytes"];

/// Records as CSV with a header. Everything but the last two columns is the same on every run.
pub fn records_csv(records: &[Record]) -> String {
    let mut text = [KEYS.as_slice(), &Work::NAMES, &COSTS].concat().join(",");
    text.push('\n');
    for r in records {
        // A comma in the name of a file would part it; writing to a string cannot fail.
        let scene = r.scene.replace([',', '\n', '\r'], " ");
        let _ = write!(
            text,
            "{scene},{},{},{},{},{:.6e},{:.6e},",
            r.mesh, r.solver, r.basis, r.asked, r.rms, r.max
        );
        for count in r.work.counts() {
            let _ = write!(text, "{count},");
        }
        let bytes = r.peak_bytes.map(|b| b.to_string()).unwrap_or_default();
        let _ = writeln!(text, "{:.3},{bytes}", r.seconds);
    }
    text
}

/// The records in a CSV that [`records_csv`] wrote; columns may stand in any order and others are passed over.
///
/// # Errors
/// The number of the line that cannot be read, from 1, and why.
pub fn read_records(text: &str) -> Result<Vec<Record>, (usize, String)> {
    let mut lines = (1..).zip(text.lines());
    let header: Vec<&str> = lines
        .next()
        .map(|l| l.1.split(',').collect())
        .unwrap_or_default();
    let column = |name: &str| {
        let at = header.iter().position(|h| *h == name);
        at.ok_or((1, format!("has no column {name}")))
    };
    let keys = KEYS.map(column);
    let counts = Work::NAMES.map(column);
    let mut records = Vec::new();
    for (number, line) in lines.filter(|l| !l.1.trim().is_empty()) {
        let words: Vec<&str> = line.split(',').collect();
        let word = |at: &Result<usize, (usize, String)>| {
            let &i = at.as_ref().map_err(Clone::clone)?;
            words
                .get(i)
                .copied()
                .ok_or((number, "has too few columns".to_owned()))
        };
        let float = |at| {
            let text = word(at)?;
            text.parse::<f64>()
                .map_err(|_| (number, format!("\"{text}\" is no number")))
        };
        let mut work = [0; 6];
        for (slot, at) in work.iter_mut().zip(&counts) {
            let text = word(at)?;
            *slot = text
                .parse()
                .map_err(|_| (number, format!("\"{text}\" is no count")))?;
        }
        records.push(Record {
            scene: word(&keys[0])?.to_owned(),
            mesh: word(&keys[1])?.to_owned(),
            solver: word(&keys[2])?.to_owned(),
            basis: word(&keys[3])?.to_owned(),
            asked: float(&keys[4])?,
            rms: float(&keys[5])?,
            max: float(&keys[6])?,
            work: Work::from_counts(work),
            seconds: 0.0,
            peak_bytes: None,
        });
    }
    Ok(records)
}
