use std::collections::BTreeMap;
use std::path::Path;

use vitrine_exhibit::plan::Plan;

use super::*;
use crate::config::{PlanPairs, parse};
use crate::optics::LampPair;

const WICKED: &str = "</script><script>alert(1)</script>\"'&<b>";

fn exhibit(name: &str) -> Exhibit {
    let views: String = [("left", -30), ("middle", 0), ("right", 30)]
        .map(|(id, angle)| {
            format!("[[view]]\nid = \"{id}\"\npattern = \"photos/cat.jpg\"\nhorizontal_deg = {angle}\n")
        })
        .concat();
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("exhibit.toml");
    let name = toml::Value::from(name);
    parse(&here, &format!("[exhibit]\nname = {name}\n[stack]\nfilms = 2\npixels = 8\n{views}")).unwrap()
}

/// A plan of three views at -30, 0 and 30 degrees: top lamp, both, bottom lamp.
pub(super) fn plan_of_three() -> Plan {
    plan(&exhibit("Three"))
}

fn plan(exhibit: &Exhibit) -> Plan {
    let views = vec![LampPair::TOP, LampPair::FULL, LampPair::BOTTOM];
    let pairs = PlanPairs { views, neutral: LampPair::FULL, shared: Vec::new() };
    exhibit.plan(&pairs, [0; 32]).unwrap()
}

fn report(exhibit: &Exhibit) -> Report {
    let figures = serde_json::json!({
        "gain": 1.0, "psnr_db": 20.0, "ssim": 0.8, "efficiency": 0.4, "contrast": 10.0, "cross_talk": 0.1
    });
    let views: Vec<serde_json::Value> = exhibit.views.iter().map(|view| serde_json::json!({
        "id": view.id, "horizontal_deg": view.horizontal_deg, "vertical_deg": 0.0, "distance_mm": null,
        "emphasis": { "top": 1.0, "bottom": 0.5 }, "white": 0.4, "hold": { "wanted_h": 1.0, "held_h": 1.0 },
        "quality": figures, "under_own_lamps": figures, "under_neutral_lamps": figures, "under_full_lamps": figures,
    })).collect();
    serde_json::from_value(serde_json::json!({
        "name": exhibit.name, "vitrine": "0", "mean_psnr_db": 20.0, "least_psnr_db": 20.0, "mean_ssim": 0.8,
        "least_ssim": 0.8, "neutral": { "top": 1.0, "bottom": 1.0 }, "shared": [], "views": views,
    }))
    .unwrap()
}

fn page_of(exhibit: &Exhibit, manifest: &Manifest) -> String {
    let picture = || ViewPictures { given: None, pattern: vec![1], shown: vec![2], error: vec![3] };
    page(&PageParts {
        exhibit,
        report: &report(exhibit),
        plan: &plan(exhibit),
        pictures: &[picture(), picture(), picture()],
        films: &[&[4], &[5]],
        manifest,
    })
}

#[test]
fn no_name_can_break_out_into_the_page() {
    let exhibit = exhibit(WICKED);
    let mut manifest = Manifest::new(&exhibit, 8);
    manifest.exhibit.views[0].pattern = Some(WICKED.into());
    manifest.inputs = BTreeMap::from([(WICKED.to_owned(), "00".to_owned())]);
    manifest.outputs = BTreeMap::from([(format!("views/{WICKED}.png"), "00".to_owned())]);
    let page = page_of(&exhibit, &manifest);
    assert!(page.contains("&lt;/script&gt;&lt;script&gt;alert(1)"));
    assert_eq!(page.matches("<script").count(), 1 + viewer::SCRIPTS.len());
    assert_eq!(page.matches("</script").count(), 1 + viewer::SCRIPTS.len());
    assert!(!page.contains("&<b>") && !page.contains("alert(1)<"));
}

#[test]
fn the_page_asks_for_nothing_and_names_its_scripts_by_their_hashes() {
    let exhibit = exhibit("Three");
    let page = page_of(&exhibit, &Manifest::new(&exhibit, 8));
    for forbidden in ["http://", "https://", "url(", " style=", " onclick"] {
        assert!(!page.contains(forbidden), "{forbidden}");
    }
    assert!(page.contains("default-src 'none'") && !page.contains("unsafe-inline"));
    assert_eq!(page.matches("sha256-").count(), 1 + viewer::SCRIPTS.len());
}

#[test]
fn many_pairs_for_two_viewers_are_folded_and_few_are_not() {
    let exhibit = exhibit("Three");
    let shown = |pairs: usize| {
        let mut report = report(&exhibit);
        let pair = |number: usize| serde_json::json!({ "views": [format!("one-{number}"), "two"], "pair": { "top": 1.0, "bottom": 0.25 } });
        report.shared = (0..pairs).map(|number| serde_json::from_value(pair(number)).unwrap()).collect();
        tables::lamps(&report).into_string()
    };
    let last = |pairs: usize| format!("one-{} and two", pairs - 1);
    let few = shown(15);
    assert!(few.contains(&last(15)) && !few.contains("<details"), "{few}");
    let many = shown(16);
    let (before, folded) = many.split_once("<details>").unwrap();
    assert!(folded.starts_with("<summary>The 16 pairs for two viewers at once</summary>"), "{folded}");
    let (folded, _) = folded.split_once("</details>").unwrap();
    assert!(folded.contains(&last(16)) && !before.contains("and two"), "{many}");
    assert!(!shown(0).contains("two viewers"));
}
