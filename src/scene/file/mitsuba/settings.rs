//! Sensors, films, samplers and integrators.

use glam::DAffine3;

use super::Context;
use super::document::NodeId;
use super::props::Props;
use crate::sampling::filter::{Filter, KNOWN};
use crate::scene::camera::{Camera, Projection, horizontal_fov};
use crate::scene::description::{FilmSettings, RenderSettings};
use crate::scene::file::error::SceneError;

/// The largest image, in pixels on a side.
const LARGEST: i64 = 65_536;

/// Camera, film and number of samples of a `<sensor>`.
pub(super) fn sensor(context: &Context<'_>, id: NodeId) -> Result<(Camera, FilmSettings, Option<u32>), SceneError> {
    let props = Props::new(context.document, id)?;
    let film = match props.object("film")? {
        Some(film) => self::film(context, film)?,
        None => FilmSettings { width: WIDTH as usize, height: HEIGHT as usize, filter: gaussian() },
    };
    let samples = match props.object("sampler")? {
        Some(sampler) => self::sampler(context, sampler)?,
        None => None,
    };
    let to_world = props.transform("to_world")?.unwrap_or(DAffine3::IDENTITY);
    // Clipping planes hide what is too near or too far; there are none here.
    props.no_effect(&["near_clip", "far_clip", "shutter_open", "shutter_close"]);
    let aspect = film.width as f64 / film.height as f64;
    let projection = match props.node.kind.as_str() {
        "perspective" => {
            props.no_effect(&["focus_distance"]);
            Projection::Perspective { tan_half_x: tan_half_x(&props, aspect)? }
        }
        "thinlens" => {
            let radius = props.required_positive("aperture_radius")?;
            let focus = props.required_positive("focus_distance")?;
            Projection::ThinLens { tan_half_x: tan_half_x(&props, aspect)?, radius, focus }
        }
        "orthographic" => {
            props.no_effect(&["focus_distance"]);
            Projection::Orthographic
        }
        _ => return Err(props.unknown_kind(&["perspective", "thinlens", "orthographic"])),
    };
    check_camera(&props, &to_world, projection)?;
    for name in ["principal_point_offset_x", "principal_point_offset_y"] {
        if props.float(name, 0.0)? != 0.0 {
            let error = props.unsupported(name, format!("`{name}`"), "0");
            context.notes.unsupported(error, "the axis stays in the middle")?;
        }
    }
    props.finish(context.notes)?;
    Ok((Camera { to_world, projection }, film, samples))
}

/// A lens must not be squeezed; an orthographic camera may be.
fn check_camera(props: &Props<'_>, to_world: &DAffine3, projection: Projection) -> Result<(), SceneError> {
    let m = to_world.matrix3;
    let (gram, rigid) = (m.transpose() * m, projection != Projection::Orthographic);
    // 1e-3: exporters write matrices with five digits.
    let close = |value: f64, wanted: f64| (value - wanted).abs() <= 1e-3;
    let unit = (0..3).all(|c| close(gram.col(c)[c], 1.0));
    let upright = (0..3).all(|c| {
        let (a, b) = (m.col(c), m.col((c + 1) % 3));
        close(a.dot(b) / (a.length() * b.length()), 0.0)
    });
    if upright && (unit || !rigid) {
        return Ok(());
    }
    let allowed = if rigid { "a rotation and a translation" } else { "rotations, scales along the axes, translations" };
    Err(props.bad("to_world", "a map that distorts", allowed))
}

fn tan_half_x(props: &Props<'_>, aspect: f64) -> Result<f64, SceneError> {
    let axes = ["x", "y", "diagonal", "smaller", "larger"];
    let focal = props.string("focal_length")?;
    let (fov, axis) = match (props.optional_float("fov")?, focal) {
        (Some(fov), None) => (fov.to_radians(), props.word("fov_axis", &axes)?),
        (Some(_), Some(focal)) => return Err(props.bad("focal_length", focal, "either fov or focal_length")),
        (None, focal) => {
            // As on film of 36 mm × 24 mm.
            let focal = focal.unwrap_or("50mm");
            let length = super::props::number(focal.strip_suffix("mm").unwrap_or(focal).trim());
            let length = length.filter(|mm| *mm > 0.0);
            let length = length.ok_or_else(|| props.bad("focal_length", focal, "a length in mm, such as 50mm"))?;
            props.no_effect(&["fov_axis"]);
            (2.0 * (36.0_f64.hypot(24.0) / (2.0 * length)).atan(), "diagonal")
        }
    };
    if !(fov > 0.0 && fov < std::f64::consts::PI) {
        return Err(props.bad("fov", &fov.to_degrees().to_string(), "a number of degrees in (0, 180)"));
    }
    let tan = (0.5 * fov).tan();
    let horizontal = match axis {
        "x" => true,
        "y" => false,
        "smaller" => aspect <= 1.0,
        "larger" => aspect > 1.0,
        _ => return Ok(tan * aspect / aspect.hypot(1.0)),
    };
    Ok(if horizontal { tan } else { (0.5 * horizontal_fov(fov, aspect)).tan() })
}

/// The size of Mitsuba's images where none is given.
const WIDTH: i64 = 768;
const HEIGHT: i64 = 576;

/// Mitsuba's filter where none is given.
fn gaussian() -> Filter {
    Filter::gaussian(0.5, 2.0).expect("a good filter")
}

fn film(context: &Context<'_>, id: NodeId) -> Result<FilmSettings, SceneError> {
    let props = Props::new(context.document, id)?;
    if !["hdrfilm", "ldrfilm", "mfilm"].contains(&props.node.kind.as_str()) {
        context.notes.unsupported(props.unknown_kind(&["hdrfilm", "ldrfilm", "mfilm"]), "it is read as hdrfilm")?;
    }
    let size = |name: &'static str, default: i64| match props.optional_integer(name)?.unwrap_or(default) {
        n if (1..=LARGEST).contains(&n) => Ok(n),
        n => Err(props.bad(name, &n.to_string(), &format!("a number of pixels in 1 to {LARGEST}"))),
    };
    let (width, height) = (size("width", WIDTH)?, size("height", HEIGHT)?);
    let crop = ["crop_width", "crop_height", "crop_offset_x", "crop_offset_y"];
    let whole = [width, height, 0, 0];
    for (name, whole) in crop.into_iter().zip(whole) {
        if props.optional_integer(name)?.is_some_and(|n| n != whole) {
            let error = props.unsupported(name, format!("`{name}`"), "an image without a crop");
            context.notes.unsupported(error, "the whole image is computed")?;
        }
    }
    let filter = match props.object("rfilter")? {
        Some(filter) => self::filter(context, filter)?,
        None => gaussian(),
    };
    // How the image is stored is the command line's to say.
    props.no_effect(&["file_format", "pixel_format", "component_format", "banner", "gamma", "exposure"]);
    props.no_effect(&["attach_log", "sample_border", "high_quality_edges", "tonemap_method", "compensate", "variable"]);
    props.finish(context.notes)?;
    Ok(FilmSettings { width: width as usize, height: height as usize, filter })
}

fn filter(context: &Context<'_>, id: NodeId) -> Result<Filter, SceneError> {
    let props = Props::new(context.document, id)?;
    let filter = match props.node.kind.as_str() {
        "box" => Ok(Filter::BOX),
        "tent" => Filter::tent(props.float("radius", 1.0)?),
        "gaussian" => {
            let stddev = props.float("stddev", 0.5)?;
            Filter::gaussian(stddev, 4.0 * stddev)
        }
        "mitchell" => {
            let third = 1.0 / 3.0;
            Filter::mitchell(props.float("b", third)?, props.float("c", third)?)
        }
        "catmullrom" => Filter::mitchell(0.0, 0.5),
        "lanczos" => {
            let lobes = props.optional_integer("lobes")?.unwrap_or(3);
            Filter::lanczos(lobes.clamp(0, u32::MAX.into()) as u32)
        }
        _ => {
            let error = props.unknown_kind(&["box", "tent", "gaussian", "mitchell", "catmullrom", "lanczos"]);
            context.notes.unsupported(error, "a Gaussian takes its place")?;
            return Ok(gaussian());
        }
    };
    let filter = filter.map_err(|error| SceneError::Malformed {
        place: props.place(),
        problem: error.problem(),
        allowed: KNOWN.into(),
    })?;
    props.finish(context.notes)?;
    Ok(filter)
}

/// The number of samples per pixel. How they are drawn is the command line's to say: every sampler has the same mean.
pub(super) fn sampler(context: &Context<'_>, id: NodeId) -> Result<Option<u32>, SceneError> {
    let props = Props::new(context.document, id)?;
    let samples = match props.optional_integer("sample_count")? {
        None => None,
        Some(n) => match u32::try_from(n) {
            Ok(n) if n > 0 => Some(n),
            _ => return Err(props.bad("sample_count", &n.to_string(), "a whole number in 1 to 4294967295")),
        },
    };
    props.no_effect(&["seed", "dimension", "scramble", "jitter", "strength", "wavefront_size"]);
    props.finish(context.notes)?;
    Ok(samples)
}

/// The number of reflections and of those before roulette.
pub(super) fn integrator(context: &Context<'_>, id: NodeId, depth: usize) -> Result<RenderSettings, SceneError> {
    const KNOWN: [&str; 6] = ["path", "volpath", "direct", "moment", "aov", "volpathmis"];
    let props = Props::new(context.document, id)?;
    props.check_depth(depth)?;
    let mut settings = RenderSettings::default();
    match props.node.kind.as_str() {
        "moment" | "aov" => {
            // Further images beside the picture.
            props.no_effect(&["aovs"]);
            match props.object("integrator")? {
                Some(inner) => settings = integrator(context, inner, depth + 1)?,
                None => return Err(props.missing("an <integrator>", "the one that makes the picture")),
            }
        }
        "direct" => {
            settings.bounces = Some(Some(1));
            props.no_effect(&["shading_samples", "emitter_samples", "bsdf_samples"]);
        }
        kind => {
            if !KNOWN.contains(&kind) {
                let error = props.unknown_kind(&KNOWN);
                context.notes.unsupported(error, "it is read as `path`, which has the same mean if it is unbiased")?;
            }
            settings.bounces = match props.optional_integer("max_depth")? {
                None | Some(-1) => Some(None),
                Some(n) => match u32::try_from(n - 1) {
                    Ok(bounces) => Some(Some(bounces)),
                    Err(_) => return Err(props.bad("max_depth", &n.to_string(), "-1 for no limit, or 1 and more")),
                },
            };
            settings.roulette_from = match props.optional_integer("rr_depth")? {
                None => None,
                Some(n) => match u32::try_from(n) {
                    Ok(n) if n > 0 => Some(n),
                    _ => return Err(props.bad("rr_depth", &n.to_string(), "a whole number in 1 to 4294967295")),
                },
            };
        }
    }
    if props.boolean("hide_emitters", false)? {
        let error = props.unsupported("hide_emitters", "`hide_emitters`", "false: lights are seen");
        context.notes.unsupported(error, "lights are seen")?;
    }
    // Of normals that point away from the geometry.
    props.no_effect(&["strict_normals"]);
    props.finish(context.notes)?;
    Ok(settings)
}
