//! SCENE on the command line: a file, or the name of a built-in scene.

use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, bail};

use crate::scene::builtin;
use crate::scene::file::{self, LoadOptions, Loaded};

#[derive(Debug, clap::Args)]
pub(super) struct SceneArgs {
    /// A scene file, or the name of a built-in scene
    scene: String,
    #[command(flatten)]
    options: SceneOptions,
}

/// How a scene is read.
#[derive(Debug, Default, clap::Args)]
pub(super) struct SceneOptions {
    /// A parameter of the scene; may be given several times
    #[arg(long = "param", value_name = "NAME=VALUE", value_parser = param)]
    params: Vec<(String, String)>,
    /// Warn about what the scene asks for and cannot get, and leave it out
    #[arg(long)]
    lenient: bool,
}

impl SceneArgs {
    /// What was typed for SCENE.
    pub(super) fn typed(&self) -> &str {
        &self.scene
    }

    /// The scene.
    pub(super) fn load(&self) -> anyhow::Result<Loaded> {
        load(&self.scene, &self.options)
    }
}

fn param(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(name, _)| !name.is_empty());
    pair.map(|(name, value)| (name.into(), value.into())).ok_or_else(|| "allowed is name=value".into())
}

/// The scene of this name or in this file.
pub(super) fn load(scene: &str, how: &SceneOptions) -> anyhow::Result<Loaded> {
    if let Some(scene) = builtin::builtin(scene, &how.params) {
        return Ok(Loaded { scene: scene?, warnings: Vec::new() });
    }
    let path = Path::new(scene);
    if !path.exists() && path.extension().is_none() {
        let nearest = builtin::nearest(scene);
        bail!("{scene}: there is no such file and no such built-in scene; {nearest}");
    }
    let options = LoadOptions { params: how.params.clone(), lenient: how.lenient };
    file::load(path, &options).with_context(|| scene.to_string())
}

/// Says on standard error what the scene asked for and did not get.
pub(super) fn warn(loaded: &Loaded) -> io::Result<()> {
    loaded.warnings.iter().try_for_each(|warning| writeln!(io::stderr(), "warning: {warning}"))
}
