//! Image files that others wrote: every compression of one picture, references of published scenes, textures.
//!
//! They are read through WHITEFURNACE_DATA and never shipped; without them each test says so and passes. Means were
//! obtained with other programs.

mod real_data;

use std::path::Path;

use whitefurnace::image::{Image, Storage};

use real_data::data;

/// The image `name`; None, with a line, where the data is absent.
fn image(name: &str) -> Option<Image> {
    Some(Image::read(&data(name)?).unwrap_or_else(|error| panic!("{error}")))
}

fn mean(image: &Image) -> [f64; 3] {
    let pixels = image.pixels_rgb();
    [0, 1, 2].map(|c| pixels.iter().map(|p| f64::from(p[c])).sum::<f64>() / pixels.len() as f64)
}

#[track_caller]
fn close(actual: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for (a, e) in actual.iter().zip(expected) {
        assert!((a - e).abs() <= tolerance, "{actual:?}, expected {expected:?}");
    }
}

#[test]
fn every_compression_of_one_picture_agrees() {
    for (bits, storage) in [("f16", Storage::Half), ("f32", Storage::Float)] {
        let [a, b, c] = ["uncompressed", "zip", "piz"]
            .map(|compression| image(&format!("images/exr/compression/{bits}_{compression}.exr")));
        let (Some(a), Some(b), Some(c)) = (a, b, c) else { return };
        assert_eq!(a.storage(), storage);
        assert_eq!(a.names().collect::<Vec<_>>(), ["A", "B", "G", "R"]);
        for name in a.names() {
            assert!(a.plane(name).unwrap().iter().any(|v| *v != 0.0), "{name} is empty");
            assert_eq!(a.plane(name), b.plane(name), "{bits}, {name}");
            assert_eq!(a.plane(name), c.plane(name), "{bits}, {name}");
        }
    }
}

#[test]
fn half_and_single_precision_of_one_picture_agree() {
    let [Some(half), Some(single)] =
        ["f16", "f32"].map(|bits| image(&format!("images/exr/compression/{bits}_uncompressed.exr")))
    else {
        return;
    };
    for (h, s) in half.pixels_rgb().iter().flatten().zip(single.pixels_rgb().iter().flatten()) {
        let (h, s) = (f64::from(*h), f64::from(*s));
        assert!((h - s).abs() <= Storage::Half.rounding(s, s), "{s} became {h}");
    }
}

#[test]
fn references_of_published_scenes_have_their_means() {
    // The means are stated to six decimals.
    for (name, expected) in [
        ("scenes/bitterli/cornell-box/ref_tungsten.exr", [0.196251, 0.127531, 0.036100]),
        ("scenes/bitterli/cornell-box/ref_mitsuba3.exr", [0.196323, 0.127571, 0.036112]),
        ("scenes/bitterli/veach-mis/ref_tungsten.exr", [0.673052, 0.610719, 0.592461]),
    ] {
        let Some(image) = image(name) else { return };
        close(mean(&image), expected, 1e-6);
    }
}

#[test]
fn single_pixels_lie_where_they_should() {
    let Some(image) = image("scenes/ignis/references/ref-point-4096.exr") else { return };
    // albedo/π cos/d² within 1e-3 by the scene's description; an image upside down or mirrored would miss it by far.
    // Row 200, column 128; the file holds half floats.
    close(image.rgb(128, 200).map(f64::from), [0.06906, 0.05448, 0.05196], 1e-4);
    assert_eq!(image.rgb(200, 128), [0.0; 3], "the transposed pixel is black, so the two cannot be confused");
}

#[test]
fn a_furnace_reads_one_half() {
    let Some(image) = image("scenes/osl/furnace-diffuse/ref/out.exr") else { return };
    // All but one pixel are exact, by another reader too.
    let off: Vec<f32> = image.pixels_rgb().into_iter().flatten().filter(|v| *v != 0.5).collect();
    assert_eq!(off, [0.498_779_3; 3]);
}

#[test]
fn textures() {
    let Some(wood) = image("scenes/mitsuba/common/textures/wood.jpg") else { return };
    assert!(wood.is_srgb_encoded() && wood.width() > 100);
    assert_eq!((wood.width(), wood.height()), (2048, 1571));
    // libjpeg's means, by Pillow; decoders may differ by a step of 1/255 in a pixel, and by much less in the mean.
    close(mean(&wood), [0.596_48, 0.555_59, 0.531_04], 5e-4);
    let noise = image("scenes/mitsuba/common/textures/noise_8x8.png").unwrap();
    assert_eq!((noise.width(), noise.height(), noise.storage()), (8, 8, Storage::Srgb16));
    assert!(image("scenes/mitsuba/common/textures/leaf_mask.png").unwrap().has_colour());
    let museum = image("scenes/mitsuba/common/textures/museum.exr").unwrap();
    assert!(!museum.is_srgb_encoded() && mean(&museum).iter().all(|v| *v > 0.0));
}

#[test]
fn radiance_pictures() {
    let Some(fish) = image("images/hdr/radiance_mirror_fish.hdr") else { return };
    assert_eq!((fish.width(), fish.height(), fish.storage()), (128, 124, Storage::Rgbe));
    assert_eq!(fish.metadata()["EXPOSURE"], "8.000000e+00");
    assert!(mean(&fish).iter().all(|v| *v > 0.01 && *v < 100.0), "{:?}", mean(&fish));
    assert_eq!(image("images/hdr/radiance_glass_def.hdr").unwrap().storage(), Storage::Rgbe);
}

#[test]
fn colours_are_told_from_the_other_planes() {
    let Some(multi) = image("images/exr/spot_multi.exr") else { return };
    let value = |name: &str| multi.plane(name).unwrap()[10 * multi.width() + 20];
    assert_eq!(multi.rgb(20, 10), ["R", "G", "B"].map(value));
    assert_ne!(value("_arg_0.X"), value("R"));
    assert!(multi.plane("m2__arg_0.Z").is_some() && multi.alpha().unwrap().iter().all(|a| *a == 1.0));
}

#[test]
fn real_files_cut_short_are_errors() {
    for name in [
        "images/exr/compression/f16_piz.exr",
        "images/exr/compression/f32_zip.exr",
        "images/exr/spot_multi.exr",
        "images/hdr/radiance_glass_def.hdr",
        "scenes/mitsuba/common/textures/wood.jpg",
        "scenes/mitsuba/common/textures/leaf_mask.png",
    ] {
        let Some(path) = data(name) else { return };
        let bytes = std::fs::read(path).expect("a readable file");
        for tenths in 0..10 {
            let cut = &bytes[..bytes.len() * tenths / 10];
            let text = Image::decode(cut, Path::new(name)).expect_err("half a file is no file").to_string();
            assert!(text.starts_with(name) && text.lines().count() == 1, "{text}");
        }
    }
}
