//! Points with normals, one a line of text: the sensor grids of lighting programs.

use super::UpAxis;
use crate::bad_input::BadInput;
use crate::pipeline::Sensor;
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
}

/// The sensors in `text`: `x y z nx ny nz` on each line, `#` starts a comment; `source` is its name for messages.
///
/// Positions are metres in the scene's own frame, whatever unit its file has; `up` turns them as it turns the scene.
/// Normals may have any length.
pub fn read_sensors(source: &str, text: &str, up: UpAxis) -> Result<SensorList, BadInput> {
    let mut list = SensorList {
        source: source.to_owned(),
        ..SensorList::default()
    };
    for (number, line) in (1..).zip(text.lines()) {
        let words: Vec<&str> = line
            .split('#')
            .next()
            .unwrap_or_default()
            .split_whitespace()
            .collect();
        if words.is_empty() {
            continue;
        }
        let place = format!("{source}:{number}");
        list.sensors.push(sensor(&place, &words, up)?);
        list.lines.push(number);
    }
    Ok(list)
}

fn sensor(place: &str, words: &[&str], up: UpAxis) -> Result<Sensor, BadInput> {
    let bad = |what: String| BadInput::new(place, what, "write x y z nx ny nz");
    let mut numbers = [0.0; 6];
    if words.len() != numbers.len() {
        return Err(bad(format!("{} values instead of 6", words.len())));
    }
    for (number, word) in numbers.iter_mut().zip(words) {
        *number = match word.parse::<f64>() {
            Ok(x) if x.is_finite() => x,
            Ok(_) => return Err(bad(format!("{word} is not finite"))),
            Err(_) => return Err(bad(format!("\"{word}\" is no number"))),
        };
    }
    let [x, y, z, nx, ny, nz] = numbers;
    let turned = |v| up.to_y_up(v);
    Sensor::new(turned(DVec3::new(x, y, z)), turned(DVec3::new(nx, ny, nz)))
        .ok_or_else(|| bad("the normal is zero".to_owned()))
}

#[cfg(test)]
#[allow(clippy::unwrap_used, reason = "a test may panic")]
mod tests {
    use super::*;

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
        assert_eq!(turned, plain);
    }

    #[test]
    fn what_is_no_sensor_is_named_by_its_line() {
        for (text, what) in [
            ("1 2 3 0 0 1\n1 2 3", "p:2: 3 values instead of 6"),
            ("1 2 3 0 0 x", "p:1: \"x\" is no number"),
            ("1 2 nan 0 0 1", "p:1: nan is not finite"),
            ("1 2 3 0 0 0", "p:1: the normal is zero"),
        ] {
            let error = read_sensors("p", text, UpAxis::Y).unwrap_err().to_string();
            assert!(error.starts_with(what), "{error}");
        }
    }
}
