//! Light through thousands of leaves is looked at by rays: as right as was asked for, and exact where exactness is asked for.

use crate::common::library::{random_point, world_of_mesh};
use crate::common::obj_lite::ObjMesh;
use crate::common::rng::Rng;
use umbrage::direct::DirectLight;
use umbrage::visibility::{Scratch, Viewpoint};

/// So many triangles of up to twice this size (metres) between the lamp and the floor hide about half of the lamp.
const LEAVES: usize = 12_000;
const LEAF: f64 = 0.0125;

/// A lamp of one square metre at height 2, a floor, and leaves between them.
fn thicket() -> ObjMesh {
    let mut rng = Rng::new(11);
    let mut mesh = ObjMesh::default();
    let square = |half: f64, z: f64| {
        [
            [-half, -half, z],
            [half, -half, z],
            [half, half, z],
            [-half, half, z],
        ]
    };
    let mut lamp = square(0.5, 2.0);
    lamp.reverse();
    mesh.add(&lamp, 0.0, 1.0);
    mesh.add(&square(0.2, 0.0), 0.5, 0.0);
    for _ in 0..LEAVES {
        let middle = [
            rng.range(-0.55, 0.55),
            rng.range(-0.55, 0.55),
            rng.range(1.3, 1.9),
        ];
        let mut tip = || middle.map(|c| c + rng.range(-LEAF, LEAF));
        mesh.add(&[tip(), tip(), tip()], 0.5, 0.0);
    }
    mesh
}

#[test]
fn rays_through_a_thicket_are_wrong_by_no_more_than_asked_for() {
    let world = world_of_mesh("thicket", &thicket());
    let light = DirectLight::new(&world.scene, &world.blockers);
    let floor = world.scene.faces.ids().nth(1).expect("lamp, floor, leaves");
    let normal = world.scene.faces[floor].frame.plane().normal;
    let (mut rng, mut scratch) = (Rng::new(3), Scratch::default());
    let (mut mean, mut squares, mut by_rays) = (0.0, [0.0; 2], 0);
    const POINTS: usize = 20;
    for _ in 0..POINTS {
        let view = Viewpoint::new(random_point(&world.scene, floor, &mut rng), normal);
        let exact = light.irradiance(&view, &mut scratch).mean();
        let open = light.unoccluded(&view, &mut scratch).mean();
        mean += exact / open / POINTS as f64;
        for (k, share) in [0.06, 0.02].into_iter().enumerate() {
            let found = light
                .look_within(&view, None, share * open, &mut scratch)
                .light
                .mean();
            squares[k] += ((found - exact) / (share * open)).powi(2) / POINTS as f64;
            by_rays += usize::from(found != exact);
        }
        assert_eq!(
            light
                .look_within(&view, None, 0.0, &mut scratch)
                .light
                .mean(),
            exact
        );
    }
    assert!((0.2..0.8).contains(&mean), "{mean} of the lamp is seen");
    assert_eq!(by_rays, 2 * POINTS, "the leaves are not enough of a crowd");
    assert!(
        squares.iter().all(|s| *s <= 1.5),
        "{:?} times what was asked for",
        squares.map(f64::sqrt)
    );
}
