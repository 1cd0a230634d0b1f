//! A scene read, cleaned and lit for one of the commands, with times and memory of each stage.

use super::args::SceneArgs;
use super::progress::Bar;
use super::{memory, options, terminal};
use serde_json::{Value, json};
use std::path::Path;
use std::time::Instant;
use umbrage::io::write_atomically;
use umbrage::pipeline::{Progress, Solution, Summary, World, light};
use umbrage::radiosity::Bounces;
use umbrage::settings::{Exposure, Settings};

/// What was read, and what it cost.
pub(super) struct Prepared {
    pub(super) world: World,
    pub(super) settings: Settings,
    read_seconds: f64,
    clean_seconds: f64,
}

/// Reads and cleans the scene that the arguments name, and tells of its warnings.
pub(super) fn prepare(args: &SceneArgs, exposure: Exposure) -> anyhow::Result<Prepared> {
    let settings = options::settings(args, exposure)?;
    let start = Instant::now();
    let raw = options::scene(args)?;
    let read_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let world = World::new(&raw, &settings)?;
    let clean_seconds = start.elapsed().as_secs_f64();
    if !args.quiet {
        let texts: Vec<String> = world.warnings.iter().map(ToString::to_string).collect();
        terminal::warnings(&texts, args.verbose);
    }
    Ok(Prepared {
        world,
        settings,
        read_seconds,
        clean_seconds,
    })
}

/// A lit scene, and the memory that was in use at the end of each stage.
pub(super) struct Lit<'a> {
    pub(super) solution: Solution<'a>,
    stage_peaks: Vec<(&'static str, u64)>,
}

/// Lights what was prepared.
pub(super) fn solve<'a>(prepared: &'a Prepared, args: &SceneArgs) -> anyhow::Result<Lit<'a>> {
    let bar = Bar::new(args.quiet);
    let mut stage_peaks = Vec::new();
    let mut open: Option<&'static str> = None;
    let mut close = |stage: Option<&'static str>| {
        if let (Some(name), Some(bytes)) = (stage, memory::peak_bytes()) {
            stage_peaks.push((name, bytes));
        }
    };
    let progress: &mut Progress = &mut |name, done| {
        if open != Some(name) {
            close(open.replace(name));
        }
        bar.show(name, done);
    };
    let solved = light(&prepared.world, &prepared.settings, progress);
    close(open);
    bar.finish();
    let mut solution = solved?;
    let stages = &mut solution.summary.stages;
    stages.splice(
        0..0,
        [
            stage("read", prepared.read_seconds),
            stage("clean", prepared.clean_seconds),
        ],
    );
    Ok(Lit {
        solution,
        stage_peaks,
    })
}

fn stage(name: &'static str, seconds: f64) -> umbrage::pipeline::Stage {
    umbrage::pipeline::Stage { name, seconds }
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
            "peak_memory_bytes": memory::peak_bytes(),
            "summary": self.summary_json()?,
        });
        let mut bytes = serde_json::to_vec_pretty(&value)?;
        bytes.push(b'\n');
        Ok(write_atomically(path, &bytes)?)
    }

    /// The summary, each stage with the most memory in use up to its end.
    fn summary_json(&self) -> serde_json::Result<Value> {
        let mut value = serde_json::to_value(&self.solution.summary)?;
        for stage in value["stages"].as_array_mut().into_iter().flatten() {
            let peaks = self.stage_peaks.iter().rev();
            let peak = peaks.clone().find(|p| stage["name"] == p.0).map(|p| p.1);
            stage["peak_memory_bytes"] = json!(peak);
        }
        Ok(value)
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
        "exposure": match settings.exposure {
            Exposure::Auto => json!("auto"),
            Exposure::Ev(ev) => json!(ev),
        },
        "seed": settings.seed,
        "samples": settings.samples,
        "weld_distance_m": settings.clean.weld_distance,
        "planarity_m": settings.clean.planarity,
        "unit": args.unit,
        "up": args.up,
        "threads": args.threads,
    })
}
