//! A fountain of particles; the mouse moves its source while a button is held.

struct Particle {
    place: [f64; 2],
    speed: [f64; 2],
    age: f64,
}

fn main() -> Result<(), fbptr::WindowError> {
    let (mut particles, mut seed, mut source) = (Vec::<Particle>::new(), 7_u32, [240.0, 300.0]);
    let mut random = move || {
        seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        f64::from(seed >> 8) / f64::from(1 << 24)
    };
    fbptr::run(480, 360, move |fb, input| {
        if input.buttons[0] {
            source = input.mouse.map(f64::from);
        }
        for _ in 0..12 {
            let speed = [120.0 * (random() - 0.5), -220.0 - 90.0 * random()];
            particles.push(Particle { place: source, speed, age: 0.0 });
        }
        particles.retain(|p| p.age < 2.5 && p.place[1] < 360.0);
        fb.clear([8, 10, 22, 255]);
        for p in &mut particles {
            p.age += input.delta_s;
            p.speed[1] += 200.0 * input.delta_s;
            for axis in 0..2 {
                p.place[axis] += p.speed[axis] * input.delta_s;
            }
            let heat = 1.0 - p.age / 2.5;
            let color = [80.0 + 175.0 * heat, 120.0 + 110.0 * heat, 255.0].map(|c| c as u8);
            fb.fill_circle(p.place, 1.0 + 2.0 * heat, [color[0], color[1], color[2], 255]).expect("a radius");
        }
        input.close |= input.is_down("escape");
    })
}
