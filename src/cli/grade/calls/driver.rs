//! Calls of a program's own functions, written from their declarations.
//!
//! In: declarations of all sources. Out: C or C++ that calls `PutPixel`, `DrawLine`, `DrawTriangle`
//! under the names that students give them, with points and colours in the order and in the records
//! that they chose. A parameter is a number, a record of such, a pointer or reference to either, or
//! an array of a point or of a colour. What a number means is taken from its name: it ends or begins
//! with x or y, or names red, green, blue or alpha in English or Portuguese; numbers without such
//! names are x and y in turn. Right is: a function is called only if it takes all points of its figure.

use super::source::{Declared, Function, Parameter, Record, is_scalar_word};
use std::fmt::Write;

/// A figure: the command's name, its points, and names of functions without case and `_`.
pub struct Figure {
    pub verb: &'static str,
    pub points: usize,
    names: &'static [&'static str],
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

/// A call of a function for a figure.
#[derive(Debug)]
pub struct Call {
    pub verb: &'static str,
    /// The function with its parameters, as a reader sees it.
    pub shown: String,
    pub takes_color: bool,
    /// True if a parameter says that a triangle is filled.
    takes_switch: bool,
    /// Statements, in which `fbptr_p` are coordinates and `fbptr_c` colours.
    pub code: String,
}

/// Finds the functions for all figures, each the first that is understood: names in their order,
/// and of one name the one with most colours, rather a definition than a declaration.
pub fn calls(declared: &Declared, is_cpp: bool) -> Vec<Call> {
    let found = |figure: &Figure, names: &[&str], wants_switch: bool| {
        names.iter().find_map(|name| {
            let plain = |f: &&Function| f.name.to_ascii_lowercase().replace('_', "") == **name;
            let mut found: Vec<(usize, bool, Call)> = Vec::new();
            for function in declared.functions.iter().filter(plain) {
                let call = Writer::call(declared, figure, function, is_cpp);
                found.extend(call.map(|(colors, call)| (colors, function.body.is_some(), call)));
            }
            found.retain(|(_, _, call)| call.takes_switch || !wants_switch);
            found.sort_by_key(|(colors, is_whole, _)| (usize::MAX - colors, !is_whole));
            found.into_iter().next().map(|(_, _, call)| call)
        })
    };
    let call = |figure: &Figure| {
        let own = found(figure, figure.names, false);
        // One function for both kinds of triangles has a switch.
        own.or_else(|| if figure.verb == "FILL" { found(figure, FIGURES[2].names, true) } else { None })
    };
    FIGURES.iter().filter_map(call).collect()
}

/// Returns a parameter as it is declared.
fn show(parameter: &Parameter) -> String {
    let Parameter { kind, name, is_pointer, is_array } = parameter;
    let [pointer, array] =
        [(*is_pointer, "*"), (*is_array, "[]")].map(|(is, text)| if is { text } else { "" });
    format!("{kind} {pointer}{name}{array}").trim().to_owned()
}

/// Meaning of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Role {
    X,
    Y,
    Red,
    Green,
    Blue,
    Alpha,
    /// A switch between outlined and filled triangles.
    Filled,
    Other,
}

/// Returns the meaning that a name has.
fn role(name: &str) -> Role {
    let name = name.to_ascii_lowercase().replace('_', "");
    let name = name.trim_end_matches(|c: char| c.is_ascii_digit());
    let begins = |words: &[&str]| words.iter().any(|word| name.starts_with(word));
    let ends = |words: &[&str]| words.iter().any(|word| name.ends_with(word));
    if begins(&["fill", "preench", "isfill"]) {
        return Role::Filled;
    }
    match name {
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
        _ => Role::Other,
    }
}

/// Writes one call.
struct Writer<'a> {
    declared: &'a Declared,
    is_cpp: bool,
    is_filled: bool,
    points: usize,
    /// True if numbers without a meaning are coordinates.
    takes_unnamed: bool,
    /// Points and colours that the function takes; 0 while they are counted.
    taken: [usize; 2],
    /// Numbers of each role so far.
    count: [usize; 8],
    variables: usize,
    code: String,
}

impl<'a> Writer<'a> {
    /// Returns the call and its number of colours, if the function is understood.
    fn call(
        declared: &'a Declared,
        figure: &Figure,
        function: &Function,
        is_cpp: bool,
    ) -> Option<(usize, Call)> {
        let mut writer = Writer {
            declared,
            is_cpp,
            is_filled: figure.verb == "FILL",
            points: figure.points,
            takes_unnamed: false,
            taken: [0; 2],
            count: [0; 8],
            variables: 0,
            code: String::new(),
        };
        writer.arguments(&function.parameters)?;
        if writer.count[Role::X as usize] == 0 {
            writer.takes_unnamed = true;
            writer.begin([0; 2]);
            writer.arguments(&function.parameters)?;
        }
        let count = |role: Role, writer: &Writer<'_>| writer.count[role as usize];
        let (x, y, red) = (count(Role::X, &writer), count(Role::Y, &writer), count(Role::Red, &writer));
        // A triangle may be three lines.
        let is_whole = x == figure.points || (figure.points == 3 && x == 6);
        if !is_whole || x != y || red != count(Role::Green, &writer) || red != count(Role::Blue, &writer) {
            return None;
        }
        writer.begin([x, red]);
        let arguments = writer.arguments(&function.parameters)?;
        let _ = writeln!(writer.code, "    {}({});", function.name, arguments.join(", "));
        let shown: Vec<String> = function.parameters.iter().map(show).collect();
        let shown = format!("{}({})", function.name, shown.join(", "));
        let takes_switch = count(Role::Filled, &writer) > 0;
        let call = Call { verb: figure.verb, shown, takes_color: red > 0, takes_switch, code: writer.code };
        Some((red, call))
    }

    fn begin(&mut self, taken: [usize; 2]) {
        (self.taken, self.count, self.variables) = (taken, [0; 8], 0);
        self.code.clear();
    }

    fn arguments(&mut self, parameters: &[Parameter]) -> Option<Vec<String>> {
        parameters.iter().map(|parameter| self.argument(parameter, 0)).collect()
    }

    /// Returns what is passed for a parameter.
    fn argument(&mut self, parameter: &Parameter, depth: usize) -> Option<String> {
        if depth > 4 {
            return None;
        }
        let is_vector = parameter.kind.ends_with('>') && parameter.kind.contains("vector<");
        if self.is_scalar(&parameter.kind) && !parameter.is_pointer && !parameter.is_array {
            return self.number(&parameter.kind, &parameter.name);
        }
        let name = format!("fbptr_{}", self.variables);
        self.variables += 1;
        if is_vector || self.is_scalar(&parameter.kind) {
            let kind = parameter
                .kind
                .split_once("vector<")
                .map_or(parameter.kind.as_str(), |(_, rest)| rest.trim_end_matches('>'));
            let values = self.array(kind, &parameter.name)?;
            let (kind, brackets) = if is_vector { (parameter.kind.as_str(), "") } else { (kind, "[]") };
            let _ = writeln!(self.code, "    {kind} {name}{brackets} = {{ {} }};", values.join(", "));
            return Some(name);
        }
        self.record(parameter, &name, depth)?;
        Some(if parameter.is_pointer { format!("&{name}") } else { name })
    }

    /// Writes a variable of a record's type.
    fn record(&mut self, parameter: &Parameter, name: &str, depth: usize) -> Option<()> {
        let kind = &parameter.kind;
        let tag = own_tag(kind);
        let tag = self.declared.aliases.iter().find(|(name, _)| name == tag).map_or(tag, |(_, other)| other);
        let is_own = |record: &&Record| record.names.iter().any(|name| name == tag) && !record.is_empty();
        let record = self.declared.records.iter().find(is_own)?.clone();
        match record.constructors.iter().max_by_key(|parameters| parameters.len()) {
            Some(constructor) if !constructor.is_empty() => {
                let mut values = Vec::new();
                for parameter in constructor {
                    values.push(self.argument(parameter, depth + 1)?);
                }
                let _ = writeln!(self.code, "    {kind} {name}({});", values.join(", "));
            }
            _ => {
                let first = if self.is_cpp { format!("{}()", own_tag(kind)) } else { "{ 0 }".to_owned() };
                let _ = writeln!(self.code, "    {kind} {name} = {first};");
                self.fields(&record, name, depth)?;
            }
        }
        Some(())
    }

    /// Writes the values of a record's fields; what is no point and no colour keeps its 0.
    fn fields(&mut self, record: &Record, name: &str, depth: usize) -> Option<()> {
        for field in &record.fields {
            let is_scalar = self.is_scalar(&field.kind);
            if is_scalar && field.is_array {
                for (at, value) in self.array(&field.kind, &field.name)?.iter().enumerate() {
                    let _ = writeln!(self.code, "    {name}.{}[{at}] = {value};", field.name);
                }
            } else if is_scalar && !field.is_pointer {
                let is_known = self.takes_unnamed || role(&field.name) != Role::Other;
                if let (true, Some(value)) = (is_known, self.number(&field.kind, &field.name)) {
                    let _ = writeln!(self.code, "    {name}.{} = {value};", field.name);
                }
            } else if !field.is_pointer && !field.is_array {
                let value = self.argument(field, depth + 1)?;
                let _ = writeln!(self.code, "    {name}.{} = {value};", field.name);
            }
        }
        Some(())
    }

    /// Returns the numbers of an array: those of a colour, or of a point.
    fn array(&mut self, kind: &str, name: &str) -> Option<Vec<String>> {
        let name = name.to_ascii_lowercase();
        let is_color =
            ["cor", "col", "rgb", "pixel"].iter().any(|word| name.contains(word)) && !name.contains("coord");
        let names: &[&str] = if is_color { &["r", "g", "b", "a"] } else { &["x", "y", "other", "other"] };
        names.iter().map(|name| self.number(kind, name)).collect()
    }

    /// Returns the next number of a role.
    fn number(&mut self, kind: &str, name: &str) -> Option<String> {
        let mut role = role(name);
        // Where a, b, c and d are coordinates they are no colours.
        if self.takes_unnamed && name.len() == 1 {
            role = Role::Other;
        }
        let count = |role: Role, writer: &Self| writer.count[role as usize];
        if role == Role::Other && self.takes_unnamed {
            let (x, y) = (count(Role::X, self), count(Role::Y, self));
            role = match (x == y, y < self.points) {
                (false, _) => Role::Y,
                (true, true) => Role::X,
                (true, false) => self.next_color(),
            };
        }
        let at = self.count[role as usize];
        self.count[role as usize] += 1;
        let value = match role {
            Role::X | Role::Y => {
                let place = format!("fbptr_p[{}]", 2 * self.place(at, 0) + usize::from(role == Role::Y));
                match self.is_whole(kind) {
                    true => format!("fbptr_whole({place})"),
                    false => place,
                }
            }
            Role::Red => format!("(fbptr_c[{}] >> 16 & 255)", self.place(at, 1)),
            Role::Green => format!("(fbptr_c[{}] >> 8 & 255)", self.place(at, 1)),
            Role::Blue => format!("(fbptr_c[{}] & 255)", self.place(at, 1)),
            Role::Alpha => "255".to_owned(),
            Role::Filled => u8::from(self.is_filled).to_string(),
            Role::Other => "0".to_owned(),
        };
        Some(format!("({kind}){value}"))
    }

    fn next_color(&self) -> Role {
        let count = |role: Role| self.count[role as usize];
        let (red, green, blue) = (count(Role::Red), count(Role::Green), count(Role::Blue));
        match () {
            () if red > green => Role::Green,
            () if green > blue => Role::Blue,
            () if blue > count(Role::Alpha) => Role::Alpha,
            () => Role::Red,
        }
    }

    /// Returns the figure's point or colour of the function's one.
    fn place(&self, at: usize, which: usize) -> usize {
        match self.taken[which] {
            6 => [0, 1, 1, 2, 2, 0][at % 6],
            _ => at % self.points,
        }
    }

    fn is_scalar(&self, kind: &str) -> bool {
        let kind =
            self.declared.aliases.iter().find(|(name, _)| name == kind).map_or(kind, |(_, other)| other);
        kind.split(' ').all(|word| is_scalar_word(word.trim_start_matches("std::")))
    }

    fn is_whole(&self, kind: &str) -> bool {
        let kind =
            self.declared.aliases.iter().find(|(name, _)| name == kind).map_or(kind, |(_, other)| other);
        !["float", "double", "GLfloat", "GLdouble"].iter().any(|word| kind.contains(word))
    }
}

/// Returns a type's name without `struct` or `class`.
fn own_tag(kind: &str) -> &str {
    kind.trim_start_matches("struct ").trim_start_matches("class ")
}

impl Record {
    fn is_empty(&self) -> bool {
        self.fields.is_empty() && self.constructors.is_empty()
    }
}
