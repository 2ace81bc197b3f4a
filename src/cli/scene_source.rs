//! SCENE on the command line: a file, or the name of a built-in scene.

use std::fmt;
use std::io::{self, Write};
use std::path::Path;

use anyhow::{Context, bail};

use crate::scene::file::{self, LoadOptions, Loaded};
use crate::scene::{Scene, builtin};

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

    pub(super) fn load(&self) -> anyhow::Result<Loaded> {
        self.options.load(&self.scene)
    }

    /// The scene, ready to be traced, at another size if one is given. Says what was left out, unless it is to be quiet.
    pub(super) fn open(&self, size: Option<(usize, usize)>, quiet: bool) -> anyhow::Result<Scene> {
        let loaded = self.load()?;
        if !quiet {
            warn(&loaded)?;
        }
        let scene = Scene::new(loaded.scene).with_context(|| self.scene.clone())?;
        Ok(match size {
            Some((width, height)) => scene.with_size(width, height),
            None => scene,
        })
    }
}

impl SceneOptions {
    /// Whether any of them was typed.
    pub(super) fn any(&self) -> bool {
        self.lenient || !self.params.is_empty()
    }

    /// The scene called `typed`: a file, or a built-in one.
    pub(super) fn load(&self, typed: &str) -> anyhow::Result<Loaded> {
        if let Some(scene) = builtin::builtin(typed, &self.params) {
            return Ok(Loaded { scene: scene?, warnings: Vec::new() });
        }
        let path = Path::new(typed);
        if !path.exists() && path.extension().is_none() {
            let nearest = builtin::nearest(typed);
            bail!("{typed}: there is no such file and no such built-in scene; {nearest}");
        }
        let options = LoadOptions { params: self.params.clone(), lenient: self.lenient };
        file::load(path, &options).with_context(|| typed.to_string())
    }
}

/// `name=value …`, as they were typed.
impl fmt::Display for SceneOptions {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.params.iter().try_for_each(|(name, value)| write!(f, " {name}={value}"))?;
        f.write_str(if self.lenient { " lenient" } else { "" })
    }
}

fn param(text: &str) -> Result<(String, String), String> {
    let pair = text.split_once('=').filter(|(name, _)| !name.is_empty());
    pair.map(|(name, value)| (name.into(), value.into())).ok_or_else(|| "allowed is name=value".into())
}

/// Says on standard error what the scene asked for and did not get.
pub(super) fn warn(loaded: &Loaded) -> io::Result<()> {
    loaded.warnings.iter().try_for_each(|warning| writeln!(io::stderr(), "warning: {warning}"))
}
