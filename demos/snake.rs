//! Snake: the arrows turn it; it grows with each apple, and begins again where it bites itself.

use std::collections::VecDeque;

const CELLS: [i32; 2] = [32, 24];
const SIDE: i32 = 10;

fn main() -> Result<(), fbptr::WindowError> {
    let start = || VecDeque::from([[8_i32, 12], [7, 12], [6, 12]]);
    let (mut snake, mut way, mut next) = (start(), [1, 0], [1, 0]);
    let (mut apple, mut seed, mut time) = ([20, 12], 1_u32, 0.0);
    fbptr::run(320, 240, move |fb, input| {
        for (key, to) in [("up", [0, -1]), ("down", [0, 1]), ("left", [-1, 0]), ("right", [1, 0])] {
            if input.was_pressed(key) && to != [-way[0], -way[1]] {
                next = to;
            }
        }
        time += input.delta_s;
        if time > 0.12 {
            (time, way) = (0.0, next);
            let head = [0, 1].map(|axis| (snake[0][axis] + way[axis]).rem_euclid(CELLS[axis]));
            if snake.contains(&head) {
                (snake, way, next) = (start(), [1, 0], [1, 0]);
            } else {
                snake.push_front(head);
                if head == apple {
                    seed = seed.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    apple = [(seed >> 8) as i32 % CELLS[0], (seed >> 16) as i32 % CELLS[1]];
                } else {
                    snake.pop_back();
                }
            }
        }
        fb.clear([20, 24, 32, 255]);
        let mut cell = |[x, y]: [i32; 2], color: [u8; 4]| {
            let at = [x * SIDE + 1, y * SIDE + 1, SIDE - 2, SIDE - 2].map(f64::from);
            fb.fill_rect(at, color).expect("a size");
        };
        cell(apple, [220, 60, 50, 255]);
        for (i, part) in snake.iter().enumerate() {
            cell(*part, if i == 0 { [180, 240, 120, 255] } else { [80, 180, 90, 255] });
        }
        fb.text([4, 4], &format!("{}", snake.len()), [200, 200, 200, 255]);
        input.close |= input.is_down("escape");
    })
}
