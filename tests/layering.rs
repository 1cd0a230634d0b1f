//! No stage of the library uses a later one.

use std::path::{Path, PathBuf};

/// Modules from the first to the last stage; those on one line do not use each other, but for their own.
const RANKS: [&[&str]; 19] = [
    &["bad_input", "warning", "quantity"],
    &["budget"],
    &["geom"],
    &["texture"],
    &["scene"],
    &["visibility"],
    &["direct"],
    &["discontinuity", "form_factor"],
    &["mesh"],
    &["radiosity"],
    &["adapt"],
    &["settings"],
    &["lit_scene"],
    &["pipeline"],
    &["bake"],
    &["render"],
    &["io"],
    &["compare", "viewer"],
    &["report"],
];

/// The program, after all of the library.
const PROGRAM: &str = "cli";

#[test]
fn no_stage_uses_a_later_one() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut files = Vec::new();
    collect(&source, &mut files);
    assert!(!files.is_empty(), "no source files under src");
    let mut faults = Vec::new();
    for file in files {
        let relative = file
            .strip_prefix(&source)
            .expect("the file was found under src");
        // The crate's roots tie everything together.
        if ["lib.rs", "main.rs"]
            .iter()
            .any(|r| relative == Path::new(r))
        {
            continue;
        }
        let text = std::fs::read_to_string(&file).expect("a source file is readable text");
        faults.extend(faults_in(relative, &text));
    }
    assert!(faults.is_empty(), "\n{}", faults.join("\n"));
}

#[test]
fn an_upward_path_is_found() {
    let upward = "use crate::geom::Plane;\nuse crate::mesh::Element;\n";
    let faults = faults_in(Path::new("scene/clean.rs"), upward);
    assert_eq!(faults.len(), 1, "{faults:?}");
    assert!(
        faults[0].starts_with("src/scene/clean.rs:2: "),
        "{faults:?}"
    );
    assert!(faults_in(Path::new("scene/clean.rs"), "// see crate::mesh::Element\n").is_empty());
    assert!(faults_in(Path::new("scene.rs"), "use crate::scene::Scene;\n").is_empty());
    let unknown = faults_in(Path::new("geom/plane.rs"), "use crate::novelty::New;\n");
    assert!(unknown[0].contains("tests/layering.rs"), "{unknown:?}");
    let many = faults_in(Path::new("scene/clean.rs"), "use crate::{geom, mesh};\n");
    assert!(many[0].contains("one stage per `use` line"), "{many:?}");
}

fn collect(directory: &Path, files: &mut Vec<PathBuf>) {
    let entries = std::fs::read_dir(directory).expect("the directory is readable");
    let mut paths: Vec<_> = entries
        .map(|e| e.expect("the entry is readable").path())
        .collect();
    paths.sort();
    for path in paths {
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "rs") {
            files.push(path);
        }
    }
}

fn rank(module: &str) -> Option<usize> {
    let library = RANKS.iter().position(|modules| modules.contains(&module));
    library.or((module == PROGRAM).then_some(RANKS.len()))
}

fn faults_in(relative: &Path, text: &str) -> Vec<String> {
    let first = relative.iter().next().expect("a path has a component");
    let stage = first.to_string_lossy();
    let stage = stage.trim_end_matches(".rs");
    let unknown = |module: &str| {
        format!("module `{module}` has no rank: add it to the list in tests/layering.rs")
    };
    let Some(own) = rank(stage) else {
        return vec![format!("src/{}: {}", relative.display(), unknown(stage))];
    };
    let mut faults = Vec::new();
    for (number, line) in text.lines().enumerate() {
        let code = line.split("//").next().unwrap_or_default();
        for (at, found) in code.match_indices("crate::") {
            // `$crate::` and the end of a longer word name other things.
            if code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_') {
                continue;
            }
            let rest = &code[at + found.len()..];
            let end = rest.find(|c: char| !c.is_alphanumeric() && c != '_');
            let module = &rest[..end.unwrap_or(rest.len())];
            let fault = match rank(module) {
                Some(other) if other < own || module == stage => continue,
                Some(_) => {
                    format!("`{stage}` must not use `{module}`, which is not an earlier stage")
                }
                None if module.is_empty() => "write one stage per `use` line".to_owned(),
                None => unknown(module),
            };
            faults.push(format!(
                "src/{}:{}: {fault}",
                relative.display(),
                number + 1
            ));
        }
    }
    faults
}
