/// Claims of the pages, in their order.
const CLAIMS: &[Claim] = &[
    Claim {
        page: "README.md",
        words: "no pixel of coverage differs, colours differ by at most 1/255 (textured 2/255)",
        holds: |r| {
            let own = "largest error against its definition, 1/255";
            let textured = ["nearest", "bilinear", "mipmap", "trilinear"].map(|f| r.largest("textures", f, own));
            no_gaps(r)
                && r.largest("shading", "phong", "largest error, 1/255") <= 1.0
                && r.largest("threads", "plain path, 1 thread", "largest error at compared pixels, 1/255") <= 1.0
                && textured.iter().all(|e| *e <= 2.0)
        },
    },
    Claim {
        page: PAGE,
        words: "u16, u24, u32, f32, reversed, as drawn, near to far 10 to 10^7",
        holds: |r| {
            let formats = ["u16", "u24", "u32", "f32", "reversed"];
            r.subjects("depth").len() == 7 && formats.iter().all(|f| r.of("depth", f).count() == 7)
        },
    },
    Claim {
        page: PAGE,
        words: "as asked, affine, painter, depth formats; `LINE`, `LINEAA`; fibres and fans",
        holds: |r| {
            let modes = ["as asked", "affine", "painter", "depth u16", "depth reversed"];
            modes.iter().all(|mode| r.of("pictures", mode).count() > 0)
                && ["LINE", "LINEAA", "exact fibres", "fan of 33 rays"].iter().all(|w| r.of("pictures", w).count() == 1)
        },
    },
    Claim {
        page: PAGE,
        words: "a teapot under one light, a shiny teapot under eight lights, Suzanne under eight lights, a textured room, columns of \
                few faces, a knot of 30,000 faces (4,000,000 in the full report), a page of lines, two tesseracts",
        holds: |r| {
            r.subjects("pictures")
                == [
                    "teapot",
                    "shiny teapot under 8 lights",
                    "Suzanne under 8 lights",
                    "textured room with two lights",
                    "columns of few faces under 8 lights",
                    "knot of 30000 faces",
                    "page of 200 lines",
                    "two tesseracts, 4-D on a plane",
                ]
        },
    },
    Claim {
        page: PAGE,
        words: "exact, fans of 3 to 129 rays",
        holds: |r| ["fan of 3 rays", "fan of 129 rays"].iter().all(|fan| r.of("fan", fan).count() > 0),
    },
    Claim {
        page: PAGE,
        words: "1 to 3 threads, for the pipeline and for the eye; 4, 8 and 16 lanes, for the pipeline",
        holds: |r| {
            // NEON and the portable path have 4 lanes, AVX2 8 and AVX-512 16.
            let levels = ["portable", "neon", "avx2", "avx512"];
            let of = |level: &str, t: &str| r.of("threads", &format!("{level} vectors, {t}")).count();
            let threads = ["1 thread", "2 threads", "3 threads"];
            threads.iter().all(|t| r.of("eye", t).count() == 2 && levels.iter().all(|level| of(level, t) == 1))
        },
    },
    Claim { page: PAGE, words: "the renderer leaves no gap and hits no pixel twice", holds: no_gaps },
    Claim {
        page: PAGE,
        words: "a pixel's u is that of its texel on a wall of 16,384 texels; affine interpolation is off by up to 200 of 256",
        holds: |r| {
            let off = "largest error, texels";
            let affine = r.largest("interpolation", "affine", off);
            r.largest("interpolation", "perspective", off) == 0.0 && (195.0..=200.0).contains(&affine)
        },
    },
    Claim {
        page: PAGE,
        words: "reversed f32 keeps separations at most half as large as f32 does, at every ratio of near to far from 10 to \
                10^7, and ten times finer ones from 10^3 on",
        holds: |r| {
            let kept = "smallest separation kept, part of d";
            let [reversed, f32] = ["reversed", "f32"].map(|format| r.errors("depth", format, kept));
            let ratios: Vec<f64> = f32.iter().zip(&reversed).map(|(a, b)| a / b).collect();
            ratios.len() == 7 && ratios.iter().all(|q| *q >= 2.0) && ratios[2..].iter().all(|q| *q >= 10.0)
        },
    },
    Claim {
        page: PAGE,
        words: "Every depth format keeps what theory says, to a factor of 2.5",
        holds: |r| {
            let formats = ["u16", "u24", "u32", "f32", "reversed"];
            formats.iter().all(|f| r.largest("depth", f, "measured / theory") <= 2.5)
        },
    },
    Claim {
        page: PAGE,
        words: "Gouraud shading of the ball is off by up to 27 steps of 255, flat by up to 54",
        holds: |r| {
            let largest = |shade| r.largest("shading", shade, "largest error, 1/255");
            (largest("gouraud"), largest("flat")) == (27.0, 54.0)
        },
    },
    Claim {
        page: PAGE,
        words: "mip-maps halve the error on a floor to the horizon, from 19.0 to 8.4 steps RMS",
        holds: |r| {
            let floor = |filter| r.errors("textures", filter, "RMSE against the box filter, 1/255")[0];
            format!("{:.1} {:.1}", floor("bilinear"), floor("mipmap")) == "19.0 8.4"
        },
    },
    Claim {
        page: PAGE,
        words: "the painter's algorithm shows 5 % of three bars in a cycle wrong, and the z-buffer nothing",
        holds: |r| {
            let part = |way| r.errors("hidden", way, "part of the drawn pixels");
            format!("{:.2}", part("painter, by centres")[0]) == "0.05" && part("z-buffer") == [0.0, 0.0]
        },
    },
    Claim {
        page: PAGE,
        words: "the exact fibre sees what rational numbers see, with 13 digits of the distance; of 64 pixels a fan of 33 rays \
                misses up to 11",
        holds: |r| {
            let exact = |column| r.largest("fan", "exact", column);
            let missed = r.largest("fan", "fan of 33 rays", "pixels that miss");
            exact("pixels that miss") + exact("pixels with another facet") == 0.0
                && exact("largest difference of distance") < 1e-13
                && missed == 11.0
        },
    },
];

fn no_gaps(r: &Report) -> bool {
    let of = |column| r.largest("coverage", "the renderer, 1/256 pixel", column);
    of("gaps") + of("double hits") == 0.0
}
