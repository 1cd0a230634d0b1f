use super::Page;
use crate::io::builtin::cornell_box;
use crate::io::{read_lit, write_glb};
use crate::pipeline::{Solution, World, light};
use crate::settings::Settings;
use serde_json::Value;

fn with_solution(check: impl FnOnce(&Solution)) {
    let settings = Settings {
        error: 0.2,
        samples: Some(100),
        ..Settings::default()
    };
    let world = World::new(&cornell_box(), &settings).unwrap();
    check(&light(&world, &settings, &mut |_| {}).unwrap());
}

/// The data of a page, read as a browser does.
fn data(page: &Page) -> Value {
    let html = page.html();
    let start = html.find("id=\"umbrage-data\">").unwrap() + "id=\"umbrage-data\">".len();
    let end = start + html[start..].find('<').unwrap();
    serde_json::from_str(&html[start..end]).unwrap()
}

fn floats(value: &Value) -> Vec<f32> {
    let text = value.as_str().unwrap();
    let digit = |c: u8| match c {
        b'A'..=b'Z' => c - b'A',
        b'a'..=b'z' => c - b'a' + 26,
        b'0'..=b'9' => c - b'0' + 52,
        b'+' => 62,
        _ => 63,
    };
    let mut bytes = Vec::new();
    for four in text.as_bytes().chunks(4) {
        let digits = four.iter().filter(|c| **c != b'=').count();
        let bits = four
            .iter()
            .fold(0u32, |bits, &c| bits << 6 | u32::from(digit(c) & 63));
        bytes.extend(&bits.to_be_bytes()[1..digits]);
    }
    let number = |b: &[u8]| f32::from_le_bytes(b.try_into().unwrap());
    bytes.chunks_exact(4).map(number).collect()
}

#[test]
fn a_page_holds_the_light_of_the_lit_file_and_needs_nothing_else() {
    with_solution(|solution| {
        let page = Page::of_solution(solution, None).unwrap();
        let html = page.html();
        for forbidden in ["src=\"", "href=\"", "@import", "<!-- here -->"] {
            let own = html.replace(super::page::SCRIPT, "");
            assert!(!own.contains(forbidden), "{forbidden}");
        }
        assert!(html.contains("three.js") && html.contains("MIT License"));
        assert!(html.len() < 2_000_000, "{}", html.len());

        let (data, summary) = (data(&page), &solution.summary);
        assert_eq!(data["source"], "cornell-box");
        assert_eq!(data["cameras"].as_array().unwrap().len(), 2);
        let parts = data["parts"].as_array().unwrap();
        assert_eq!(parts.len(), summary.clean.faces);
        let triangles: u64 = parts.iter().map(|p| p["triangles"].as_u64().unwrap()).sum();
        assert!(triangles >= summary.elements as u64);
        assert_eq!(floats(&data["errors"]).len() as u64, triangles);

        // The same light, whether from the solution or from the file that was made of it.
        let model = read_lit("lit.glb", &write_glb(&solution.lit_scene())).unwrap();
        let from_file = self::data(&Page::of_model(&model, None).unwrap());
        assert_eq!(from_file["errors"], Value::Null);
        let sum = |v: &Value| floats(v).iter().map(|&x| f64::from(x)).sum::<f64>();
        for list in ["colours", "irradiance"] {
            let (a, b) = (sum(&data[list]), sum(&from_file[list]));
            // Single precision, and reflected light that is a thousandth of what an emitter sends out.
            assert!((a / b - 1.0).abs() < 1e-4, "{list}: {a} {b}");
        }
    });
}

#[test]
fn every_line_is_there_with_its_cause_in_words_and_in_space() {
    with_solution(|solution| {
        let data = data(&Page::of_solution(solution, Some(100.0)).unwrap());
        let lines = data["lines"].as_array().unwrap();
        let found: usize = solution.summary.line_counts.iter().map(|c| c.found).sum();
        assert_eq!(lines.len(), found);
        let ends = floats(&data["line_ends"]);
        assert_eq!(ends.len(), 6 * found);
        let corner = lines.iter().position(|l| l["kind"] == "ve").unwrap();
        let cause = lines[corner]["cause"].as_str().unwrap();
        assert!(
            cause.contains("emitter 0 (light)") && cause.contains("block"),
            "{cause}"
        );
        assert_eq!(lines[corner]["generators"].as_array().unwrap().len(), 3);
        // Sight lines of an edge of the lamp end at its height.
        let edge = lines.iter().find(|l| l["kind"] == "ev").unwrap();
        let sight = edge["generators"][1][1][1].as_f64().unwrap();
        let lamp = 0.5488 - data["origin"][1].as_f64().unwrap();
        assert!((sight - lamp).abs() < 1e-9, "{sight} {lamp}");
        assert_eq!(data["efficacy"], 100.0);
    });
}

#[test]
fn errors_on_the_page_are_those_that_were_measured() {
    with_solution(|solution| {
        let page = Page::of_solution(solution, None).unwrap();
        let surfaces = super::surfaces::of_solution(solution);
        let area: f64 = surfaces.areas.iter().sum();
        let errors = surfaces.errors.as_ref().unwrap().iter();
        let rms = (errors
            .zip(&surfaces.areas)
            .map(|(e, a)| e * e * a)
            .sum::<f64>()
            / area)
            .sqrt();
        let measured = solution.summary.measured.relative_rms_mesh;
        // One point an element against random ones: the same to a factor.
        assert!(
            rms > 0.3 * measured && rms < 3.0 * measured,
            "{rms} {measured}"
        );
        assert!(data(&page)["error_top"].as_f64().unwrap() > 0.0);
    });
}
