use super::*;
use crate::quantity::Rgb;

/// A PNG of `width` × `height` texels.
fn png(width: u32, height: u32, texel: impl Fn(u32, u32) -> [u8; 4]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = ::png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(::png::ColorType::Rgba);
    encoder.set_depth(::png::BitDepth::Eight);
    let data: Vec<u8> = (0..height)
        .flat_map(|y| (0..width).map(move |x| (x, y)))
        .flat_map(|(x, y)| texel(x, y))
        .collect();
    let mut writer = encoder.write_header().unwrap();
    writer.write_image_data(&data).unwrap();
    drop(writer);
    bytes
}

fn map(width: u32, height: u32, wrap: Wrap, texel: impl Fn(u32, u32) -> [u8; 4]) -> MipMap {
    let texture = Texture::new("t", png(width, height, texel)).unwrap();
    MipMap::new(texture.texels, [wrap; 2], None)
}

fn grey(step: u8) -> [u8; 4] {
    [step, step, step, 255]
}

fn triangle(points: [[f64; 2]; 3]) -> [DVec2; 3] {
    points.map(DVec2::from)
}

/// White left of the middle, black right of it.
fn half_white(x: u32, width: u32) -> [u8; 4] {
    grey(if x < width / 2 { 255 } else { 0 })
}

#[test]
fn the_mean_is_taken_in_linear_light() {
    // Black and white in turns: half the light, not sRGB 128 (22 % of it).
    let chequers = map(64, 64, Wrap::Repeat, |x, y| {
        grey(if (x + y) % 2 == 0 { 255 } else { 0 })
    });
    let square = [
        triangle([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]),
        triangle([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]),
    ];
    let mean: f64 = square
        .iter()
        .map(|&t| chequers.mean(t).colour.mean())
        .sum::<f64>()
        / 2.0;
    assert!((mean - 0.5).abs() < 1e-3, "{mean}");
}

/// Against the area on paper: a triangle with the part of its area left of the middle known.
#[test]
fn the_mean_over_a_triangle_is_its_share_of_the_white_half() {
    for width in [2, 3, 64, 1000] {
        let halves = map(width, 5, Wrap::Repeat, |x, _| half_white(x, width));
        let border = f64::from(width / 2) / f64::from(width);
        let t = triangle([[0.0, 0.1], [1.0, 0.1], [0.0, 0.9]]);
        // Right of the border remains a similar triangle.
        let wanted = 1.0 - (1.0 - border) * (1.0 - border);
        let found = halves.mean(t).colour.mean();
        assert!((found - wanted).abs() < 3e-3, "{width}: {found} {wanted}");
    }
}

#[test]
fn repetitions_do_not_change_the_mean_and_clamping_does() {
    let t = triangle([[0.1, 0.2], [0.9, 0.3], [0.4, 0.8]]);
    let shifted = t.map(|p| p + DVec2::new(7.0, -3.0));
    let of = |wrap, t| {
        map(32, 32, wrap, |x, _| half_white(x, 32))
            .mean(t)
            .colour
            .mean()
    };
    assert!((of(Wrap::Repeat, t) - of(Wrap::Repeat, shifted)).abs() < 1e-6);
    // Odd repetitions of a mirrored texture exchange left and right.
    let turned = t.map(|p| DVec2::new(1.0 - p.x, p.y));
    assert!((of(Wrap::Mirror, turned) - of(Wrap::Mirror, shifted)).abs() < 1e-6);
    assert_eq!(of(Wrap::Clamp, shifted), 0.0);
}

#[test]
fn huge_and_vanishing_triangles_have_a_mean() {
    let halves = map(16, 16, Wrap::Repeat, |x, _| half_white(x, 16));
    let huge = halves.mean(triangle([[0.0, 0.0], [9e5, 0.0], [0.0, 9e5]]));
    assert!((huge.colour.mean() - 0.5).abs() < 0.1, "{huge:?}");
    let point = halves.mean(triangle([[0.3, 0.3]; 3]));
    assert!((point.colour.mean() - 1.0).abs() < 1e-12, "{point:?}");
    let flat = halves.mean(triangle([[0.0, 0.5], [1.0, 0.5], [0.5, 0.5]]));
    assert!((0.1..0.9).contains(&flat.colour.mean()), "{flat:?}");
}

#[test]
fn cut_out_texels_have_no_colour() {
    // Transparent texels are red, as some exporters leave them; what is there is blue.
    let texture = Texture::new(
        "leaf",
        png(8, 8, |x, _| {
            if x < 2 {
                [0, 0, 255, 200]
            } else {
                [255, 0, 0, 10]
            }
        }),
    )
    .unwrap();
    let leaf = MipMap::new(texture.texels, texture.wrap, Some(0.5));
    let whole = triangle([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]]);
    let other = triangle([[0.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let (a, b) = (leaf.mean(whole), leaf.mean(other));
    assert!(((a.coverage + b.coverage) / 2.0 - 0.25).abs() < 1e-3);
    assert_eq!(b.colour, Rgb::new(0.0, 0.0, 1.0));
}

#[test]
fn every_level_has_the_mean_of_the_whole() {
    let noise = map(37, 22, Wrap::Clamp, |x, y| grey((x * 91 + y * 57) as u8));
    let all = |level: usize| {
        noise
            .sample(DVec2::new(0.5, 0.5), level as f64)
            .colour
            .mean()
    };
    let one = all(noise.level_count() - 1);
    let texels = (0..22).flat_map(|y| (0..37).map(move |x| (x, y)));
    let sum: f64 = texels
        .map(|(x, y)| srgb_decode(f64::from((x * 91 + y * 57) as u8) / 255.0))
        .sum();
    assert!((one - sum / f64::from(37 * 22)).abs() < 1e-6, "{one}");
}

#[test]
fn samples_lie_on_texel_middles_and_blend_between() {
    let two = map(2, 1, Wrap::Clamp, |x, _| half_white(x, 2));
    let at = |u: f64| two.sample(DVec2::new(u, 0.5), 0.0).colour.mean();
    assert_eq!([at(0.0), at(0.25), at(0.75), at(1.0)], [1.0, 1.0, 0.0, 0.0]);
    assert!((at(0.5) - 0.5).abs() < 1e-12);
    assert_eq!(two.nearest(DVec2::new(0.49, 0.0)).colour, Rgb::grey(1.0));
}

#[test]
fn damaged_pictures_are_refused_in_words() {
    let whole = png(16, 16, |x, y| [x as u8, y as u8, 7, 255]);
    assert!(decode(&whole).is_ok());
    for bytes in [
        &b""[..],
        b"GIF89a",
        &whole[..whole.len() / 2],
        b"\xFF\xD8\xFF\xE0",
    ] {
        assert!(decode(bytes).is_err());
    }
    // 16000 × 16000 texels in 60 bytes.
    let mut claims = whole.clone();
    claims[16..24].copy_from_slice(&[0, 0, 62, 128, 0, 0, 62, 128]);
    assert!(decode(&claims).is_err());
}
