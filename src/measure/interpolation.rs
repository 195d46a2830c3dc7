//! Interpolation of texture coordinates along rows of a wall in perspective.

use super::experiment::{Bound, Effort, Experiment, Row};

/// Experiment on interpolation.
pub(super) const INTERPOLATION: Experiment = Experiment {
    id: "interpolation",
    title: "Interpolation",
    about: "A wall whose distance grows from 1 to the given factor across the frame; u runs over 256 texels. Error in texels \
            against the exact quotient in f64, and of the colour of a texture of smooth waves, 32 texels long.",
    columns: &["largest error, texels", "RMSE, texels", "colour RMSE, 1/255"],
    plotted: 1,
    unit: "pixel",
    rows,
};

/// Wall on a frame `width` pixels wide: 1/w and u/w are linear along a row.
#[derive(Clone, Copy)]
struct Wall {
    width: usize,
    rows: usize,
    /// Distance at the right end; 1 at the left end.
    far: f64,
}

const TEXELS: f64 = 256.0;

impl Wall {
    /// Returns the position 0..1 of pixel x along row y; rows are offset against each other.
    fn t(self, x: usize, y: usize) -> f64 {
        (x as f64 + 0.5 + 0.37 * (y as f64 / self.rows as f64)) / (self.width as f64 + 1.0)
    }

    /// Returns 1/w and u/w at t.
    fn over_w(self, t: f64) -> (f64, f64) {
        let (near, far) = (1.0, 1.0 / self.far);
        (near * (1.0 - t) + far * t, TEXELS * far * t)
    }
}

type Fill = fn(Wall, usize, &mut [f64]);

fn exact(wall: Wall, y: usize, row: &mut [f64]) {
    for (x, u) in row.iter_mut().enumerate() {
        let (w, uw) = wall.over_w(wall.t(x, y));
        *u = uw / w;
    }
}

/// Interpolates with f32 increments along the row.
fn exact_f32(wall: Wall, y: usize, row: &mut [f64]) {
    let at = |x: usize| {
        let (w, uw) = wall.over_w(wall.t(x, y));
        (w as f32, uw as f32)
    };
    let (mut now, next) = (at(0), at(1));
    let step = (next.0 - now.0, next.1 - now.1);
    for u in row.iter_mut() {
        *u = (now.1 / now.0) as f64;
        now = (now.0 + step.0, now.1 + step.1);
    }
}

/// Divides every N pixels, with linear interpolation between.
fn every<const N: usize>(wall: Wall, y: usize, row: &mut [f64]) {
    let at = |x: usize| {
        let (w, uw) = wall.over_w(wall.t(x, y));
        uw / w
    };
    for (k, run) in row.chunks_mut(N).enumerate() {
        let (a, b) = (at(k * N), at(k * N + run.len()));
        let step = (b - a) / run.len() as f64;
        for (i, u) in run.iter_mut().enumerate() {
            *u = a + step * i as f64;
        }
    }
}

fn affine(wall: Wall, y: usize, row: &mut [f64]) {
    for (x, u) in row.iter_mut().enumerate() {
        *u = TEXELS * wall.t(x, y);
    }
}

fn rows(effort: &Effort) -> Vec<Row> {
    let (width, lines) = effort.pick((256, 64), (1920, 256));
    let mut rows = Vec::new();
    for far in [2.0, 8.0, 64.0] {
        let wall = Wall { width, rows: lines, far };
        let mut truth = vec![0.0; width * lines];
        truth.chunks_mut(width).enumerate().for_each(|(y, row)| exact(wall, y, row));
        // Error of linear pieces of length h in t: h^2/8 max |u''|, u'' = 2 T f (1-f) / w^3,
        // largest at w = f = 1/far.
        let bent = |n: f64| {
            let h = n / (width as f64 + 1.0);
            h * h / 8.0 * 2.0 * TEXELS * far * (far - 1.0)
        };
        // Each addition in f32 loses up to half an ulp, which is multiplied by `far` at the far
        // end.
        let drift = width as f64 * TEXELS * far / 16_777_216.0;
        let ways: [(&str, Fill, bool, f64); 5] = [
            ("perspective, exact f64", exact, true, 0.0),
            ("perspective, f32 increments", exact_f32, false, drift),
            ("perspective every 8 pixels", every::<8>, false, bent(8.0)),
            ("perspective every 16 pixels", every::<16>, false, bent(16.0)),
            ("affine", affine, false, TEXELS),
        ];
        for (name, fill, is_default, at_most) in ways {
            let draw = || {
                let mut picture = vec![0.0; width * lines];
                picture.chunks_mut(width).enumerate().for_each(|(y, row)| fill(wall, y, row));
                picture
            };
            let (picture, timing) = effort.run(draw);
            let wave = |u: f64| 127.5 * (1.0 + libm::sin(u * std::f64::consts::TAU / 32.0));
            let (mut max, mut squares, mut colors) = (0f64, 0f64, 0f64);
            for (u, t) in picture.iter().zip(&truth) {
                let (off, color) = (u - t, wave(*u) - wave(*t));
                max = max.max(off.abs());
                squares += off * off;
                colors += color * color;
            }
            let n = picture.len() as f64;
            rows.push(Row {
                subject: format!("distance 1 to {far}"),
                alternative: name.into(),
                is_default,
                errors: vec![max, (squares / n).sqrt(), (colors / n).sqrt()],
                bounds: vec![Bound { column: 0, at_most }],
                is_run: true,
                timing,
                work: n,
                picture: None,
            });
        }
    }
    rows
}
