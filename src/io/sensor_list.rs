//! Points with normals, one a line of text: the sensor grids of lighting programs.

use super::UpAxis;
use crate::bad_input::BadInput;
use crate::pipeline::Sensor;
use crate::quantity::Irradiance;
use glam::DVec3;

/// Sensors, and the lines that they came from.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SensorList {
    /// Name for messages.
    pub source: String,
    /// In the order of the file.
    pub sensors: Vec<Sensor>,
    /// Number of each sensor's line, from 1.
    pub lines: Vec<usize>,
    /// `x y z nx ny nz` of each sensor as the file has them.
    pub given: Vec<[f64; 6]>,
}

/// The columns of a sensor, which a table names in any order.
pub(super) const COLUMNS: [&str; 6] = ["x", "y", "z", "nx", "ny", "nz"];

/// The sensors in `text`: `x y z nx ny nz` on each line, with spaces, commas or semicolons between them; `#` starts a
/// comment; `source` is its name for messages.
///
/// The first line may name its columns instead: then those six are read wherever they stand, and others passed over.
/// Positions are metres in the scene's own frame, whatever unit its file has; `up` turns them as it turns the scene.
/// Normals may have any length.
pub fn read_sensors(source: &str, text: &str, up: UpAxis) -> Result<SensorList, BadInput> {
    let mut list = SensorList {
        source: source.to_owned(),
        ..SensorList::default()
    };
    let mut header = None;
    for (number, line) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let words = words(line);
        if words.is_empty() {
            continue;
        }
        let place = format!("{source}:{number}");
        if list.lines.is_empty() && header.is_none() && is_header(&words) {
            header = Some(columns(&place, &words)?);
            continue;
        }
        let given = numbers(&place, &words, header.as_ref())?;
        list.sensors.push(sensor(&place, given, up)?);
        list.lines.push(number);
        list.given.push(given);
    }
    Ok(list)
}

/// What stands on a line before any comment. Where there are commas or semicolons they alone part the words, so that an
/// empty field is seen to be missing.
fn words(line: &str) -> Vec<&str> {
    let line = line.split('#').next().unwrap_or_default().trim();
    if line.is_empty() {
        return Vec::new();
    }
    match line.contains([',', ';']) {
        true => line.split([',', ';']).map(str::trim).collect(),
        false => line.split_whitespace().collect(),
    }
}

/// Whether the words name columns: one is such a name, and none is a number.
fn is_header(words: &[&str]) -> bool {
    let is_name = |word: &str| COLUMNS.contains(&word.to_ascii_lowercase().as_str());
    words.iter().any(|word| is_name(word)) && words.iter().all(|w| w.parse::<f64>().is_err())
}

/// Where each column stands, and how many there are.
fn columns(place: &str, words: &[&str]) -> Result<([usize; 6], usize), BadInput> {
    let mut at = [0; 6];
    for (slot, name) in at.iter_mut().zip(COLUMNS) {
        let found = words.iter().position(|w| w.eq_ignore_ascii_case(name));
        *slot = found.ok_or_else(|| {
            BadInput::new(
                place,
                format!("has no column {name}"),
                "name the columns x, y, z, nx, ny, nz",
            )
        })?;
    }
    Ok((at, words.len()))
}

fn bad(place: &str, what: String) -> BadInput {
    BadInput::new(place, what, "write x y z nx ny nz")
}

fn numbers(
    place: &str,
    words: &[&str],
    header: Option<&([usize; 6], usize)>,
) -> Result<[f64; 6], BadInput> {
    let &(at, count) = header.unwrap_or(&([0, 1, 2, 3, 4, 5], 6));
    if words.len() != count {
        return Err(bad(
            place,
            format!("{} values instead of {count}", words.len()),
        ));
    }
    let mut numbers = [0.0; 6];
    for (number, &i) in numbers.iter_mut().zip(&at) {
        let word = words[i];
        *number = match word.parse::<f64>() {
            Ok(x) if x.is_finite() => x,
            Ok(_) => return Err(bad(place, format!("{word} is not finite"))),
            Err(_) => return Err(bad(place, format!("\"{word}\" is no number"))),
        };
    }
    Ok(numbers)
}

fn sensor(place: &str, given: [f64; 6], up: UpAxis) -> Result<Sensor, BadInput> {
    let [x, y, z, nx, ny, nz] = given;
    let turned = |v| up.to_y_up(v);
    Sensor::new(turned(DVec3::new(x, y, z)), turned(DVec3::new(nx, ny, nz)))
        .ok_or_else(|| bad(place, "the normal is zero".to_owned()))
}

/// What was measured, as a table that [`read_sensors`] and spreadsheets read: a header, then for each sensor its six numbers
/// as they were given, the irradiance by channel (W/m²), and the illuminance (lx) at `efficacy` lumens a watt of white.
pub fn readings_csv(given: &[[f64; 6]], light: &[Irradiance], efficacy: f64) -> String {
    let mut text = format!("{},E_r,E_g,E_b,lux\n", COLUMNS.join(","));
    for (point, light) in given.iter().zip(light) {
        for x in point {
            text.push_str(&format!("{x},"));
        }
        // 17 significant digits bring every f64 back.
        for e in light.0.to_array() {
            text.push_str(&format!("{e:.16e},"));
        }
        text.push_str(&format!("{:.6e}\n", light.illuminance(efficacy)));
    }
    text
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;
    use crate::quantity::Rgb;

    #[test]
    fn comments_and_empty_lines_are_passed_over_and_lines_counted() {
        let text = "# a grid\n\n1 2 3 0 0 2 # on the wall\r\n  4 5 6 0 -1e-300 0\n";
        let list = read_sensors("p", text, UpAxis::Y).unwrap();
        assert_eq!(list.lines, [3, 4]);
        let same = |p, n| Sensor::new(p, n).unwrap();
        assert_eq!(
            list.sensors,
            [
                same(DVec3::new(1.0, 2.0, 3.0), DVec3::Z),
                same(DVec3::new(4.0, 5.0, 6.0), DVec3::NEG_Y)
            ]
        );
    }

    #[test]
    fn a_file_with_z_up_is_turned_with_its_scene() {
        let turned = read_sensors("p", "1 2 3 0 0 1", UpAxis::Z).unwrap();
        let plain = read_sensors("p", "1 3 -2 0 1 0", UpAxis::Y).unwrap();
        assert_eq!(turned.sensors, plain.sensors);
    }

    #[test]
    fn tables_are_read_by_the_names_of_their_columns_and_come_back() {
        let text = "\u{feff}# room 3\nname;NX;ny;nz;z;y;x\ndesk;0;1;0;3;2;1\n";
        let list = read_sensors("p", text, UpAxis::Y).unwrap();
        assert_eq!(list.given, [[1.0, 2.0, 3.0, 0.0, 1.0, 0.0]]);
        let plain = read_sensors("p", "1, 2, 3, 0, 1, 0", UpAxis::Y).unwrap();
        assert_eq!(plain.sensors, list.sensors);
        let light = [Irradiance(Rgb::new(0.1, 0.2, 1.0 / 3.0))];
        let table = readings_csv(&list.given, &light, 179.0);
        let again = read_sensors("p", &table, UpAxis::Y).unwrap();
        assert_eq!(again.given, list.given);
        let row: Vec<&str> = table.lines().nth(1).unwrap().split(',').collect();
        assert_eq!(
            row[8].parse::<f64>().unwrap().to_bits(),
            (1.0f64 / 3.0).to_bits()
        );
    }

    #[test]
    fn what_is_no_sensor_is_named_by_its_line() {
        for (text, what) in [
            ("1 2 3 0 0 1\n1 2 3", "p:2: 3 values instead of 6"),
            ("1 2 3 0 0 x", "p:1: \"x\" is no number"),
            ("1 2 nan 0 0 1", "p:1: nan is not finite"),
            ("1 2 3 0 0 0", "p:1: the normal is zero"),
            ("1,2,,0,0,1", "p:1: \"\" is no number"),
            ("x,y,z,nx,ny", "p:1: has no column nz"),
            (
                "x,y,z,nx,ny,nz\n1,2,3,0,0,1,7",
                "p:2: 7 values instead of 6",
            ),
        ] {
            let error = read_sensors("p", text, UpAxis::Y).unwrap_err().to_string();
            assert!(error.starts_with(what), "{error}");
        }
    }
}
