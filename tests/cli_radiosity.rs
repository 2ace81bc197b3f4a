//! `radiosity`, `view-factors` and `render --method radiosity` as their users meet them.

mod program;

use program::{refused, stdout};
use serde_json::Value;

fn succeeds(args: &[&str]) -> String {
    stdout(args, 0)
}

fn json(args: &[&str]) -> Value {
    serde_json::from_str(&succeeds(args)).expect("JSON")
}

#[test]
fn the_solution_is_in_the_format_that_other_programs_read() {
    for method in ["dense", "jacobi", "gauss-seidel", "cg", "southwell"] {
        let found = json(&["radiosity", "cube-one-emitter", "--patches", "6", "--method", method, "--json", "-"]);
        assert_eq!((&found["schema"], &found["patches"]), (&1.into(), &6.into()));
        assert_eq!(found["method"], method);
        assert!(found["iterations"].as_u64().unwrap() > 0 && found["converged"] == true, "{found}");
        let surfaces = found["surfaces"].as_array().unwrap();
        let names: Vec<&str> = surfaces.iter().map(|s| s["name"].as_str().unwrap()).collect();
        assert_eq!(names, ["bottom", "top", "left", "right", "front", "back"]);
        // Section 2.4's values for one patch a face, to nine decimals.
        for (i, b) in [(0, 1.090909098), (1, 0.181745826), (2, 0.181836269)] {
            assert!((surfaces[i]["B"][0].as_f64().unwrap() - b).abs() < 2e-9, "{method}: {found}");
            // B = E + ρ H with ρ = ½.
            let emitted = if i == 0 { 1.0 } else { 0.0 };
            let h = surfaces[i]["H"][2].as_f64().unwrap();
            assert!((emitted + 0.5 * h - b).abs() < 2e-9 && surfaces[i]["area"] == 1.0);
        }
        let energy = |key: &str| found["energy"][key].as_f64().unwrap();
        assert!((energy("emitted") - 1.0).abs() < 1e-12);
        assert!((energy("emitted") - energy("absorbed") - energy("escaped")).abs() < 1e-6);
        assert!(found["residual"].as_f64().unwrap() <= found["certified_bound"].as_f64().unwrap());
        assert!(found["seconds"]["solve"].as_f64().unwrap() >= 0.0 && found.get("per_patch").is_none());
    }
    let patches = json(&["radiosity", "cube-one-emitter", "--patches", "24", "--json", "-", "--per-patch"]);
    assert_eq!(patches["per_patch"].as_array().unwrap().len(), 24);
}

#[test]
fn a_number_of_reflections_is_exact() {
    // After one reflection: half the view factors.
    let found = json(&["radiosity", "cube-one-emitter", "--patches", "6", "--bounces", "1", "--json", "-"]);
    assert_eq!(found["method"], "jacobi");
    assert!((found["surfaces"][1]["B"][0].as_f64().unwrap() - 0.0999124478).abs() < 1e-9);
    refused(
        &["radiosity", "cube-one-emitter", "--patches", "6", "--bounces", "1", "--method", "cg"],
        &["cg", "jacobi"],
    );
}

#[test]
fn hierarchical_states_its_links_and_its_error() {
    let args = ["radiosity", "cube-one-emitter", "--method", "hierarchical", "--patches", "600", "--error", "0.003"];
    let found = json(&[&args[..], &["--json", "-"]].concat());
    assert_eq!((&found["method"], &found["converged"]), (&"hierarchical".into(), &true.into()));
    let hierarchy = &found["hierarchy"];
    let estimate = hierarchy["estimated_error"].as_f64().unwrap();
    assert!(estimate > 0.0 && estimate <= 0.003, "{hierarchy}");
    let links = hierarchy["links"].as_u64().unwrap();
    assert!(links > 600 && links < 600 * 600 / 3, "{links} links");
    assert_eq!(hierarchy["links_by_level"].as_array().unwrap().iter().filter_map(Value::as_u64).sum::<u64>(), links);
    assert!(found.get("view_factors").is_none());
    // Means of the continuous solution; 0.3 % of what is reflected, .22 on the whole, and the size of the patches.
    for (i, b) in [(0, 1.104362), (1, 0.171216), (2, 0.181106)] {
        let mean = found["surfaces"][i]["B"][0].as_f64().unwrap();
        assert!((mean - b).abs() < 2e-3, "{mean} against {b}");
    }
    // What one reflection brings is exact whatever came before it.
    let one = json(&[&args[..], &["--bounces", "1", "--json", "-"]].concat());
    assert_eq!(one["iterations"], 1);
    // Within .3 % of what is reflected, .22.
    let top = &one["surfaces"][1];
    assert!((top["B"][0].as_f64().unwrap() - 0.0999124478).abs() < 1e-3);
    // H is what arrives from that B, as jacobi has it.
    let jacobi = json(&["radiosity", "cube-one-emitter", "--patches", "600", "--bounces", "1", "--json", "-"]);
    let by_matrix = jacobi["surfaces"][1]["H"][0].as_f64().unwrap();
    assert!((top["H"][0].as_f64().unwrap() / by_matrix - 1.0).abs() < 0.01, "{top} against {by_matrix}");
    let text = succeeds(&args);
    assert!(text.contains("links (all pairs: 360000)") && text.contains("estimated error"), "{text}");
}

#[test]
fn what_a_method_does_not_heed_is_refused() {
    let hierarchical = ["radiosity", "cube-one-emitter", "--method", "hierarchical"];
    refused(&[&hierarchical[..], &["--view-factors", "hemicube"]].concat(), &["--view-factors", "hierarchical"]);
    refused(&[&hierarchical[..], &["--adaptive"]].concat(), &["--adaptive"]);
    refused(&[&hierarchical[..], &["--error", "2"]].concat(), &["below 1"]);
    refused(
        &[&hierarchical[..], &["--error", "1e-6", "--max-memory", "1"]].concat(),
        &["links", "MiB", "larger error"],
    );
    refused(&["radiosity", "cube-one-emitter", "--error", "0.1"], &["--error", "gauss-seidel"]);
    refused(&["radiosity", "cube-one-emitter", "--method", "gauss"], &["southwell", "hierarchical"]);
}

#[test]
fn view_factors_are_printed_in_three_forms() {
    let args = ["view-factors", "cube-one-emitter", "--method", "rectangles", "--patches", "6"];
    let text = succeeds(&args);
    for needle in ["0.199824896", "0.200043776", "row sums", "reciprocity", "escape", "what is in between is ignored"] {
        assert!(text.contains(needle), "{needle}: {text}");
    }
    let found = json(&[&args[..], &["--json"]].concat());
    assert!((found["rows"][0][1].as_f64().unwrap() - 0.199824895698387).abs() < 1e-14, "{found}");
    assert_eq!(found["row_sums"].as_array().unwrap().len(), 6);
    let csv = succeeds(&[&args[..], &["--csv"]].concat());
    assert!(csv.starts_with("from,to,from_surface,to_surface,from_area,F\n0,1,bottom,top,"), "{csv}");
    assert_eq!(csv.lines().count(), 1 + 6 * 5);
    let rays =
        ["view-factors", "cube-one-emitter", "--method", "monte-carlo", "--patches", "6", "--enforce", "closure"];
    assert!(succeeds(&rays).contains("enforced: changed by"));
}

#[test]
fn a_solution_is_rendered() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name).to_str().unwrap().to_string();
    let (direct, by_render) = (path("a.pfm"), path("b.pfm"));
    succeeds(&["radiosity", "cornell-original", "--patches", "60", "-o", &direct, "--size", "16x16", "--spp", "4"]);
    let args = ["render", "cornell-original", "--method", "radiosity", "--patches", "60", "--size", "16x16"];
    succeeds(&[&args[..], &["--spp", "4", "-o", &by_render, "--quiet"]].concat());
    assert_eq!(std::fs::read(direct).unwrap(), std::fs::read(by_render).unwrap(), "one picture, two commands");
}

#[test]
fn bad_input_is_one_clear_line() {
    refused(&["radiosity", "veach-mis"], &["not diffuse", "smooth"]);
    refused(&["radiosity", "furnace-box", "--param", "rho=1"], &["below 1", "wall"]);
    refused(&["radiosity", "cornell-original", "--patches", "0"], &["--patches"]);
    refused(&["radiosity", "cornell-original", "--patches", "20000"], &["MiB", "Fewer patches"]);
    refused(&["radiosity", "cornell-original", "--tol", "0"], &["--tol"]);
    refused(&["view-factors", "furnace-sphere", "--method", "contour"], &["curved", "monte-carlo"]);
    refused(&["view-factors", "cornell-original", "--method", "rectangles"], &["rectangles"]);
}
