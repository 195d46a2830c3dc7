//! Tests of the reference against the worked numbers of the sources (tests/data/golden).

mod pictures;
mod views;

use super::double_double::{DoubleDouble, DoubleDouble4};
use fbptr_core::scene::{LookAt, Viewport, ViewportRule};
use glam::DVec3;
use serde_json::Value;

fn golden(name: &str) -> Value {
    let path = format!("{}/../../tests/data/golden/{name}.json", env!("CARGO_MANIFEST_DIR"));
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn number(v: &Value) -> f64 {
    v.as_f64().unwrap_or_else(|| panic!("not a number: {v}"))
}

fn numbers(v: &Value) -> Vec<f64> {
    v.as_array().unwrap_or_else(|| panic!("not a list: {v}")).iter().map(number).collect()
}

fn vector(v: &Value) -> DVec3 {
    DVec3::from_slice(&numbers(v))
}

fn near(found: f64, expected: &Value, tolerance: f64) {
    let expected = number(expected);
    let off = (found - expected).abs();
    assert!(off <= tolerance * expected.abs().max(1.0), "found {found}, expected {expected}");
}

fn all_near(found: &[f64], expected: &Value, tolerance: f64) {
    let expected = expected.as_array().unwrap();
    assert_eq!(found.len(), expected.len());
    found.iter().zip(expected).for_each(|(f, e)| near(*f, e, tolerance));
}

fn point4(v: &Value) -> DoubleDouble4 {
    let n = numbers(v);
    [n[0], n[1], n[2], n.get(3).copied().unwrap_or(1.0)].map(DoubleDouble::new)
}

fn narrow(p: DoubleDouble4) -> [f64; 4] {
    p.map(DoubleDouble::to_f64)
}

fn corners_viewport(width: u32, height: u32) -> Viewport {
    Viewport { x: 0, y: 0, width, height, rule: ViewportRule::Corners }
}

fn look_at(eye: &Value, reference: &Value, up: &Value) -> LookAt {
    LookAt { eye: vector(eye), reference: vector(reference), up: vector(up) }
}
