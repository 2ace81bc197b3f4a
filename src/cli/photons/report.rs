//! A photon map as text and as JSON.

use std::fmt::Write;

use serde::Serialize;

use crate::math::color::Rgb;
use crate::render::photon::Kept;
use crate::render::photon::map::PhotonMap;
use crate::render::photon::tally::Tally;
use crate::report::table::{Align, Table, short};
use crate::scene::Scene;

/// What there is to say.
#[derive(Debug)]
pub(super) struct Report<'a> {
    pub(super) scene: &'a Scene,
    pub(super) map: &'a PhotonMap,
    pub(super) tally: &'a Tally,
    pub(super) kept: Kept,
    /// Seconds for sending photons out.
    pub(super) shoot: f64,
    /// Seconds for sorting them.
    pub(super) sort: f64,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    map: &'static str,
    photons: u64,
    stored: u64,
    escaped: u64,
    absorbed: u64,
    hits: Hits,
    flux: Flux,
    surfaces: Vec<Surface>,
    seconds: Seconds,
}

#[derive(Serialize)]
struct Hits {
    mean: f64,
    std_err: f64,
}

#[derive(Serialize)]
struct Flux {
    emitted: [f64; 3],
    absorbed: [f64; 3],
    escaped: [f64; 3],
    missing: [f64; 3],
}

#[derive(Serialize)]
struct Surface {
    name: String,
    area: f64,
    hits: u64,
    incident: [f64; 3],
    first: [f64; 3],
    absorbed: [f64; 3],
}

#[derive(Serialize)]
struct Seconds {
    shoot: f64,
    sort: f64,
}

impl Report<'_> {
    pub(super) fn json(&self) -> anyhow::Result<String> {
        let Self { scene, tally, .. } = self;
        let areas = scene.areas();
        let surfaces = scene.shapes().iter().zip(&tally.shapes).zip(areas).map(|((shape, of_shape), area)| Surface {
            name: shape.name.clone(),
            area,
            hits: of_shape.hits,
            incident: of_shape.incident.to_array(),
            first: of_shape.first.to_array(),
            absorbed: of_shape.absorbed.to_array(),
        });
        let document = Document {
            schema: 1,
            map: self.kept.name(),
            photons: tally.emitted,
            stored: tally.stored,
            escaped: tally.escaped,
            absorbed: tally.absorbed,
            hits: Hits { mean: tally.hits.mean(), std_err: finite(tally.hits.std_err()) },
            flux: Flux {
                emitted: tally.emitted_flux.to_array(),
                absorbed: tally.absorbed_flux.to_array(),
                escaped: tally.escaped_flux.to_array(),
                missing: tally.missing().to_array(),
            },
            surfaces: surfaces.collect(),
            seconds: Seconds { shoot: self.shoot, sort: self.sort },
        };
        Ok(serde_json::to_string_pretty(&document)?)
    }

    pub(super) fn text(&self) -> String {
        let Self { scene, tally, .. } = self;
        let right = |head| (head, Align::Right);
        let heads = [
            ("surface", Align::Left),
            right("area"),
            right("hits"),
            right("flux in (r g b)"),
            right("of it first hits"),
            right("absorbed"),
        ];
        let mut table = Table::new(&heads);
        for ((shape, of_shape), area) in scene.shapes().iter().zip(&tally.shapes).zip(scene.areas()) {
            table.row([
                shape.name.clone(),
                short(area),
                of_shape.hits.to_string(),
                of_shape.incident.to_array().map(short).join(" "),
                short(of_shape.first.mean()),
                short(of_shape.absorbed.mean()),
            ]);
        }
        let mut text = table.text("");
        let [emitted, absorbed, escaped] = [tally.emitted_flux, tally.absorbed_flux, tally.escaped_flux].map(Rgb::mean);
        let share = |part: f64| if emitted > 0.0 { 100.0 * part / emitted } else { 0.0 };
        let (mean, error) = (tally.hits.mean(), tally.hits.std_err());
        let out = &mut text;
        let _ = writeln!(
            out,
            "{} photons: {} absorbed, {} escaped; {} stored in the {} map",
            tally.emitted,
            tally.absorbed,
            tally.escaped,
            tally.stored,
            self.kept.name()
        );
        let _ = writeln!(out, "{mean:.4} hits per photon, standard error {error:.4}");
        let _ = writeln!(
            out,
            "flux: emitted {}, absorbed {} ({:.3} %), escaped {} ({:.3} %), missing {:.1e}",
            short(emitted),
            short(absorbed),
            share(absorbed),
            short(escaped),
            share(escaped),
            tally.missing().mean()
        );
        let _ = writeln!(out, "{:.2} s to send them out, {:.2} s to sort {}", self.shoot, self.sort, self.map.len());
        text
    }
}

/// JSON has no infinity: the error of one photon is not known.
fn finite(x: f64) -> f64 {
    if x.is_finite() { x } else { f64::MAX }
}
