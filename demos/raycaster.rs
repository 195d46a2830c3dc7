//! A maze seen from inside: a ray a column, walls as high as they are near. The arrows walk and turn.

const MAP: [&[u8; 12]; 10] = [
    b"############",
    b"#....#.....#",
    b"#.##.#.###.#",
    b"#.#......#.#",
    b"#.#.####.#.#",
    b"#...#..#...#",
    b"###.#..#.###",
    b"#..........#",
    b"#.##.##.##.#",
    b"############",
];

fn is_wall(x: f64, y: f64) -> bool {
    MAP[y as usize][x as usize] == b'#'
}

fn main() -> Result<(), fbptr::WindowError> {
    let (mut eye, mut angle) = ([1.5, 1.5], 0.6_f64);
    fbptr::run(320, 200, move |fb, input| {
        let held = |key: &str| f64::from(u8::from(input.is_down(key)));
        angle += 2.2 * input.delta_s * (held("right") - held("left"));
        let step = 2.0 * input.delta_s * (held("up") - held("down"));
        let to = [eye[0] + step * angle.cos(), eye[1] + step * angle.sin()];
        if !is_wall(to[0], eye[1]) {
            eye[0] = to[0];
        }
        if !is_wall(eye[0], to[1]) {
            eye[1] = to[1];
        }
        fb.fill_rect([0.0, 0.0, 320.0, 100.0], [60, 70, 100, 255]).expect("a size");
        fb.fill_rect([0.0, 100.0, 320.0, 100.0], [70, 60, 50, 255]).expect("a size");
        for column in 0..320 {
            let ray = angle + ((f64::from(column) - 159.5) / 280.0).atan();
            let (sin, cos) = ray.sin_cos();
            let mut away = 0.0;
            while !is_wall(eye[0] + away * cos, eye[1] + away * sin) {
                away += 0.01;
            }
            let high = (200.0 / (away * (ray - angle).cos())).min(200.0);
            let side = (eye[0] + away * cos).fract().min(1.0 - (eye[0] + away * cos).fract()) < 0.011;
            let light = (if side { 220.0 } else { 160.0 } / (1.0 + 0.25 * away)) as u8;
            let color = [light, light / 5 * 4, light / 2, 255];
            fb.fill_rect([f64::from(column), 100.0 - high / 2.0, 1.0, high], color).expect("a size");
        }
        input.close |= input.is_down("escape");
    })
}
