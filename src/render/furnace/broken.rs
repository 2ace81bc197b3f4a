//! Negative controls: engines and models with one mistake each, and the checks that must reject them.
//!
//! The engines are a path tracer as a textbook has it, independent of the one that is tested: without a mistake it must
//! pass every check, and so is an oracle too.

use std::sync::Arc;

use glam::DVec3;

use super::Furnace;
use crate::bsdf::{Bsdf, BsdfSample, Density, Uniforms, subject};
use crate::math::color::Rgb;
use crate::render::Radiance;
use crate::render::path::{PathTracer, Roulette, Strategy};
use crate::sampling::sampler::Sampler;
use crate::scene::{Ray, Scene, Sought, Surface};
use crate::validate::Sheet;

/// A mistake of a path tracer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mistake {
    /// One reflection too many.
    DepthOffByOne,
    /// Light that has been connected to counts again where a path hits it.
    DirectTwice,
    /// Survivors of roulette are not weighed up.
    RouletteUnweighed,
    /// Where roulette is played, half of the paths end at each reflection, whatever the albedo.
    RouletteTooShort,
    /// Connections forget the cosine at the surface.
    CosineForgotten,
    /// Emitters shine from both sides.
    BackEmits,
    /// The paths of a split are added up, not averaged.
    SplitNotDivided,
}

/// A path tracer at its shortest: diffuse scenes without a sky, masks or Dirac lobes.
#[derive(Clone, Copy, Debug)]
pub struct Textbook {
    /// How it traces; `RandomConnect` is done as `Direct`.
    pub settings: PathTracer,
    /// What is wrong with it.
    pub mistake: Option<Mistake>,
}

impl Radiance for Textbook {
    fn radiance(&self, scene: &Scene, ray: Ray, sampler: &mut dyn Sampler) -> Rgb {
        let Some(first) = scene.intersect(&ray) else { return Rgb::BLACK };
        let split = self.settings.first_split.max(1);
        let rest: Rgb = (0..split).map(|_| self.reflected(scene, ray.dir, first, sampler)).sum();
        let divisor = if self.has(Mistake::SplitNotDivided) { 1.0 } else { f64::from(split) };
        self.emitted(scene, &first, -ray.dir).1 + rest / divisor
    }
}

impl Textbook {
    fn has(&self, mistake: Mistake) -> bool {
        self.mistake == Some(mistake)
    }

    /// The emitter's number and its radiance towards `wo`.
    fn emitted(&self, scene: &Scene, surface: &Surface, wo: DVec3) -> (usize, Rgb) {
        let both = self.has(Mistake::BackEmits) && surface.ng.dot(wo) < 0.0;
        let surface = if both { Surface { ng: -surface.ng, ..*surface } } else { *surface };
        scene.emitters().emitted(&surface, wo).unwrap_or((0, Rgb::BLACK))
    }

    /// The light that `surface` reflects against `dir`.
    fn reflected(&self, scene: &Scene, mut dir: DVec3, mut surface: Surface, sampler: &mut dyn Sampler) -> Rgb {
        let (mut sum, mut weight) = (Rgb::BLACK, Rgb::WHITE);
        let limit = self.settings.bounces.map_or(u32::MAX, |r| r + u32::from(self.has(Mistake::DepthOffByOne)));
        for depth in 1..=limit {
            sum += weight * self.connected(scene, dir, &surface, sampler);
            let bsdf = scene.material_of(surface.shape).at(surface.uv, surface.color);
            let Some(drawn) = bsdf.sample(surface.frame.to_local(-dir), sampler.next_uniforms()) else { break };
            weight = weight * drawn.weight;
            let roulette = match self.settings.roulette {
                Roulette::Off => Roulette::Off,
                _ if self.has(Mistake::RouletteTooShort) => Roulette::Constant(0.5),
                asked => asked,
            };
            let survival = roulette.survival(depth, drawn.weight, weight);
            if survival < 1.0 {
                if sampler.next_1d() >= survival {
                    break;
                }
                weight = if self.has(Mistake::RouletteUnweighed) { weight } else { weight / survival };
            }
            dir = surface.frame.to_world(drawn.wi);
            let Some(next) = scene.intersect(&scene.leave(&surface, dir)) else { break };
            let (number, radiance) = self.emitted(scene, &next, -dir);
            let Density::SolidAngle(pdf) = drawn.density else { break };
            let share = match self.settings.strategy {
                Strategy::Bsdf => 1.0,
                Strategy::Mis => {
                    let by = self.settings.light_sampling;
                    self.settings.heuristic.weight(pdf, scene.emitters().pdf(by, number, surface.p, dir, &next))
                }
                Strategy::Direct | Strategy::RandomConnect => f64::from(u8::from(self.has(Mistake::DirectTwice))),
            };
            if !radiance.is_black() {
                sum += weight * radiance * share;
            }
            surface = next;
        }
        sum
    }

    /// One connection to an emitter.
    fn connected(&self, scene: &Scene, dir: DVec3, surface: &Surface, sampler: &mut dyn Sampler) -> Rgb {
        if self.settings.strategy == Strategy::Bsdf {
            return Rgb::BLACK;
        }
        let (choice, u) = (sampler.next_1d(), sampler.next_2d());
        let by = self.settings.light_sampling;
        // No room has a sky.
        let Some(light) = scene.emitters().sample(Sought::Every, by, surface.p, choice, u) else {
            return Rgb::BLACK;
        };
        let wi = surface.frame.to_local(light.wi);
        let bsdf = scene.material_of(surface.shape).at(surface.uv, surface.color);
        let (f, pdf) = bsdf.eval_pdf(surface.frame.to_local(-dir), wi);
        let cosine = if self.has(Mistake::CosineForgotten) { 1.0 } else { wi.z.abs() };
        let share = match light.density {
            Density::SolidAngle(p) if self.settings.strategy == Strategy::Mis => {
                self.settings.heuristic.weight(p, pdf) / p
            }
            Density::SolidAngle(p) | Density::Dirac(p) => 1.0 / p,
        };
        f * cosine * light.radiance * scene.transmittance(&scene.shadow_ray(surface, &light), 0) * share
    }
}

/// Two lobes, half each, drawn with other probabilities than the density claims.
#[derive(Debug)]
pub struct SkewedLobes {
    lobes: [Box<dyn Bsdf>; 2],
    /// Probability with which the first is drawn.
    drawn: f64,
    /// What `sample` divides by.
    divided: f64,
    /// What `pdf` claims.
    claimed: f64,
}

impl SkewedLobes {
    fn new(drawn: f64, divided: f64, claimed: f64) -> Self {
        Self { lobes: [model("lambert:rho=0.8"), model("ggx:alpha=0.2")], drawn, divided, claimed }
    }

    fn density(&self, first: f64, wo: DVec3, wi: DVec3) -> f64 {
        first * self.lobes[0].pdf(wo, wi) + (1.0 - first) * self.lobes[1].pdf(wo, wi)
    }
}

impl Bsdf for SkewedLobes {
    fn eval(&self, wo: DVec3, wi: DVec3) -> Rgb {
        (self.lobes[0].eval(wo, wi) + self.lobes[1].eval(wo, wi)) * 0.5
    }

    fn pdf(&self, wo: DVec3, wi: DVec3) -> f64 {
        self.density(self.claimed, wo, wi)
    }

    fn sample(&self, wo: DVec3, u: Uniforms) -> Option<BsdfSample> {
        let (lobe, rest) = if u.lobe < self.drawn {
            (&self.lobes[0], u.lobe / self.drawn)
        } else {
            (&self.lobes[1], (u.lobe - self.drawn) / (1.0 - self.drawn))
        };
        let wi = lobe.sample(wo, Uniforms { lobe: rest, ..u })?.wi;
        BsdfSample::new(wi, self.eval(wo, wi), self.density(self.divided, wo, wi))
    }
}

fn model(text: &str) -> Box<dyn Bsdf> {
    subject::parse(text).unwrap_or_else(|error| panic!("a twin's subject is wrong: {error}"))
}

/// What has the mistake.
#[derive(Clone, Copy, Debug)]
pub enum Made {
    /// A path tracer.
    Engine(Mistake),
    /// A model with these probabilities: drawn, divided by, claimed.
    Lobes(f64, f64, f64),
}

/// A mistake, and the checks of which at least one must find it.
#[derive(Clone, Copy, Debug)]
pub struct Twin {
    /// What the mistake is called.
    pub name: &'static str,
    /// What it is, in one sentence.
    pub why: &'static str,
    /// The checks that must reject it.
    pub caught_by: &'static [&'static str],
    /// What has the mistake.
    pub made: Made,
}

impl Twin {
    /// The sheet of what has the mistake.
    pub fn broken(&self, furnace: &Furnace) -> Sheet {
        match self.made {
            Made::Engine(mistake) => furnace.path_tracer(&textbook(Some(mistake))),
            Made::Lobes(drawn, divided, claimed) => lobes_sheet(furnace, drawn, divided, claimed),
        }
    }

    /// The sheet of the same without it.
    pub fn original(&self, furnace: &Furnace) -> Sheet {
        match self.made {
            Made::Engine(_) => furnace.path_tracer(&textbook(None)),
            Made::Lobes(drawn, ..) => lobes_sheet(furnace, drawn, drawn, drawn),
        }
    }
}

/// The textbook's engine with this mistake.
pub fn textbook(mistake: Option<Mistake>) -> impl Fn(PathTracer) -> Box<dyn Radiance> + Sync {
    move |settings| Box::new(Textbook { settings, mistake })
}

fn lobes_sheet(furnace: &Furnace, drawn: f64, divided: f64, claimed: f64) -> Sheet {
    let model: Arc<dyn Bsdf> = Arc::new(SkewedLobes::new(drawn, divided, claimed));
    let mut sheets = furnace.subjects(&[model]);
    sheets.swap_remove(0)
}

/// All mistakes.
pub fn twins() -> &'static [Twin] {
    const ENERGY: &[&str] = &["furnace_exact", "furnace_mean"];
    &[
        Twin {
            name: "depth_off_by_one",
            why: "one reflection too many",
            caught_by: &["furnace_exact"],
            made: Made::Engine(Mistake::DepthOffByOne),
        },
        Twin {
            name: "direct_twice",
            why: "light that has been connected to counts again where a path hits it",
            caught_by: ENERGY,
            made: Made::Engine(Mistake::DirectTwice),
        },
        Twin {
            name: "roulette_unweighed",
            why: "survivors of roulette are not weighed up",
            caught_by: &["furnace_mean"],
            made: Made::Engine(Mistake::RouletteUnweighed),
        },
        Twin {
            name: "roulette_too_short",
            why: "a survival of 1/2 below the square of the albedo: the mean is right, the variance infinite",
            caught_by: &["roulette_variance"],
            made: Made::Engine(Mistake::RouletteTooShort),
        },
        Twin {
            name: "cosine_forgotten",
            why: "connections forget the cosine at the surface",
            caught_by: &["furnace_mean", "one_emitter"],
            made: Made::Engine(Mistake::CosineForgotten),
        },
        Twin {
            name: "back_emits",
            why: "emitters shine from both sides",
            caught_by: &["one_sided"],
            made: Made::Engine(Mistake::BackEmits),
        },
        Twin {
            name: "split_not_divided",
            why: "the paths of a split are added up, not averaged",
            caught_by: &["furnace_mean"],
            made: Made::Engine(Mistake::SplitNotDivided),
        },
        Twin {
            name: "lobes_drawn_otherwise",
            why: "lobes are drawn evenly, but the density is that of 4 to 1",
            caught_by: &["albedo_bsdf"],
            made: Made::Lobes(0.5, 0.8, 0.8),
        },
        Twin {
            name: "lobes_claimed_otherwise",
            why: "draws are right, but pdf has other probabilities of the lobes: only MIS is wrong",
            caught_by: &["albedo_mis"],
            made: Made::Lobes(0.5, 0.5, 0.9),
        },
    ]
}

#[cfg(test)]
mod tests {
    use super::super::Engine;
    use super::*;
    use crate::validate::Outcome;

    /// Small enough for a unit test; what is found is large.
    fn quick(only: &[&'static str]) -> Furnace {
        Furnace { samples: 2048, level: 1e-3, only: only.to_vec(), ..Furnace::default() }
    }

    #[test]
    fn every_twin_is_rejected_and_every_original_passes() {
        for twin in twins() {
            let broken = twin.broken(&quick(twin.caught_by));
            let caught = broken.checks.iter().any(|check| check.outcome == Outcome::Fail);
            assert!(caught, "{}: {broken:#?}", twin.name);
            let original = twin.original(&quick(twin.caught_by));
            assert_eq!(original.outcome(), Outcome::Pass, "{}: {original:#?}", twin.name);
        }
    }

    #[test]
    fn both_path_tracers_pass_every_check() {
        let engine: &Engine = &|settings| Box::new(settings);
        for sheet in [quick(&[]).path_tracer(engine), quick(&[]).path_tracer(&textbook(None))] {
            assert_eq!(sheet.outcome(), Outcome::Pass, "{sheet:#?}");
        }
    }

    #[test]
    fn an_infinite_variance_is_called_so_and_has_no_rate() {
        let furnace = Furnace { samples: 16384, ..quick(&["rate", "roulette_variance"]) };
        let sheet = furnace.path_tracer(&textbook(Some(Mistake::RouletteTooShort)));
        let roulette = sheet.check("roulette_variance").expect("the check");
        assert_eq!(roulette.outcome, Outcome::Fail);
        assert!(roulette.detail.contains("INFINITE variance") && roulette.statistic > 1.0, "{roulette:?}");
        let rate = sheet.check("rate").expect("the check");
        assert_ne!(rate.outcome, Outcome::Pass, "{rate:?}");
    }
}
