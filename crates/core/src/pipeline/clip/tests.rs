use super::*;
use crate::pipeline::golden;
use proptest::prelude::*;

/// x, y, z, h, followed by the varyings.
fn vertex(v: &serde_json::Value) -> ClipVertex<3> {
    let v: Vec<f64> = v.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect();
    ClipVertex {
        pos_clip: DVec4::new(v[0], v[1], v[2], v[3]),
        varyings: std::array::from_fn(|i| v.get(4 + i).copied().unwrap_or(0.0)),
    }
}

fn close(a: &ClipVertex<3>, b: &ClipVertex<3>, tolerance: f64) -> bool {
    (a.pos_clip - b.pos_clip).abs().max_element() <= tolerance
        && a.varyings.iter().zip(b.varyings).all(|(a, b)| (a - b).abs() <= tolerance)
}

fn ndc_area(ring: &[ClipVertex<3>]) -> f64 {
    let p: Vec<_> = ring.iter().map(|v| v.pos_clip / v.pos_clip.w).collect();
    (0..p.len()).map(|i| p[i].x * p[(i + 1) % p.len()].y - p[(i + 1) % p.len()].x * p[i].y).sum::<f64>() / 2.0
}

#[test]
fn golden_polygons() {
    let golden = golden("seed000_homogeneous_clipping");
    let tolerance = golden["tolerance"]["absolute"].as_f64().unwrap();
    let inputs = golden["inputs"]["polygons"].as_array().unwrap();
    let expected = golden["expected"]["polygons"].as_array().unwrap();
    assert!(inputs.len() >= 11);
    for (input, expected) in inputs.iter().zip(expected) {
        let name = expected["name"].as_str().unwrap();
        let polygon: Vec<_> = input["vertices"].as_array().unwrap().iter().map(vertex).collect();
        let found = clip_polygon(&polygon);
        let wanted: Vec<_> = expected["polygon"].as_array().unwrap().iter().map(vertex).collect();
        assert_eq!(found.len(), wanted.len(), "{name}: {found:?}");
        let matches = |shift: usize| {
            (0..wanted.len()).all(|i| close(&found[(i + shift) % found.len()], &wanted[i], tolerance))
        };
        assert!(wanted.is_empty() || (0..wanted.len()).any(matches), "{name}: {found:?}");
        assert!((ndc_area(&found) - expected["ndc_area"].as_f64().unwrap()).abs() < tolerance, "{name}");
    }
}

#[test]
fn golden_lines() {
    let golden = golden("seed000_homogeneous_clipping");
    let tolerance = golden["tolerance"]["absolute"].as_f64().unwrap();
    let expected = golden["expected"]["lines"].as_array().unwrap();
    assert!(expected.len() >= 6);
    for line in expected {
        let (a, b) = (vertex(&line["a"]), vertex(&line["b"]));
        let found = clip_line(a, b).unwrap();
        for (i, (t, p)) in [("t", "p0"), ("t", "p1")].into_iter().enumerate() {
            assert!((found.t[i] - line[t][i].as_f64().unwrap()).abs() <= tolerance, "{line}");
            assert!(close(&found.ends[i], &vertex(&line[p]), tolerance), "{line}");
        }
        let back = clip_line(b, a).unwrap();
        assert_eq!([back.ends[1], back.ends[0]], found.ends);
    }
}

#[test]
fn what_is_nowhere_gives_nothing() {
    let at = |x, y, z, w| ClipVertex::<0> { pos_clip: DVec4::new(x, y, z, w), varyings: [] };
    assert!(clip_polygon(&[at(0.0, 0.0, 0.0, 0.0); 3]).is_empty());
    assert!(clip_polygon(&[at(f64::NAN, 0.0, 0.0, 1.0); 3]).is_empty());
    assert!(clip_polygon::<0>(&[]).is_empty());
    assert!(clip_line(at(0.0, 0.0, 0.0, 0.0), at(0.0, 0.0, 0.0, 0.0)).is_none());
    assert!(clip_line(at(0.0, 0.0, f64::INFINITY, 1.0), at(0.0, 0.0, 0.5, 1.0)).is_none());
}

fn any_vertex() -> impl Strategy<Value = ClipVertex<3>> {
    (prop::array::uniform4(-5.0f64..5.0), prop::array::uniform3(0.0f64..1.0))
        .prop_map(|(p, varyings)| ClipVertex { pos_clip: DVec4::from_array(p), varyings })
}

proptest! {
    // Many random inputs lie entirely outside and test nothing.
    #![proptest_config(ProptestConfig { max_global_rejects: 20_000, ..ProptestConfig::default() })]

    #[test]
    fn all_of_a_polygon_that_comes_out_is_inside(p in prop::array::uniform3(any_vertex())) {
        let ring = clip_polygon(&p);
        prop_assume!(!ring.is_empty());
        for v in ring {
            prop_assert!((0..6).all(|plane| distance(plane, v.pos_clip) >= -1e-12), "{v:?}");
            prop_assert!(v.varyings.iter().all(|v| (-1e-12..=1.0 + 1e-12).contains(v)));
        }
    }

    #[test]
    fn all_of_a_line_that_comes_out_is_inside(a in any_vertex(), b in any_vertex()) {
        let line = clip_line(a, b);
        prop_assume!(line.is_some());
        let ends = line.expect("some of it is inside").ends;
        prop_assert!(ends.iter().all(|v| (0..6).all(|plane| distance(plane, v.pos_clip) >= -1e-12)));
    }

    /// Two faces share the edge ab in opposite directions: both get the same bits from it.
    #[test]
    fn new_vertices_on_a_shared_edge_are_the_same(p in prop::array::uniform4(any_vertex())) {
        let [a, b, c, d] = p;
        let (one, other) = (clip_polygon(&[a, b, c]), clip_polygon(&[b, a, d]));
        // Varyings of a point on the edge lie on the segment from a's to b's, so none comes from c
        // or d.
        let mark = |v: ClipVertex<3>, m: f64| ClipVertex { varyings: [m, v.varyings[1], v.varyings[2]], ..v };
        let ring = clip_polygon(&[mark(a, 0.0), mark(b, 0.0), mark(c, 1.0)]);
        let on_edge: Vec<usize> = (0..ring.len()).filter(|&i| ring[i].varyings[0] == 0.0).collect();
        prop_assume!(one.len() == ring.len() && on_edge.len() == 2 && !other.is_empty());
        let ring2 = clip_polygon(&[mark(b, 0.0), mark(a, 0.0), mark(d, 1.0)]);
        let theirs: Vec<_> = ring2.iter().filter(|v| v.varyings[0] == 0.0).map(|v| v.pos_clip).collect();
        for i in on_edge {
            prop_assert!(theirs.contains(&ring[i].pos_clip), "{:?} is not among {theirs:?}", ring[i]);
        }
    }
}
