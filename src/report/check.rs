//! Today's figures against those of a baseline: what got worse.

use super::record::{Record, Work};

/// A run may be so many times as far off as the baseline before it counts as worse: other mathematics libraries refine a
/// few other elements, and the points at which the error is measured follow the elements.
const ERROR_SLACK: f64 = 1.10;

/// Counted work may grow by this factor, and by so many units where the counts are small.
const WORK_SLACK: f64 = 1.05;
const WORK_UNITS: u64 = 8;

/// Every way in which `now` is worse than `baseline`, in words; runs that are new are no harm.
pub fn regressions(now: &[Record], baseline: &[Record]) -> Vec<String> {
    baseline
        .iter()
        .flat_map(|old| {
            let name = format!(
                "{}, {} {} {} at {}",
                old.scene, old.mesh, old.basis, old.solver, old.asked
            );
            match now.iter().find(|new| key(new) == key(old)) {
                None => vec![format!("{name}: is no longer measured")],
                Some(new) => worse(&name, new, old),
            }
        })
        .collect()
}

fn key(r: &Record) -> (&str, &str, &str, &str, u64) {
    (&r.scene, &r.mesh, &r.solver, &r.basis, r.asked.to_bits())
}

fn worse(name: &str, new: &Record, old: &Record) -> Vec<String> {
    let mut found = Vec::new();
    // What is no number is worse than anything.
    if new.rms.is_nan() || new.rms > old.rms * ERROR_SLACK {
        found.push(format!(
            "{name}: error {:.3} % instead of {:.3} %",
            100.0 * new.rms,
            100.0 * old.rms
        ));
    }
    let counts = new.work.counts().into_iter().zip(old.work.counts());
    for (what, (n, o)) in Work::NAMES.iter().zip(counts) {
        if n as f64 > o as f64 * WORK_SLACK && n > o + WORK_UNITS {
            found.push(format!("{name}: {n} {what} instead of {o}"));
        }
    }
    found
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::super::record::{read_records, records_csv};
    use super::*;

    fn record(asked: f64) -> Record {
        Record {
            scene: "room, small".to_owned(),
            mesh: "adaptive".to_owned(),
            solver: "hierarchical".to_owned(),
            basis: "linear".to_owned(),
            asked,
            rms: 0.01,
            max: 0.1,
            work: Work {
                elements: 1000,
                sweeps: 4,
                ..Work::default()
            },
            seconds: 1.0,
            peak_bytes: Some(1 << 20),
        }
    }

    #[test]
    fn what_is_worse_is_named_and_what_is_better_or_new_is_not() {
        let baseline = [record(0.02), record(0.01)];
        assert!(regressions(&baseline, &baseline).is_empty());
        assert!(regressions(&[&baseline[..], &[record(0.005)]].concat(), &baseline).is_empty());
        let mut now = baseline.to_vec();
        now[0].rms = 0.005;
        now[0].seconds = 100.0;
        now[1].work.elements = 1040;
        assert!(regressions(&now, &baseline).is_empty());
        now[0].rms = 0.02;
        now[1].work.elements = 1060;
        let found = regressions(&now, &baseline);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(
            found[0].contains("at 0.02: error 2.000 % instead of 1.000 %"),
            "{found:?}"
        );
        assert!(
            found[1].contains("1060 elements instead of 1000"),
            "{found:?}"
        );
        now[0].rms = f64::NAN;
        assert_eq!(regressions(&now, &baseline).len(), 2);
        assert!(regressions(&now[..1], &baseline)[1].contains("no longer measured"));
    }

    #[test]
    fn a_baseline_comes_back_from_its_file() {
        let text = records_csv(&[record(0.02), record(0.01)]);
        let read = read_records(&text).unwrap();
        assert_eq!(read.len(), 2);
        assert!(regressions(&read, &read).is_empty());
        // The comma of the name has gone, in what is written and so in what is compared.
        assert_eq!(read[0].scene, "room  small");
        assert_eq!(read_records("scene,mesh\na,b\n").unwrap_err().0, 1);
        let cut = text.replace("1000,", "many,");
        assert_eq!(
            read_records(&cut).unwrap_err(),
            (2, "\"many\" is no count".to_owned())
        );
    }
}
