//! Pong for two: W and S, and the arrows up and down.

const SIZE: [f64; 2] = [320.0, 240.0];
const WHITE: [u8; 4] = [255; 4];

fn main() -> Result<(), fbptr::WindowError> {
    let (mut ball, mut speed) = ([160.0, 120.0], [-140.0, 90.0]);
    let (mut paddles, mut score) = ([100.0; 2], [0, 0]);
    fbptr::run(SIZE[0] as u32, SIZE[1] as u32, move |fb, input| {
        for (paddle, [up, down]) in paddles.iter_mut().zip([["w", "s"], ["up", "down"]]) {
            let way = f64::from(i8::from(input.is_down(down)) - i8::from(input.is_down(up)));
            *paddle = (*paddle + way * 180.0 * input.delta_s).clamp(0.0, SIZE[1] - 40.0);
        }
        for axis in 0..2 {
            ball[axis] += speed[axis] * input.delta_s;
        }
        if ball[1] < 4.0 || ball[1] > SIZE[1] - 4.0 {
            ball[1] = ball[1].clamp(4.0, SIZE[1] - 4.0);
            speed[1] = -speed[1];
        }
        let side = usize::from(speed[0] > 0.0);
        let is_near = [ball[0] < 16.0, ball[0] > SIZE[0] - 16.0][side];
        if is_near && (paddles[side]..paddles[side] + 40.0).contains(&ball[1]) {
            speed = [-1.05 * speed[0], speed[1] + 3.0 * (ball[1] - paddles[side] - 20.0)];
        } else if ball[0] < 0.0 || ball[0] > SIZE[0] {
            score[1 - side] += 1;
            (ball, speed) = ([160.0, 120.0], [-140.0 * speed[0].signum(), 90.0]);
        }
        fb.clear([16, 32, 24, 255]);
        for y in (4..240).step_by(16) {
            fb.fill_rect([159.0, f64::from(y), 2.0, 8.0], [90, 110, 100, 255]).expect("a size");
        }
        fb.text([140, 8], &format!("{} : {}", score[0], score[1]), WHITE);
        for (x, y) in [8.0, SIZE[0] - 16.0].into_iter().zip(paddles) {
            fb.fill_rect([x, y, 8.0, 40.0], WHITE).expect("a size");
        }
        fb.fill_circle(ball, 4.5, [255, 215, 0, 255]).expect("a radius");
        input.close |= input.is_down("escape");
    })
}
