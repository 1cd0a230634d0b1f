//! Scenes that the direct light once got wrong.

use crate::common::library::{faces_of, mesh_of_regression, random_point, regression_world};
use crate::common::reference::DirectReference;
use crate::common::rng::Rng;
use glam::DVec3;
use umbrage::direct::DirectLight;
use umbrage::scene::FaceSide;
use umbrage::visibility::{Scratch, Viewpoint};

#[test]
fn no_emitter_lights_its_own_sides() {
    let world = regression_world("back-of-tilted-emitter");
    let light = DirectLight::new(&world.scene, &world.blockers);
    let mut rng = Rng::new(11);
    let lamp = faces_of(&world.scene, "lamp")[0];
    for side in [FaceSide::Front, FaceSide::Back] {
        for _ in 0..100 {
            let x = random_point(&world.scene, lamp, &mut rng);
            let view = Viewpoint::new(x, world.scene.normal(lamp, side));
            let found = light.irradiance(&view, &mut Scratch::default());
            assert!(found.0.is_black(), "{found:?} at {x:?}, {side:?}");
        }
    }
}

#[test]
fn a_box_hides_the_floor_below_it() {
    let name = "floor-under-a-box";
    let world = regression_world(name);
    let light = DirectLight::new(&world.scene, &world.blockers);
    let reference = DirectReference::new(&mesh_of_regression(name, &world.scene));
    let x = DVec3::new(
        -0.063_430_739_866_295_91,
        0.035_861_540_766_117_35,
        -0.389_848_785_640_871_05,
    );
    let normal = DVec3::new(0.939_373_183_985_836_7, 0.0, -0.342_896_516_763_165_3).normalize();
    let x = x - world.scene.origin;
    let view = Viewpoint::new(x, normal);
    let found = light.irradiance(&view, &mut Scratch::default()).0.0.x;
    let expected = reference.irradiance(x, normal).x;
    assert!(
        (found - expected).abs() <= 1e-12,
        "{found} instead of {expected}"
    );
}
