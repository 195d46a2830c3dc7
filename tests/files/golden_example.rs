#[test]
fn a_circle_in_a_box() {
    let mut fb = fbptr::Framebuffer::new(64, 64).unwrap();
    fb.rect([8, 8, 48, 48], [255, 255, 255, 255]).unwrap();
    fb.fill_circle([32.0, 32.0], 20.0, [255, 128, 0, 255]).unwrap();
    fb.text([12, 28], "hello", [0, 0, 0, 255]);
    fb.assert_golden("tests/golden/circle.png");
}
