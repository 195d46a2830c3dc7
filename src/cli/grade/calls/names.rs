//! Names that students give to functions and numbers, in English and Portuguese.
//!
//! In: a name, and the names beside it. Out: the figure that a function draws, or what a number means.
//! Right is: a name that may mean two things means neither.

/// A figure: the command's name, its points, and names of functions without case and `_`.
pub struct Figure {
    pub verb: &'static str,
    pub points: usize,
    pub names: &'static [&'static str],
}

pub const FIGURES: [Figure; 4] = [
    Figure {
        verb: "PX",
        points: 1,
        names: &[
            "putpixel",
            "drawpixel",
            "setpixel",
            "plotpixel",
            "writepixel",
            "desenhapixel",
            "desenharpixel",
            "pintapixel",
            "pintarpixel",
            "drawpoint",
        ],
    },
    Figure {
        verb: "LINE",
        points: 2,
        names: &[
            "drawline",
            "putline",
            "desenhalinha",
            "desenharlinha",
            "tracalinha",
            "rasterizeline",
            "rasterline",
            "drawlinebresenham",
            "bresenham",
            "line",
            "linha",
            "desenhareta",
            "desenharreta",
        ],
    },
    Figure {
        verb: "TRI",
        points: 3,
        names: &[
            "drawtriangle",
            "drawtriangles",
            "puttriangle",
            "desenhatriangulo",
            "desenhartriangulo",
            "triangle",
            "triangulo",
        ],
    },
    Figure {
        verb: "FILL",
        points: 3,
        names: &[
            "drawfilledtriangle",
            "drawtrianglefilled",
            "drawtrianglefill",
            "drawfilltriangle",
            "filltriangle",
            "filledtriangle",
            "preenchertriangulo",
            "preenchetriangulo",
            "desenhatriangulopreenchido",
            "rasterizetriangle",
        ],
    },
];

/// Meaning of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    X,
    Y,
    Red,
    Green,
    Blue,
    Alpha,
    /// A switch between outlined and filled triangles.
    Filled,
    /// A depth, which is 0.
    Zero,
    /// A thickness or a fourth coordinate, which is 1.
    One,
    Other,
}

/// Number of roles.
pub const ROLES: usize = Role::Other as usize + 1;

/// Notation of coordinates that the names of all numbers have together.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Notation {
    /// Rows are named, so `col` is a column and no colour.
    has_rows: bool,
    /// Lines and columns are `l` and `c`.
    has_letters: bool,
    /// `i` and `j` are among the names, of which either may be the row.
    pub has_indices: bool,
    /// Red, green and blue are named, so `b` is no point.
    pub has_channels: bool,
}

/// Returns a name in small letters without `_` and the digits at its end.
fn base(name: &str) -> String {
    let name = name.to_ascii_lowercase().replace('_', "");
    name.trim_end_matches(|c: char| c.is_ascii_digit()).to_owned()
}

fn is_row(name: &str) -> bool {
    name == "lin"
        || name.starts_with("row")
        || name.ends_with("row")
        || (name.contains("linha") && !is_color(name))
}

impl Notation {
    /// Returns the notation of some names.
    pub fn of<'a>(names: impl Iterator<Item = &'a str>) -> Notation {
        let names: Vec<String> = names.map(base).collect();
        let has = |wanted: Role| names.iter().any(|name| role(name, Notation::default()) == wanted);
        let count = |name: &str| names.iter().filter(|other| *other == name).count();
        let has_x = names.iter().any(|name| name.starts_with('x') || name.ends_with('x'));
        Notation {
            has_rows: names.iter().any(|name| is_row(name)),
            has_letters: !has_x && count("l") > 0 && count("l") == count("c"),
            has_channels: has(Role::Red) && has(Role::Green) && has(Role::Blue),
            has_indices: count("i") > 0 && count("j") > 0,
        }
    }
}

/// Returns whether a name is that of a colour.
pub fn is_color(name: &str) -> bool {
    let name = base(name);
    ["cor", "col", "rgb", "argb", "bgr", "pixel"].iter().any(|word| name.contains(word))
        && !["coord", "corner", "coluna", "column"].iter().any(|word| name.contains(word))
}

/// Returns whether a name is that of several things.
pub fn is_plural(name: &str) -> bool {
    let name = base(name);
    name.ends_with('s') && !name.ends_with("pos")
}

/// Returns the meaning that a name has.
pub fn role(name: &str, notation: Notation) -> Role {
    let name = &*base(name);
    let begins = |words: &[&str]| words.iter().any(|word| name.starts_with(word));
    let ends = |words: &[&str]| words.iter().any(|word| name.ends_with(word));
    let is_column = name.contains("coluna") || name.contains("column");
    if begins(&["fill", "preench", "isfill"]) {
        return Role::Filled;
    }
    match name {
        _ if is_row(name) || (notation.has_letters && name == "l") => Role::Y,
        _ if is_column || (notation.has_letters && name == "c") => Role::X,
        _ if notation.has_rows && (begins(&["col"]) || ends(&["col"])) && !begins(&["colo"]) => Role::X,
        _ if begins(&["red", "verm", "rcomp"]) || ends(&["red", "vermelho"]) || name == "r" => Role::Red,
        _ if begins(&["green", "verd", "gcomp"]) || ends(&["green", "verde"]) || name == "g" => Role::Green,
        _ if begins(&["blue", "azul", "bcomp"]) || ends(&["blue", "azul"]) || name == "b" => Role::Blue,
        _ if begins(&["alpha", "alfa", "acomp"]) || ends(&["alpha", "alfa"]) || name == "a" => Role::Alpha,
        _ if begins(&["x"]) || ends(&["x"]) => Role::X,
        _ if begins(&["y"]) || ends(&["y"]) => Role::Y,
        // Short names as mr and cg.
        _ if name.len() == 2 && ends(&["r"]) => Role::Red,
        _ if name.len() == 2 && ends(&["g"]) => Role::Green,
        _ if name.len() == 2 && ends(&["b"]) => Role::Blue,
        _ if name.len() == 2 && ends(&["a"]) => Role::Alpha,
        "z" | "depth" | "prof" | "profundidade" | "pz" => Role::Zero,
        "w" | "pw" | "thickness" | "espessura" | "largura" | "linewidth" => Role::One,
        _ => Role::Other,
    }
}

/// Returns the places of red, green, blue and alpha in a colour that is one number, from the lowest
/// bit on, and the form that is told: after its name, or the order of the bytes in memory.
pub fn packed(name: &str) -> ([u32; 4], &'static str) {
    match base(name) {
        name if name.contains("argb") => ([16, 8, 0, 24], "0xAARRGGBB"),
        name if name.contains("bgra") => ([8, 16, 24, 0], "0xBBGGRRAA"),
        name if name.contains("rgba") => ([24, 16, 8, 0], "0xRRGGBBAA"),
        name if name.contains("rgb") || name.contains("hex") => ([16, 8, 0, 24], "0xAARRGGBB"),
        _ => ([0, 8, 16, 24], "0xAABBGGRR"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_mean_what_they_mean_beside_the_others() {
        let of = |names: &str| {
            let notation = Notation::of(names.split(' '));
            names.split(' ').map(|name| role(name, notation)).collect::<Vec<_>>()
        };
        use Role::{Blue, Green, Other, Red, X, Y};
        assert_eq!(of("x0 posY red g_comp azul"), [X, Y, Red, Green, Blue]);
        assert_eq!(of("linha coluna cor"), [Y, X, Other]);
        assert_eq!(of("l1 c1 l2 c2"), [Y, X, Y, X]);
        assert_eq!(of("x y c l"), [X, Y, Other, Other]);
        assert_eq!(of("row col color"), [Y, X, Other]);
        assert_eq!(of("x y col"), [X, Y, Other]);
        assert!(is_color("corLinha") && is_color("pixelColor") && !is_color("coords") && !is_color("coluna"));
        assert_eq!(packed("cor").1, "0xAABBGGRR");
        assert!(Notation::of("i j".split(' ')).has_indices && !Notation::of("i x".split(' ')).has_indices);
    }
}
