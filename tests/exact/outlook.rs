//! What the middle of a tiny face sees of the emitters tells the light there exactly, and close by as long as no shadow ends.

use crate::common::library::{faces_of, random_point, world_of};
use crate::common::rng::Rng;
use umbrage::direct::DirectLight;
use umbrage::scene::FaceSide;
use umbrage::visibility::{Scratch, Viewpoint};

#[test]
fn an_outlook_is_exact_where_it_was_taken_and_close_by() {
    /// How far a point of the same tiny face may be, metres; the rooms are some metres wide.
    const CLOSE: f64 = 1e-3;
    let world = world_of("two-emitters");
    let light = DirectLight::new(&world.scene, &world.blockers);
    let (mut rng, mut scratch) = (Rng::new(5), Scratch::default());
    let floor = faces_of(&world.scene, "floor")[0];
    let normal = world.scene.normal(floor, FaceSide::Front);
    let (mut clear, mut doubtful) = (0, 0);
    for _ in 0..300 {
        let x = random_point(&world.scene, floor, &mut rng);
        let view = Viewpoint::new(x, normal);
        let outlook = light.outlook(&view, None, 0.0, &mut scratch);
        let exact = light.irradiance(&view, &mut scratch).mean();
        let found = light.irradiance_through(&outlook, &view, &mut scratch);
        assert!((found.mean() - exact).abs() <= 1e-12, "{found:?}, {exact}");
        if outlook.doubt > 0.0 {
            doubtful += 1;
            continue;
        }
        clear += 1;
        let beside = Viewpoint::new(x + normal.any_orthonormal_vector() * CLOSE, normal);
        let there = light.irradiance(&beside, &mut scratch).mean();
        let found = light.irradiance_through(&outlook, &beside, &mut scratch);
        // In the dark and in full light; where a shadow ends between the two it is that of a millimetre.
        assert!((found.mean() - there).abs() <= CLOSE, "{found:?}, {there}");
    }
    assert!(clear > 100 && doubtful > 10, "{clear} {doubtful}");
}
