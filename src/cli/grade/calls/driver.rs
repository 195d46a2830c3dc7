//! Calls of a program's own functions, written from their declarations.
//!
//! In: declarations of all sources. Out: C or C++ that calls `PutPixel`, `DrawLine`, `DrawTriangle`
//! under the names that students give them, with points and colours in the order and in the records
//! that they chose; or the reason why a function is not understood. A parameter is a number, a record
//! of such, a pointer or reference to either, or an array of points, of colours, or of the numbers of
//! one. Names say what numbers mean ([`super::names`]); numbers without such names are x and y in
//! turn. Right is: a function is called only if all that it takes is understood, and if it takes all
//! points of its figure, and no colour or one or as many as points.

use super::names::{FIGURES, Figure, Notation, ROLES, Role, is_plural, role};
use super::source::{Declared, Function, Parameter};
use super::writer::Writer;
use std::fmt::Write;

/// A call of a function for a figure.
#[derive(Clone, Debug)]
pub struct Call {
    pub verb: &'static str,
    pub function: String,
    /// The function with its parameters, as a reader sees it, and what is assumed of them.
    pub shown: String,
    pub takes_color: bool,
    /// True if coordinates are whole numbers.
    pub takes_whole: bool,
    /// True if a parameter says that a triangle is filled.
    takes_switch: bool,
    /// Statements, in which `fbptr_p` are coordinates and `fbptr_c` colours.
    pub code: String,
}

/// Finds the function of a figure, the first that is understood: names in their order, and of one
/// name the one with most colours, rather a definition than a declaration.
///
/// # Errors
/// The reason why there is none.
pub fn call(declared: &Declared, figure: &Figure, is_cpp: bool) -> Result<Call, String> {
    let mut why = Vec::new();
    let mut found = |names: &[&str], wants_switch: bool| {
        names.iter().find_map(|name| {
            let plain = |other: &str| other.to_ascii_lowercase().replace('_', "") == **name;
            let mut found: Vec<(usize, bool, Call)> = Vec::new();
            for function in declared.functions.iter().filter(|f| plain(&f.name)) {
                match written(declared, figure, function, is_cpp) {
                    Ok((colors, call)) if call.takes_switch || !wants_switch => {
                        found.push((colors, function.body.is_some(), call));
                    }
                    Ok(_) => {}
                    Err(text) => why.push(format!("{}: {text}", shown(function))),
                }
            }
            let mut methods = declared.records.iter().filter(|r| r.methods.iter().any(|name| plain(name)));
            if let (Some(record), true) = (methods.next(), found.is_empty()) {
                let class = record.names.first().map_or("a class", |name| name);
                why.push(format!("a function of {class} is not called, only one outside of a class"));
            }
            found.sort_by_key(|(colors, is_whole, _)| (usize::MAX - colors, !is_whole));
            found.into_iter().next().map(|(_, _, call)| call)
        })
    };
    let own = found(figure.names, false);
    // One function for both kinds of triangles has a switch.
    let own = own.or_else(|| if figure.verb == "FILL" { found(FIGURES[2].names, true) } else { None });
    own.ok_or_else(|| match why.first() {
        Some(why) => format!("no function for {} is understood: {why}", figure.verb),
        None => format!("no function for {} is found", figure.verb),
    })
}

/// Returns a function with its parameters.
fn shown(function: &Function) -> String {
    let shown: Vec<String> = function.parameters.iter().map(show).collect();
    format!("{}({})", function.name, shown.join(", "))
}

/// Returns a parameter as it is declared.
fn show(parameter: &Parameter) -> String {
    let Parameter { kind, name, .. } = parameter;
    let (pointer, array) = ("*".repeat(parameter.pointers), "[]".repeat(parameter.arrays));
    format!("{kind} {pointer}{name}{array}").trim().to_owned()
}

/// Writes a call, and returns its number of colours.
fn written(
    declared: &Declared,
    figure: &Figure,
    function: &Function,
    is_cpp: bool,
) -> Result<(usize, Call), String> {
    if function.is_static {
        return Err("it is static in another file, so it cannot be called".to_owned());
    }
    let mut writer = Writer::new(declared, figure, is_cpp);
    // Names are collected first, as they explain each other; what fails here fails again.
    let _ = arguments(&mut writer, &function.parameters);
    let notation = Notation::of(writer.names.iter().map(String::as_str));
    let takes_unnamed = writer.names.iter().all(|name| role(name, notation) != Role::X);
    if takes_unnamed && notation.has_indices {
        return Err("which of i and j is the row is not said".to_owned());
    }
    writer.begin(notation, takes_unnamed);
    arguments(&mut writer, &function.parameters)?;
    let (x, red) = (count(&writer, Role::X), count(&writer, Role::Red));
    check(&writer, figure)?;
    writer.taken = [x, red];
    writer.begin(notation, takes_unnamed);
    let values = arguments(&mut writer, &function.parameters)?;
    let mut code = writer.code.clone();
    if !function.scope.is_empty() {
        code = format!("    using namespace {};\n{code}", function.scope);
    }
    let _ = writeln!(code, "    {}({});", function.name, values.join(", "));
    let colors = red + writer.held[Role::Red as usize];
    let notes: Vec<&str> = writer.notes.iter().map(String::as_str).collect();
    let notes = if notes.is_empty() { String::new() } else { format!(" [{}]", notes.join("; ")) };
    let call = Call {
        verb: figure.verb,
        function: function.name.clone(),
        shown: shown(function) + &notes,
        takes_color: colors > 0,
        takes_whole: writer.takes_whole,
        takes_switch: count(&writer, Role::Filled) > 0,
        code,
    };
    Ok((colors, call))
}

fn count(writer: &Writer<'_>, role: Role) -> usize {
    writer.count[role as usize]
}

/// Returns what is passed; parameters that have a value of their own, and are not understood, are
/// left out with those behind them.
fn arguments(writer: &mut Writer<'_>, parameters: &[Parameter]) -> Result<Vec<String>, String> {
    let mut values = Vec::new();
    for parameter in parameters {
        let before = writer.mark();
        match writer.whole_argument(parameter) {
            Ok(value) => values.push(value),
            Err(_) if parameter.has_default => {
                writer.reset(before);
                break;
            }
            Err(text) => return Err(text),
        }
    }
    Ok(values)
}

/// Checks that a function takes what its figure has.
fn check(writer: &Writer<'_>, figure: &Figure) -> Result<(), String> {
    let [x, y, red, green, blue] =
        [Role::X, Role::Y, Role::Red, Role::Green, Role::Blue].map(|role| count(writer, role));
    let held = [Role::Red, Role::Green, Role::Blue].map(|role| writer.held[role as usize]);
    // A triangle may be three lines.
    let is_whole = x == figure.points || (figure.points == 3 && x == 6);
    if x != y {
        return Err(format!("it takes {x} numbers that are x and {y} that are y"));
    }
    if !is_whole {
        return Err(format!("it takes {x} points, not {}", figure.points));
    }
    if red != green || red != blue || held[0] != held[1] || held[0] != held[2] {
        return Err("of a colour it takes some of red, green and blue alone".to_owned());
    }
    if ![0, 1, figure.points, x].contains(&red) || ![0, x].contains(&held[0]) {
        return Err(format!("it takes {} colours for {} points", red + held[0], figure.points));
    }
    Ok(())
}

/// Returns whether a parameter is an array of records, of which there may be as many as points.
pub fn is_list(parameter: &Parameter) -> bool {
    parameter.arrays > 0 || (parameter.pointers > 0 && is_plural(&parameter.name))
}

/// Numbers of each role.
pub type Counts = [usize; ROLES];

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the call of the first function of a source, as a line.
    fn of(verb: &str, source: &str) -> String {
        let declared = Declared::read(source.as_bytes());
        let figure = FIGURES.iter().find(|figure| figure.verb == verb).unwrap();
        match call(&declared, figure, true) {
            Ok(call) => call.code.split_whitespace().collect::<Vec<_>>().join(" "),
            Err(text) => text.rsplit("): ").next().unwrap_or("").to_owned(),
        }
    }

    #[test]
    fn each_number_is_the_one_that_its_name_means() {
        let px = "(int)fbptr_whole(fbptr_p[0])";
        let py = "(int)fbptr_whole(fbptr_p[1])";
        let red = "(fbptr_c[0] >> 16 & 255)";
        for (source, expected) in [
            ("void PutPixel(int linha, int coluna) {}", format!("PutPixel({py}, {px});")),
            ("void PutPixel(int l, int c) {}", format!("PutPixel({py}, {px});")),
            (
                "void PutPixel(int row, int col, int r, int g, int b) {}",
                format!("PutPixel({py}, {px}, (int){red},"),
            ),
            ("void PutPixel(int a, int b) {}", format!("PutPixel({px}, {py});")),
            ("void PutPixel(int x, int y, int n = 2) {}", format!("PutPixel({px}, {py});")),
            (
                "void PutPixel(float x, float y, float z) {}",
                "PutPixel((float)fbptr_p[0], (float)fbptr_p[1], (float)0);".into(),
            ),
            (
                "namespace a { void PutPixel(int x, int y) {} }",
                format!("using namespace a; PutPixel({px}, {py});"),
            ),
            (
                "void PutPixel(int x, int y, unsigned argb) {}",
                format!("PutPixel({px}, {py}, (unsigned)({red} << 16 |"),
            ),
            // Without a product by 255 colours are not from 0 to 1.
            (
                "void PutPixel(int x, int y, float r, float g, float b) {}",
                format!("PutPixel({px}, {py}, (float){red},"),
            ),
            (
                "void PutPixel(int x, int y, float r, float g, float b) { at[0] = 255.0f * r; }",
                format!("PutPixel({px}, {py}, (float)({red} / 255.0),"),
            ),
        ] {
            let found = of("PX", source);
            assert!(found.starts_with(&expected), "{source}: {found}");
        }
    }

    #[test]
    fn records_are_filled_by_what_is_public() {
        let point =
            "class P { int x, y; public: P(int a, int b) {} P(int x, int y, Q q) {} P(int x, int y) {} };";
        let found = of("LINE", &format!("{point} void DrawLine(P *a, P *b) {{}}"));
        let [a, b] = [0, 2]
            .map(|at| format!("((int)fbptr_whole(fbptr_p[{at}]), (int)fbptr_whole(fbptr_p[{}]));", at + 1));
        assert_eq!(found, format!("P fbptr_0{a} P fbptr_1{b} DrawLine(&fbptr_0, &fbptr_1);"));
        let vertex =
            "struct V { int x = 0, y; C c; V(int x, int y) {} }; struct C { unsigned char r{0}, g, b; };";
        let found = of("LINE", &format!("{vertex} void DrawLine(V v[2]) {{}}"));
        for part in [
            "fbptr_1.b = (unsigned char)(fbptr_c[0] >> 0 & 255);",
            "(fbptr_c[1] >> 0 & 255); fbptr_2.c = fbptr_3;",
            "V fbptr_4[] = { fbptr_0, fbptr_2 }; DrawLine(fbptr_4);",
        ] {
            assert!(found.contains(part), "{part}: {found}");
        }
        let found = of("TRI", &format!("{vertex} void DrawTriangle(V *pontos, C *cores) {{}}"));
        assert!(found.ends_with("DrawTriangle(fbptr_6, fbptr_10);"), "{found}");
        let list = "struct P { int x, y; }; void DrawLine(const std::vector<P> &points) {}";
        assert!(of("LINE", list).contains("fbptr_2.push_back(fbptr_1);"), "{}", of("LINE", list));
        let each = "void DrawTriangle(int xs[3], int ys[3]) {}";
        assert!(
            of("TRI", each).contains("(int)fbptr_whole(fbptr_p[4]) }; int fbptr_1[]"),
            "{}",
            of("TRI", each)
        );
    }

    #[test]
    fn what_is_not_understood_is_told() {
        for (source, expected) in [
            ("void DrawLine(glm::vec3 a, glm::vec3 b) {}", "the type glm::vec3 is not understood"),
            ("void DrawLine(int i, int j, int i2, int j2) {}", "which of i and j is the row is not said"),
            (
                "void DrawLine(int x0, int y0, int x1, int y1, int cor) {}",
                "cor is a colour in one int, not in 32",
            ),
            (
                "void DrawLine(int x0, int y0, int x1, int y1, int style) {}",
                "the meaning of style is not known",
            ),
            ("void DrawLine(int x0, int y0) {}", "it takes 1 points, not 2"),
            ("void DrawLine(int x0, int y0, int x1) {}", "it takes 2 numbers that are x and 1 that are y"),
            (
                "class P { int x, y; P(int x, int y) {} }; void DrawLine(P a, P b) {}",
                "no constructor of P is understood",
            ),
            ("class P { int x, y; }; void DrawLine(P a, P b) {}", "it takes 0 points, not 2"),
            ("void DrawLine(int pontos[2][2]) {}", "pontos is an array of arrays"),
            (
                "void DrawLine(int x0, int y0, int x1, int y1, int *cores) {}",
                "how many numbers a colour of cores has",
            ),
            ("class Tela { public: void DrawLine(int a); };", "a function of Tela is not called"),
            ("", "no function for LINE is found"),
        ] {
            let found = of("LINE", source);
            assert!(found.contains(expected), "{source}: {found}");
        }
    }
}
