//! `umbrage bake`: scene in, lit glTF out.

use super::Outcome;
use super::args::BakeArgs;
use super::options;
use super::progress::Bar;
use umbrage::io::{write_atomically, write_glb};
use umbrage::pipeline::{Summary, World, light};

pub(super) fn run(args: &BakeArgs) -> anyhow::Result<Outcome> {
    options::use_threads(args.scene.threads)?;
    let settings = options::settings(&args.scene, options::exposure(&args.exposure)?)?;
    let raw = options::scene(&args.scene)?;
    let world = World::new(&raw, &settings)?;
    let bar = Bar::new(args.scene.quiet);
    let solution = light(&world, &settings, &mut |name, done| bar.show(name, done))?;
    bar.finish();
    let output = args
        .output
        .clone()
        .unwrap_or_else(|| options::default_output(args.scene.scene.as_deref()));
    write_atomically(&output, &write_glb(&solution.lit_scene()))?;
    if let Some(path) = &args.scene.json {
        write_atomically(path, &serde_json::to_vec_pretty(&solution.summary)?)?;
    }
    if !args.scene.quiet {
        print_summary(&solution.summary);
    }
    Ok(Outcome::Done)
}

fn print_summary(s: &Summary) {
    eprintln!("{s:#?}");
}
