//! SCENE on the command line: a file, or the name of a built-in scene.

use std::path::Path;

use anyhow::{Context, bail};

use crate::scene::builtin;
use crate::scene::file::{self, LoadOptions, Loaded};

#[derive(Debug, clap::Args)]
pub(super) struct SceneArgs {
    /// A scene file, or the name of a built-in scene
    scene: String,
    /// A parameter of the scene; may be given several times
    #[arg(long = "param", value_name = "NAME=VALUE", value_parser = param)]
    params: Vec<(String, String)>,
    /// Warn about what the scene asks for and cannot get, and leave it out
    #[arg(long)]
    lenient: bool,
}

impl SceneArgs {
    /// A scene without parameters.
    pub(super) fn named(scene: &str) -> Self {
        Self { scene: scene.into(), params: Vec::new(), lenient: false }
    }

    /// What was typed for SCENE.
    pub(super) fn typed(&self) -> &str {
        &self.scene
    }
}

fn param(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(name, _)| !name.is_empty());
    pair.map(|(name, value)| (name.into(), value.into())).ok_or_else(|| "allowed is name=value".into())
}

pub(super) fn load(args: &SceneArgs) -> anyhow::Result<Loaded> {
    if let Some(scene) = builtin::builtin(&args.scene, &args.params) {
        return Ok(Loaded { scene: scene?, warnings: Vec::new() });
    }
    let path = Path::new(&args.scene);
    if !path.exists() && path.extension().is_none() {
        let nearest = builtin::nearest(&args.scene);
        bail!("{}: there is no such file and no such built-in scene; {nearest}", args.scene);
    }
    let options = LoadOptions { params: args.params.clone(), lenient: args.lenient };
    file::load(path, &options).with_context(|| args.scene.clone())
}
