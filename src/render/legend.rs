//! The scale of a false-colour picture, drawn below it.

use super::{ColourScale, Picture, false_colour, glyphs};

/// Height of the strip below the picture, pixels.
pub const LEGEND_HEIGHT: u32 = 44;

/// Pixels for each cell of a letter, room at both ends of the bar, and from top to bottom: bar, tick, number.
const CELL: i64 = 2;
const MARGIN: i64 = 14;
const BAR: [i64; 2] = [5, 19];
const TICK: [i64; 2] = [19, 23];
const NUMBER: i64 = 26;

/// Letters between two numbers at least.
const GAP: usize = 2;

const INK: [u8; 3] = [255; 3];
const GROUND: [u8; 3] = [0; 3];

/// `picture` with `scale` in a strip of [`LEGEND_HEIGHT`] below it: the colours from 0 to the end, ticks at round numbers,
/// and the unit at the right end. Where the picture is too narrow for all numbers, every second, fourth, … is written.
pub fn with_legend(picture: &Picture, scale: &ColourScale) -> Picture {
    let width = picture.width as usize;
    let mut strip = Strip {
        width: picture.width.into(),
        pixels: vec![GROUND; width * LEGEND_HEIGHT as usize],
    };
    strip.draw(scale);
    Picture {
        width: picture.width,
        height: picture.height + LEGEND_HEIGHT,
        pixels: [picture.pixels.as_slice(), &strip.pixels].concat(),
    }
}

struct Strip {
    width: i64,
    pixels: Vec<[u8; 3]>,
}

impl Strip {
    fn draw(&mut self, scale: &ColourScale) {
        let unit = scale.unit.name();
        let (left, right) = (MARGIN, self.width - 2 * MARGIN - text_width(unit));
        let length = (right - left).max(1);
        for x in left..right {
            let t = (x - left) as f64 / (length - 1).max(1) as f64;
            self.fill(x, BAR, false_colour(t));
        }
        self.write(self.width - MARGIN - text_width(unit), BAR[0], unit);

        let step = scale.step();
        let count = (scale.top / step * (1.0 + f64::EPSILON * 4.0)) as usize;
        let texts: Vec<String> = (0..=count).map(|k| number(k as f64 * step)).collect();
        let widest = texts.iter().map(|t| text_width(t)).max().unwrap_or(0);
        let room = length as f64 * step / scale.top;
        let every = ((widest + GAP as i64 * CELL * glyphs::ADVANCE as i64) as f64 / room).ceil();
        let every = (every.max(1.0) as usize).next_power_of_two();
        for (k, text) in texts.iter().enumerate() {
            let x = left + ((length - 1) as f64 * k as f64 * step / scale.top).round() as i64;
            self.fill(x, TICK, INK);
            if k % every == 0 {
                self.write((x - text_width(text) / 2).max(0), NUMBER, text);
            }
        }
    }

    fn fill(&mut self, x: i64, [top, bottom]: [i64; 2], colour: [u8; 3]) {
        for y in top..bottom {
            self.set(x, y, colour);
        }
    }

    fn write(&mut self, x: i64, y: i64, text: &str) {
        for (k, letter) in (0..).zip(text.chars()) {
            let start = x + k * CELL * glyphs::ADVANCE as i64;
            for (row, cells) in (0..).zip(glyphs::rows(letter)) {
                for (column, cell) in (0..).zip(cells.bytes()) {
                    if cell == b'#' {
                        let at = start + column * CELL;
                        for dx in 0..CELL {
                            let rows = y + row * CELL;
                            self.fill(at + dx, [rows, rows + CELL], INK);
                        }
                    }
                }
            }
        }
    }

    /// What falls beside a narrow picture is not seen.
    fn set(&mut self, x: i64, y: i64, colour: [u8; 3]) {
        if (0..self.width).contains(&x) && (0..i64::from(LEGEND_HEIGHT)).contains(&y) {
            self.pixels[(y * self.width + x) as usize] = colour;
        }
    }
}

fn text_width(text: &str) -> i64 {
    let letters = text.chars().count() * glyphs::ADVANCE;
    letters.saturating_sub(glyphs::ADVANCE - glyphs::WIDTH) as i64 * CELL
}

/// Numbers in this range are written without an exponent: no more than three zeros before or after the digits.
const PLAIN: std::ops::Range<f64> = 1e-3..1e6;

/// A multiple of a round step without the noise of its last digits.
fn number(x: f64) -> String {
    let x: f64 = format!("{x:.5e}").parse().unwrap_or(x);
    if x == 0.0 || PLAIN.contains(&x) {
        x.to_string()
    } else {
        format!("{x:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::LightUnit;

    fn legend(width: u32, top: f64) -> Picture {
        let picture = Picture {
            width,
            height: 1,
            pixels: vec![[9; 3]; width as usize],
        };
        let unit = LightUnit::Lux { efficacy: 179.0 };
        with_legend(&picture, &ColourScale { unit, top })
    }

    #[test]
    fn the_bar_runs_through_the_whole_map_and_the_picture_stays() {
        let found = legend(400, 500.0);
        assert_eq!((found.height, found.pixels.len()), (45, 400 * 45));
        assert_eq!(found.pixels[..400], [[9; 3]; 400]);
        let row = &found.pixels[400 * 10..400 * 11];
        for t in [0.0, 0.5, 1.0] {
            assert!(row.contains(&false_colour(t)), "{t}");
        }
    }

    #[test]
    fn every_letter_of_a_number_or_unit_is_there() {
        for top in [0.6, 500.0, 3e-5, 2e7] {
            for text in [
                number(top),
                number(top / 5.0),
                "W/m²".to_owned(),
                "lx".to_owned(),
            ] {
                for letter in text.chars() {
                    assert!(
                        glyphs::rows(letter).concat().contains('#'),
                        "{letter} of {text}"
                    );
                }
            }
        }
        assert_eq!(number(0.1 + 0.2), "0.3");
    }

    #[test]
    fn narrow_pictures_do_without_what_has_no_room() {
        for width in [1, 20, 60] {
            assert_eq!(legend(width, 1e5).pixels.len(), width as usize * 45);
        }
    }
}
