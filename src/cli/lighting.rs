//! A scene read, cleaned and lit for one of the commands, with times and memory of each stage.

use super::args::SceneArgs;
use super::progress::Shown;
use super::{options, terminal};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;
use umbrage::budget::peak_bytes;
use umbrage::io::write_atomically;
use umbrage::pipeline::{Progress, Solution, Stage, Summary, World, light};
use umbrage::radiosity::Bounces;
use umbrage::settings::{Exposure, Settings};

/// What was read, and what it cost.
pub(super) struct Prepared {
    pub(super) world: World,
    pub(super) settings: Settings,
    /// Reading and cleaning.
    stages: Vec<Stage>,
}

/// Reads and cleans the scene that the arguments name, and tells of its warnings.
pub(super) fn prepare(args: &SceneArgs, exposure: Exposure) -> anyhow::Result<Prepared> {
    let settings = options::settings(args, exposure)?;
    let start = Instant::now();
    let raw = options::scene(args)?;
    let read = Stage::ended("read", start.elapsed().as_secs_f64());
    let start = Instant::now();
    let world = World::new(&raw, &settings)?;
    let clean = Stage::ended("clean", start.elapsed().as_secs_f64());
    if !args.quiet {
        let texts: Vec<String> = world.warnings.iter().map(ToString::to_string).collect();
        terminal::warnings(&texts, args.verbose);
    }
    Ok(Prepared {
        world,
        settings,
        stages: vec![read, clean],
    })
}

/// A lit scene.
pub(super) struct Lit<'a> {
    pub(super) solution: Solution<'a>,
}

/// Lights what was prepared. Reading and cleaning have been paid for from the same budget.
pub(super) fn solve<'a>(prepared: &'a Prepared, args: &SceneArgs) -> anyhow::Result<Lit<'a>> {
    let shown = Shown::new(args.quiet, args.verbose);
    let spent: f64 = prepared.stages.iter().map(|s| s.seconds).sum();
    let mut settings = prepared.settings.clone();
    settings.budget.seconds = settings.budget.seconds.map(|most| (most - spent).max(0.0));
    let progress: &mut Progress = &mut |step| shown.show(step);
    let solved = light(&prepared.world, &settings, progress);
    shown.finish();
    let mut solution = solved?;
    let summary = &mut solution.summary;
    summary.stages.splice(0..0, prepared.stages.clone());
    if !args.quiet {
        // Those of the scene have been told.
        terminal::warnings(&summary.warnings[prepared.world.warnings.len()..], true);
    }
    Ok(Lit { solution })
}

impl Lit<'_> {
    /// Writes the summary for machines, if it was asked for.
    pub(super) fn write_json(
        &self,
        command: &str,
        args: &SceneArgs,
        settings: &Settings,
        outputs: &[&Path],
    ) -> anyhow::Result<()> {
        let Some(path) = &args.json else {
            return Ok(());
        };
        let outputs: Vec<String> = outputs.iter().map(|p| p.display().to_string()).collect();
        let value = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "command": command,
            "scene": self.solution.world.scene.source,
            "settings": settings_json(args, settings),
            "outputs": outputs,
            "peak_memory_bytes": peak_bytes(),
            "summary": self.summary(),
        });
        let mut bytes = serde_json::to_vec_pretty(&value)?;
        bytes.push(b'\n');
        Ok(write_atomically(path, &bytes)?)
    }

    /// What happened, for people.
    pub(super) fn summary(&self) -> &Summary {
        &self.solution.summary
    }
}

fn settings_json(args: &SceneArgs, settings: &Settings) -> Value {
    json!({
        "error": settings.error,
        "bounces": match settings.bounces {
            Bounces::All => json!("all"),
            Bounces::Count(n) => json!(n),
        },
        "solver": settings.solver.name(),
        "basis": settings.basis.name(),
        "exposure": match settings.exposure {
            Exposure::Auto => json!("auto"),
            Exposure::Ev(ev) => json!(ev),
        },
        "budget": args.budget,
        "seed": settings.seed,
        "samples": settings.samples,
        "weld_distance_m": settings.clean.weld_distance,
        "planarity_m": settings.clean.planarity,
        "unit": args.unit,
        "up": args.up,
        "threads": args.threads,
    })
}
