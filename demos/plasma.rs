//! Plasma: sums of waves through a palette, written into the bytes of the memory.

fn main() -> Result<(), fbptr::WindowError> {
    let wave = |x: f64| (x.sin() * 0.5 + 0.5) * 255.0;
    let palette: Vec<[u8; 4]> = (0..256)
        .map(|i| f64::from(i) / 256.0 * std::f64::consts::TAU)
        .map(|a| [wave(a) as u8, wave(a + 2.1) as u8, wave(a + 4.2) as u8, 255])
        .collect();
    let table: Vec<i32> = (0..1024)
        .map(|i| (f64::from(i) * std::f64::consts::TAU / 256.0).sin() * 64.0)
        .map(|s| s as i32)
        .collect();
    let mut time = 0.0;
    fbptr::run(320, 240, move |fb, input| {
        time += input.delta_s * 60.0;
        let t = time as usize;
        let width = 320 * 4;
        for (y, row) in fb.memory_mut().bytes_mut().chunks_exact_mut(width).enumerate() {
            let by_row = table[(y * 2 + t) % 256] + table[(y + 3 * t) % 256];
            for (x, pixel) in row.as_chunks_mut::<4>().0.iter_mut().enumerate() {
                let sum = by_row + table[(x + 2 * t) % 256] + table[(x + y + t) % 256];
                *pixel = palette[(sum + t as i32).rem_euclid(256) as usize];
            }
        }
        input.close |= input.is_down("escape");
    })
}
