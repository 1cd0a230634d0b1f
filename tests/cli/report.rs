//! `umbrage report` on a small scene, and its check against a baseline.

use super::{Folder, small};

#[test]
fn a_report_is_tables_plots_and_a_page_and_checks_itself_against_a_baseline() {
    let folder = Folder::new();
    let words = format!("report {} -o out --errors 0.2,0.1 --bounces 0", small());
    let run = folder.done(&words);
    assert!(run.out.contains("discontinuity"), "{}", run.out);
    let entries = std::fs::read_dir(folder.path("out")).expect("the folder");
    let mut names: Vec<String> = entries
        .map(|e| {
            e.expect("a file")
                .file_name()
                .to_string_lossy()
                .into_owned()
        })
        .collect();
    names.sort();
    assert_eq!(
        names,
        [
            "report.html",
            "runs.csv",
            "square-over-square-elements.svg",
            "square-over-square-seconds.svg",
            "stages.csv"
        ]
    );
    let runs = folder.text("out/runs.csv");
    assert_eq!(runs.lines().count(), 1 + 3 * 2 * 2, "{runs}");
    folder.write("base.csv", &runs);

    let check = format!("{words} --check base.csv --quiet");
    let same = folder.run(&check);
    assert_eq!(
        (same.code, same.out.as_str()),
        (Some(0), "no worse than the baseline\n")
    );
    // A baseline that had fewer elements.
    let at = runs
        .lines()
        .next()
        .expect("a header")
        .split(',')
        .position(|n| n == "elements");
    let better: Vec<String> = runs
        .lines()
        .map(|line| {
            let mut words: Vec<&str> = line.split(',').collect();
            let i = at.expect("a column");
            if words[1] == "adaptive" && words[4] == "0.1" {
                words[i] = "10";
            }
            words.join(",")
        })
        .collect();
    folder.write("base.csv", better.join("\n"));
    let worse = folder.run(&check);
    assert_eq!(worse.code, Some(1), "{}", worse.out);
    assert!(
        worse.out.contains("adaptive linear direct at 0.1: "),
        "{}",
        worse.out
    );
    assert!(
        worse.out.contains("elements instead of 10"),
        "{}",
        worse.out
    );

    folder.write("base.csv", "scene,mesh\n");
    folder.refused(&check, "base.csv: holds no runs");
    folder.write("base.csv", "scene,mesh\na,b\n");
    folder.refused(&check, "base.csv:1: has no column");
    folder.refused(
        &format!("report {0} {0} -o out", small()),
        "another scene is called",
    );
    folder.refused("report -o out --errors 2", "outside 0…1");
    folder.refused("report none.obj -o out", "none.obj");
    folder.write("file", "");
    folder.refused(
        &format!("report {} -o file/out", small()),
        "cannot be made a folder",
    );
}
