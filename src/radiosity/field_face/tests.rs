//! The field of one face against light that is known everywhere.

use super::{FieldFace, Gathered, Source};
use crate::geom::{even_point, even_point_in};
use crate::mesh::Inset;
use crate::quantity::{Irradiance, Rgb};
use crate::radiosity::SolveFace;
use crate::radiosity::nodes::{FaceNodes, NodalField, inset};
use crate::radiosity::tests::{mesh_of, scene_of};
use crate::visibility::Viewpoint;
use glam::{DVec2, DVec3};

const WELD_DISTANCE: f64 = 1e-9;

/// The field on `face` as the nodes of the solution tell it, and an inset for its borders.
fn started(face: &SolveFace, light: impl Fn(&Viewpoint) -> Irradiance) -> (FieldFace, Inset) {
    let inset = inset(WELD_DISTANCE);
    let mut views = Vec::new();
    let nodes = [FaceNodes::new(face, inset, &mut views)];
    let values: Vec<Irradiance> = views.iter().map(light).collect();
    let start = NodalField {
        nodes: &nodes,
        values: &values,
    };
    let field = FieldFace::new(face, 0, &start, inset, Source::Node);
    (field, inset)
}

/// What a point gathers that receives `value`.
fn gathered(value: Irradiance) -> Gathered {
    Gathered {
        value,
        source: Source::Forgotten,
    }
}

/// Numbers in [0, 1), the same for each seed.
fn numbers(seed: u32) -> impl FnMut() -> f64 {
    let mut i = 100 * seed;
    move || {
        i += 1;
        even_point(i * 7919 % 1_000_003).x
    }
}

/// The corners of a floor whose back edge has narrow dents: its triangles are long and thin, and new points turn them into
/// others that reach into their neighbours.
fn dented(random: &mut impl FnMut() -> f64) -> Vec<DVec3> {
    let (width, depth) = (1.0 + 9.0 * random(), 0.3 + 3.0 * random());
    let mut outline = vec![[0.0, 0.0], [width, 0.0], [width, depth]];
    let mut x = width;
    for _ in 0..(4.0 * random()) as usize {
        let dent = 0.02 + random() * width / 12.0;
        x -= 0.01 + random() * width / 6.0;
        let tip = depth * (0.95 - 0.9 * random());
        outline.extend([[x, depth], [x - 0.3 * dent, tip], [x - dent, depth]]);
        x -= dent;
    }
    outline.push([0.0, depth]);
    let corners = outline.iter().map(|&[x, z]| DVec3::new(x, 0.0, z));
    corners.rev().collect()
}

#[test]
fn a_field_around_a_peak_does_not_exceed_it() {
    let mut refined = 0;
    for case in 0..600 {
        let mut random = numbers(case);
        let corners = dented(&mut random);
        let polygon = (0..corners.len() as u32).collect();
        let mesh = mesh_of(
            &scene_of(corners, vec![polygon], 0.5),
            0.5,
            0.5 + 3.0 * random(),
        );
        let face = &mesh.faces[0];
        let points = |i: u32| {
            let element = i as usize % face.mesh.elements.len();
            even_point_in(face.mesh.corners(element), i)
        };
        // Light that falls off from 1 in the middle of a peak.
        let (peak, width) = (face.domain.frame.to_space(points(case)), 0.1 + random());
        let light = |view: &Viewpoint| {
            let squared = view.position.distance_squared(peak) / (width * width);
            Irradiance(Rgb::grey((1.0 + squared).powi(-2)))
        };
        let (mut field, inset) = started(face, light);
        let share = [0.5, 0.1, 0.01][case as usize % 3];
        for _ in 0..8 {
            let most = field.errors().into_iter().fold(0.0, f64::max);
            let bought = field.buy(face, share * most, inset, |view| gathered(light(view)));
            refined += bought.expect("a mesh");
            let brightest = (0..400)
                .map(|i| field.at(points(i)).mean())
                .fold(0.0, f64::max);
            assert!(brightest <= 1.01, "case {case}: {brightest}");
        }
    }
    assert!(refined > 600 * 50, "{refined} gathers");
}

/// Mean square of what `field` is off by over the elements of `face` when it is lit by `light`.
fn off(field: &FieldFace, face: &SolveFace, light: impl Fn(DVec3) -> Irradiance) -> f64 {
    const POINTS: u32 = 400;
    let mesh = &face.mesh;
    let elements = 0..mesh.elements.len();
    let square = |p: DVec2| {
        let known = light(face.domain.frame.to_space(p));
        (field.at(p) - known).0.mean_square()
    };
    let integral: f64 = elements
        .map(|e| {
            let points = (0..POINTS).map(|i| even_point_in(mesh.corners(e), i));
            mesh.area(e) * points.map(square).sum::<f64>() / f64::from(POINTS)
        })
        .sum();
    integral / face.area
}

/// Squared errors of fields that have been bought so far, and what the fields expect of them.
#[test]
fn fields_are_off_by_what_they_expect() {
    let (mut found, mut expected) = (0.0, 0.0);
    for case in 0..200 {
        let mut random = numbers(case);
        let corners = dented(&mut random);
        let polygon = (0..corners.len() as u32).collect();
        let mesh = mesh_of(&scene_of(corners, vec![polygon], 0.5), 0.5, 2.0);
        let face = &mesh.faces[0];
        // The light of a lit patch near a corner of the floor, behind a board whose shadow has a soft edge.
        let at = face.mesh.corners(case as usize % face.mesh.elements.len())[0];
        let (at, width) = (face.domain.frame.to_space(at), 0.2 + random());
        let (sin, cos) = (6.3 * random()).sin_cos();
        let (across, soft) = (DVec3::new(cos, 0.0, sin), 0.05 + 0.2 * random());
        let light = |p: DVec3| {
            let squared = p.distance_squared(at) / (width * width);
            let share = ((p - at).dot(across) / soft + 1.0).clamp(0.0, 1.0);
            Irradiance(Rgb::grey((1.0 + squared).powi(-2) * share))
        };
        let (mut field, inset) = started(face, |view| light(view.position));
        let scale = (field.power().mean() / face.area).powi(-2);
        let permitted = 0.02 * 0.02 * face.area / scale;
        for _ in 0..20 {
            let errors = field.errors();
            if errors.iter().sum::<f64>() <= permitted {
                break;
            }
            let limit = permitted / (2.0 * errors.len() as f64);
            let gather = |view: &Viewpoint| gathered(light(view.position));
            field.buy(face, limit, inset, gather).expect("a mesh");
        }
        found += scale * off(&field, face, light) * face.area;
        expected += scale * field.errors().iter().sum::<f64>();
    }
    let ratio = (found / expected).sqrt();
    assert!((0.8..1.2).contains(&ratio), "{ratio}");
}

/// A trim of half a millimetre hides all light right at the edge of a floor.
#[test]
fn what_is_right_at_an_edge_is_not_the_light_of_the_elements_beside_it() {
    let corners = [[0.0, 0.0], [0.0, 4.0], [4.0, 4.0], [4.0, 0.0]];
    let corners = corners.map(|[x, z]| DVec3::new(x, 0.0, z));
    let scene = scene_of(corners.into(), vec![vec![0, 1, 2, 3]], 0.5);
    let mesh = mesh_of(&scene, 0.5, 1.0);
    let face = &mesh.faces[0];
    let light = |p: DVec3| {
        let from_edge = corners[2] - p;
        let is_hidden = from_edge.x.min(from_edge.z) < 5e-4;
        Irradiance(Rgb::grey(if is_hidden { 0.0 } else { 1.0 }))
    };
    let (field, _) = started(face, |view| light(view.position));
    let off = off(&field, face, light).sqrt();
    assert!(off < 0.02, "{off}");
}

/// A square that is dark at its corners, as is what stands behind a board, and as bright as its few points have told inside.
#[test]
fn light_between_the_corners_is_not_forgotten() {
    let corners = [[0.0, 0.0], [0.0, 1.0], [1.0, 1.0], [1.0, 0.0]];
    let corners = corners.map(|[x, z]| DVec3::new(x, 0.0, z));
    let mesh = mesh_of(
        &scene_of(corners.into(), vec![vec![0, 1, 2, 3]], 0.5),
        0.5,
        8.0,
    );
    let face = &mesh.faces[0];
    assert!(face.is_small);
    let ends = [0, 2].map(|v| face.mesh.site_points[v]);
    let centre = face.domain.frame.to_space(ends[0].midpoint(ends[1]));
    let at = |p: DVec3| {
        let from_middle = (p - centre).abs().max_element();
        Irradiance(Rgb::grey(if from_middle < 0.45 { 1.0 } else { 0.0 }))
    };
    let light = |view: &Viewpoint| at(view.position);
    let (mut field, inset) = started(face, light);
    let middle = face.domain.frame.to_plane(centre);
    let told = field.at(middle).mean();
    assert!(told > 0.5, "{told} {centre}");
    let mut buy = |limit: f64| {
        let bought = field.buy(face, limit, inset, |view| gathered(light(view)));
        bought.expect("a mesh");
        field.errors().iter().sum::<f64>()
    };
    // All that it is asked first are its dark corners: as much is unknown then as was known before.
    let doubt = buy(0.0);
    assert!(doubt > 0.25 * told * told, "{doubt}");
    let last = (0..6).map(|_| buy(1e-3)).last().expect("six");
    assert!(last < 0.5 * doubt, "{last} of {doubt}");
    let found = field.at(middle).mean();
    assert!((found - 1.0).abs() < 0.1, "{found}");
}
