//! Reader of `fixtures/analytic/*.txt`: known answers, one a line.

use super::scenes::fixtures;

/// One line: a name and its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Row {
    /// First word.
    pub(crate) name: String,
    /// The numbers after it.
    pub(crate) numbers: Vec<f64>,
}

/// All rows of a table.
pub(crate) fn table(file: &str) -> Vec<Row> {
    let path = fixtures().join("analytic").join(file).with_extension("txt");
    let text = std::fs::read_to_string(&path)
        .unwrap_or_else(|e| panic!("{}: cannot be read: {e}", path.display()));
    assert!(
        text.starts_with("# source: "),
        "{}: the first line has to name the source",
        path.display()
    );
    text.lines()
        .filter(|line| !line.starts_with('#') && !line.trim().is_empty())
        .map(|line| {
            let mut words = line.split_whitespace();
            let name = words.next().expect("the line is not blank").to_owned();
            let numbers = words
                .map(|w| {
                    w.parse()
                        .unwrap_or_else(|_| panic!("{}: not a number: {w}", path.display()))
                })
                .collect();
            Row { name, numbers }
        })
        .collect()
}

/// The numbers of each row called `name`; at least one.
pub(crate) fn rows(file: &str, name: &str) -> Vec<Vec<f64>> {
    let found: Vec<_> = table(file)
        .into_iter()
        .filter(|row| row.name == name)
        .map(|row| row.numbers)
        .collect();
    assert!(!found.is_empty(), "no row {name} in table {file}");
    found
}
