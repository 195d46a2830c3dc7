//! A paint program: the left button draws, the wheel sets the width, 1 to 8 the colour, C clears.

const COLORS: [[u8; 3]; 8] = [
    [0, 0, 0],
    [220, 50, 47],
    [255, 160, 0],
    [240, 220, 60],
    [60, 170, 70],
    [38, 139, 210],
    [130, 80, 200],
    [255; 3],
];

fn main() -> Result<(), fbptr::WindowError> {
    let (mut color, mut width, mut last) = (5, 6.0_f64, None);
    fbptr::run(480, 360, move |fb, input| {
        if input.frame == 0 || input.was_pressed("c") {
            fb.clear([250, 248, 240, 255]);
        }
        if let Some(key) = (0..8).find(|key| input.was_pressed(&(key + 1).to_string())) {
            color = key;
        }
        width = (width + f64::from(input.wheel[1])).clamp(1.0, 60.0);
        let at = input.mouse.map(f64::from);
        if input.buttons[0] && at[1] < 340.0 {
            let [r, g, b] = COLORS[color];
            fb.wide_line(last.unwrap_or(at), at, width, [r, g, b, 255]).expect("a width");
        } else if input.buttons[0] && at[1] >= 340.0 {
            color = (at[0] / 60.0).clamp(0.0, 7.0) as usize;
        }
        last = input.buttons[0].then_some(at);
        for (i, [r, g, b]) in COLORS.into_iter().enumerate() {
            let [x, high] = [i as f64 * 60.0, if i == color { 20.0 } else { 12.0 }];
            fb.fill_rect([x, 340.0, 60.0, 20.0], [200, 196, 188, 255]).expect("a size");
            fb.fill_rect([x + 1.0, 360.0 - high, 58.0, high], [r, g, b, 255]).expect("a size");
        }
        input.close |= input.is_down("escape");
    })
}
