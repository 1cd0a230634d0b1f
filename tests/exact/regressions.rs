//! Scenes that the direct light once got wrong.

use crate::common::library::{faces_of, random_point, regression_world};
use crate::common::rng::Rng;
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
