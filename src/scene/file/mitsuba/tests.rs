//! What Mitsuba files mean.

use glam::{DAffine3, DVec2, DVec3};

use crate::math::color::Rgb;
use crate::sampling::filter::Filter;
use crate::scene::camera::Projection;
use crate::scene::description::SceneDescription;
use crate::scene::file::testing::Files;
use crate::scene::file::{LoadOptions, load};
use crate::scene::light::Light;
use crate::scene::shape::Geometry;

/// A scene with a camera and `body`, which starts on line 2.
pub(super) fn scene(body: &str) -> String {
    format!(
        "<scene version=\"3.0.0\"><sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/></sensor>\n{body}</scene>"
    )
}

fn read(body: &str) -> SceneDescription {
    let files = Files::new().with("s.xml", scene(body));
    let loaded = files.load("s.xml").unwrap();
    assert_eq!(loaded.warnings, [""; 0]);
    loaded.scene
}

/// The error for `body`, without the name of the file.
pub(super) fn error(body: &str) -> String {
    let error = Files::new().with("s.xml", scene(body)).error("s.xml");
    error.strip_prefix("s.xml: ").unwrap_or(&error).to_string()
}

fn near(a: DVec3, b: DVec3) -> bool {
    (a - b).length() <= 1e-12 * b.length().max(1.0)
}

#[test]
fn transforms_apply_in_order() {
    let steps = "<scale x=\"2\"/><rotate z=\"1\" angle=\"90\"/><translate value=\"1, 2 3\"/>";
    let scene = read(&format!("<shape type=\"rectangle\"><transform name=\"to_world\">{steps}</transform></shape>"));
    let Geometry::Rectangle { to_world } = scene.shapes[0].geometry else { panic!("{:?}", scene.shapes) };
    assert!(near(to_world.transform_point3(DVec3::X), DVec3::new(1.0, 4.0, 3.0)), "{to_world}");
    let matrix = "<matrix value=\"0 0 2 5  1 0 0 6  0 3 0 7  0 0 0 1\"/>";
    let scene = read(&format!("<shape type=\"cube\"><transform name=\"to_world\">{matrix}</transform></shape>"));
    let Geometry::Cube { to_world } = scene.shapes[0].geometry else { panic!("{:?}", scene.shapes) };
    assert!(near(to_world.transform_point3(DVec3::new(1.0, 10.0, 100.0)), DVec3::new(205.0, 7.0, 37.0)));
}

#[test]
fn older_spelling_says_the_same() {
    let new = r#"<scene version="3.0.0">
        <integrator type="path"><integer name="max_depth" value="4"/></integrator>
        <sensor type="perspective"><string name="fov_axis" value="smaller"/><float name="fov" value="30"/>
          <transform name="to_world"><lookat origin="1,2,3" target="4,4,4" up="0,1,0"/></transform>
          <sampler type="independent"><integer name="sample_count" value="9"/></sampler>
          <film type="hdrfilm"><integer name="width" value="40"/><integer name="height" value="20"/></film></sensor>
        <shape type="sphere"><bsdf type="roughconductor"><float name="alpha_u" value="0.2"/>
          <rgb name="specular_reflectance" value="0.5"/></bsdf></shape></scene>"#;
    let mut old = new.replace("3.0.0", "0.6.0").replace("lookat", "lookAt");
    for (name, older) in [("max_depth", "maxDepth"), ("fov_axis", "fovAxis"), ("to_world", "toWorld")] {
        old = old.replace(name, older);
    }
    old = old.replace("sample_count", "sampleCount").replace("alpha_u", "alphaU");
    old = old.replace("specular_reflectance", "specularReflectance");
    let files = Files::new().with("new/s.xml", new).with("old/s.xml", old);
    let [new, old] = ["new/s.xml", "old/s.xml"].map(|name| files.load(name).unwrap().scene);
    assert_eq!(format!("{new:?}"), format!("{old:?}"));
    assert_eq!((new.render.bounces, new.render.samples), (Some(Some(3)), Some(9)));
    // The smaller side is y: tan 15° up, twice as much to the side.
    let Projection::Perspective { tan_half_x } = new.camera.projection else { panic!() };
    assert!((tan_half_x - 2.0 * 15_f64.to_radians().tan()).abs() < 1e-12);
}

#[test]
fn depths_count_reflections() {
    let bounces = |integrator: &str| read(integrator).render.bounces;
    let path =
        |depth: &str| format!("<integrator type=\"path\"><integer name=\"max_depth\" value=\"{depth}\"/></integrator>");
    assert_eq!(bounces(&path("1")), Some(Some(0)));
    assert_eq!(bounces(&path("-1")), Some(None));
    assert_eq!(bounces("<integrator type=\"path\"/>"), Some(None));
    assert_eq!(bounces("<integrator type=\"direct\"/>"), Some(Some(1)));
    assert_eq!(bounces(&format!("<integrator type=\"moment\">{}</integrator>", path("8"))), Some(Some(7)));
    assert_eq!(bounces(""), None);
    assert!(error(&path("0")).ends_with("allowed is -1 for no limit, or 1 and more"));
}

#[test]
fn a_camera_without_an_angle_has_a_lens_of_50_mm() {
    let files = Files::new().with("s.xml", "<scene version='3.0.0'><sensor type='perspective'/></scene>");
    let scene = files.load("s.xml").unwrap().scene;
    let Projection::Perspective { tan_half_x } = scene.camera.projection else { panic!() };
    // Mitsuba 3.9.1 says x_fov = 38.1848 for the same.
    assert!(((2.0 * tan_half_x.atan()).to_degrees() - 38.1848).abs() < 1e-4);
    assert_eq!((scene.film.width, scene.film.height), (768, 576));
    assert_eq!(scene.film.filter, Filter::gaussian(0.5, 2.0).unwrap());
}

#[test]
fn filters() {
    let load = |filter: &str| {
        let file = format!(
            "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='40'/>
             <film type='hdrfilm'>{filter}</film></sensor></scene>"
        );
        Files::new().with("s.xml", &file).load("s.xml")
    };
    for (xml, filter) in [
        ("<rfilter type='box'/>", Filter::BOX),
        ("<rfilter type='tent'/>", Filter::TENT),
        ("<rfilter type='tent'><float name='radius' value='1.5'/></rfilter>", Filter::tent(1.5).unwrap()),
        ("<rfilter type='gaussian'><float name='stddev' value='0.7'/></rfilter>", Filter::gaussian(0.7, 2.8).unwrap()),
        ("<rfilter type='catmullrom'/>", Filter::mitchell(0.0, 0.5).unwrap()),
        ("<rfilter type='lanczos'><integer name='lobes' value='2'/></rfilter>", Filter::lanczos(2).unwrap()),
    ] {
        assert_eq!(load(xml).unwrap().scene.film.filter, filter, "{xml}");
    }
    for (xml, problem) in [
        ("<rfilter type='tent'><float name='radius' value='-1'/></rfilter>", "the radius must be in (0, 16]"),
        ("<rfilter type='gaussian'><float name='stddev' value='9'/></rfilter>", "the radius must be in (0, 16]"),
        ("<rfilter type='lanczos'><integer name='lobes' value='-3'/></rfilter>", "lobes must be a whole number to 16"),
        ("<rfilter type='sinc'/>", "lanczos"),
    ] {
        let error = load(xml).unwrap_err().to_string();
        assert!(error.contains(problem) && error.contains("s.xml: line 2"), "{xml}: {error}");
    }
}

#[test]
fn lights() {
    let scene = read(
        "<emitter type='point'><point name='position' x='1' y='2'/><rgb name='intensity' value='3'/></emitter>
         <emitter type='spot'><float name='cutoff_angle' value='40'/><transform name='to_world'>
           <lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform></emitter>
         <emitter type='directional'><vector name='direction' value='0,-2,0'/></emitter>
         <emitter type='constant'/>",
    );
    let [point, spot, sun, constant] = scene.lights.as_slice() else { panic!("{:?}", scene.lights) };
    assert!(matches!(point, Light::Point { position, intensity }
        if *position == DVec3::new(1.0, 2.0, 0.0) && *intensity == Rgb::grey(3.0)));
    let Light::Spot { position, direction, beam, cutoff, .. } = spot else { panic!() };
    assert!(near(*position, DVec3::Z * 5.0) && near(*direction, -DVec3::Z));
    assert!((beam.to_degrees() - 30.0).abs() < 1e-12 && (cutoff.to_degrees() - 40.0).abs() < 1e-12);
    assert!(matches!(sun, Light::Directional { direction, .. } if near(*direction, -DVec3::Y)));
    assert!(matches!(constant, Light::Constant { radiance } if *radiance == Rgb::WHITE));
}

#[test]
fn includes_defaults_references_and_aliases() {
    let main = scene(
        "<default name='r' value='2'/><path value='more'/><include filename='part.xml'/>
         <alias id='a' as='b'/><shape type='sphere'><float name='radius' value='$r.5'/><ref id='b'/></shape>
         <shape type='disk'><ref name='whatever' id='a'/></shape>",
    );
    let part =
        "<scene version='3.0.0'><bsdf type='diffuse' id='a'><rgb name='reflectance' value='.1 .2 .3'/></bsdf></scene>";
    let files = Files::new().with("s.xml", main).with("more/part.xml", part);
    let scene = files.load("s.xml").unwrap().scene;
    assert!(matches!(scene.shapes[0].geometry, Geometry::Sphere { radius: 2.5, .. }));
    assert_eq!(scene.shapes[0].material, scene.shapes[1].material);
    assert_eq!(scene.materials[scene.shapes[0].material].lambertian(), Some(Rgb::new(0.1, 0.2, 0.3)));
    let given = |name: &str| {
        let params = vec![(name.to_string(), "3".to_string())];
        load(&files.path("s.xml"), &LoadOptions { params, lenient: false })
    };
    assert!(matches!(given("r").unwrap().scene.shapes[0].geometry, Geometry::Sphere { radius: 3.5, .. }));
    assert!(given("q").unwrap_err().to_string().ends_with("the parameter `q` is not supported; known are r"));
}

#[test]
fn textures_run_downwards() {
    // A picture of 1 × 2 pixels, red above green; Mitsuba's v = 0 is its upper edge.
    let pfm = b"PF\n1 2\n-1\n\x00\x00\x00\x00\x00\x00\x80\x3f\x00\x00\x00\x00\x00\x00\x80\x3f\x00\x00\x00\x00\x00\x00\x00\x00";
    let body = "<shape type='rectangle'><bsdf type='diffuse'><texture type='bitmap' name='reflectance'>
        <string name='filename' value='t.pfm'/><string name='filter_type' value='nearest'/></texture></bsdf></shape>";
    let files = Files::new().with("s.xml", scene(body)).with("t.pfm", pfm);
    let scene = files.load("s.xml").unwrap().scene;
    let material = &scene.materials[0];
    let f = |v| material.at(DVec2::new(0.5, v), Rgb::WHITE).eval(DVec3::Z, DVec3::Z);
    assert!(f(0.25).0.x > 0.3 && f(0.25).0.y == 0.0, "{}", f(0.25));
    assert!(f(0.75).0.y > 0.3 && f(0.75).0.x == 0.0, "{}", f(0.75));
}

#[test]
fn every_material_can_be_built() {
    let textured = "<texture type='checkerboard' name='specular_reflectance'/>";
    for bsdf in [
        "<bsdf type='conductor'><string name='material' value='Au'/></bsdf>".to_string(),
        format!("<bsdf type='roughconductor'>{textured}</bsdf>"),
        "<bsdf type='roughconductor'><texture type='checkerboard' name='alpha_u'/></bsdf>".into(),
        "<bsdf type='dielectric'><string name='int_ior' value='diamond'/></bsdf>".into(),
        "<bsdf type='thindielectric'><float name='int_ior' value='1.7'/></bsdf>".into(),
        "<bsdf type='roughdielectric'><string name='distribution' value='ggx'/></bsdf>".into(),
        "<bsdf type='plastic'><boolean name='nonlinear' value='true'/></bsdf>".into(),
        "<bsdf type='roughplastic'><texture type='checkerboard' name='diffuse_reflectance'/></bsdf>".into(),
        "<bsdf type='mask'><float name='opacity' value='.25'/><bsdf type='diffuse'/></bsdf>".into(),
        "<bsdf type='blendbsdf'><float name='weight' value='.3'/><bsdf type='diffuse'/><bsdf type='conductor'/></bsdf>"
            .into(),
        "<bsdf type='twosided'><bsdf type='phong'><float name='exponent' value='9'/></bsdf></bsdf>".into(),
        "<bsdf type='ward'><string name='variant' value='ward-duer'/></bsdf>".into(),
        "<bsdf type='null'/>".into(),
    ] {
        let scene = read(&format!("<shape type='sphere'>{bsdf}</shape>"));
        let material = scene.materials[0].at(DVec2::new(0.3, 0.3), Rgb::WHITE);
        let wo = DVec3::new(0.6, 0.0, 0.8);
        assert!(material.eval(wo, DVec3::new(-0.6, 0.0, 0.8)).is_finite(), "{bsdf}");
    }
}

#[test]
fn a_blend_is_the_weighted_sum() {
    let part = |rho: f64| format!("<bsdf type='diffuse'><rgb name='reflectance' value='{rho}'/></bsdf>");
    let body = format!(
        "<shape type='sphere'><bsdf type='blendbsdf'><float name='weight' value='.25'/>{}{}</bsdf></shape>",
        part(0.8),
        part(0.4)
    );
    let scene = read(&body);
    let f = scene.materials[0].at(DVec2::ZERO, Rgb::WHITE).eval(DVec3::Z, DVec3::Z);
    assert!((f.0.x * std::f64::consts::PI - (0.75 * 0.8 + 0.25 * 0.4)).abs() < 1e-14);
}

#[test]
fn what_shines_and_names_no_material_is_black() {
    let scene = read("<shape type='cube'/><shape type='cube'><emitter type='area'/></shape><shape type='cube'/>");
    let rho = |shape: usize| scene.materials[scene.shapes[shape].material].lambertian();
    assert_eq!([rho(0), rho(1), rho(2)], [0.5, 0.0, 0.5].map(|rho| Some(Rgb::grey(rho))));
}

#[test]
fn leniently_the_nearest_material_takes_its_place() {
    let body = "<shape type='cube'><bsdf type='bumpmap'><bsdf type='diffuse'><rgb name='reflectance' value='.25'/></bsdf></bsdf></shape>
        <shape type='cube'><bsdf type='principled'><rgb name='base_color' value='.75'/></bsdf></shape>";
    let loaded = Files::new().with("s.xml", scene(body)).lenient("s.xml").unwrap();
    assert_eq!(loaded.warnings.len(), 2, "{:?}", loaded.warnings);
    let rho: Vec<_> = loaded.scene.materials.iter().map(|material| material.lambertian().unwrap().0.x).collect();
    assert_eq!(rho, [0.25, 0.75]);
}

#[test]
fn instances_are_copies() {
    let body = "<shape type='shapegroup' id='g'><shape type='sphere'/><shape type='cube'/></shape>
        <shape type='instance'><ref id='g'/><transform name='to_world'><translate x='3'/></transform></shape>
        <shape type='instance'><ref id='g'/><transform name='to_world'><scale value='2'/></transform></shape>";
    let scene = read(body);
    assert_eq!(scene.shapes.len(), 4);
    assert!(matches!(scene.shapes[0].geometry, Geometry::Sphere { centre, radius: 1.0 } if centre == DVec3::X * 3.0));
    let Geometry::Cube { to_world } = scene.shapes[3].geometry else { panic!() };
    assert_eq!(to_world, DAffine3::from_scale(DVec3::splat(2.0)));
}

#[test]
fn a_textured_cube_has_its_coordinates() {
    let body =
        "<shape type='cube'><bsdf type='diffuse'><texture type='checkerboard' name='reflectance'/></bsdf></shape>";
    let scene = read(body);
    let Geometry::Mesh(mesh) = &scene.shapes[0].geometry else { panic!() };
    // Points and coordinates of Mitsuba 3.9.1, one on every face.
    for (p, uv) in [
        ((0.5, -0.2, 1.0), (0.4, 0.75)),
        ((1.0, 0.5, -0.2), (0.75, 0.6)),
        ((-1.0, 0.5, -0.2), (0.75, 0.4)),
        ((0.5, 1.0, -0.2), (0.25, 0.6)),
        ((0.5, -1.0, -0.2), (0.4, 0.75)),
        ((0.5, -0.2, -1.0), (0.6, 0.75)),
    ] {
        let (p, uv) = (DVec3::from(p), DVec2::from(uv));
        let found = mesh.triangles().iter().find_map(|corners| {
            let [a, b, c] = corners.map(|i| mesh.positions()[i as usize]);
            let n = (b - a).cross(c - a);
            let weights =
                [(b - p).cross(c - p), (c - p).cross(a - p), (a - p).cross(b - p)].map(|w| w.dot(n) / n.dot(n));
            let inside = weights.iter().all(|w| *w >= 0.0) && n.dot(p - a).abs() < 1e-12;
            assert!(n.dot(a) > 0.0, "outside is outside");
            inside.then(|| (0..3).map(|k| mesh.uvs()[corners[k] as usize] * weights[k]).sum::<DVec2>())
        });
        assert!((found.unwrap() - uv).length() < 1e-12, "{p}: {found:?}");
    }
}
