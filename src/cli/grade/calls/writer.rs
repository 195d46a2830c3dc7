//! The statements of one call: variables of the program's types, filled from a figure.
//!
//! In: parameters, and what was learnt of their names. Out: C or C++, or what is not understood. Points
//! and colours are taken in the order of the parameters; a colour that is in a record with a point is
//! that point's. Right is: each value's index is counted, and nothing is left at a value that draws
//! something else.

use super::driver::{Counts, is_list};
use super::names::{Figure, Notation, ROLES, Role, is_color, is_plural, packed, role};
use super::source::{Declared, Parameter, Record, is_scalar_word};
use std::fmt::Write;

/// Depth of records in records.
const DEPTH: usize = 4;
/// Type of colours that are one number.
const PACKED: [&str; 8] =
    ["unsigned", "unsigned int", "uint", "uint32_t", "std::uint32_t", "GLuint", "DWORD", "unsigned long"];

/// Writes one call.
pub struct Writer<'a> {
    declared: &'a Declared,
    is_cpp: bool,
    is_filled: bool,
    points: usize,
    pub notation: Notation,
    /// True if numbers without a meaning are coordinates.
    takes_unnamed: bool,
    /// True while names are collected: all numbers are taken.
    pub collects: bool,
    /// Points, and colours apart from points, that the function takes; 0 while they are counted.
    pub taken: [usize; 2],
    /// Numbers of each role so far; colours that are apart from points.
    pub count: Counts,
    /// Numbers of colours that are in records with points.
    pub held: Counts,
    /// The point whose record is written.
    point: Option<usize>,
    variables: usize,
    /// Names of all numbers.
    pub names: Vec<String>,
    /// Assumptions that a reader is told.
    pub notes: Vec<String>,
    pub takes_whole: bool,
    pub code: String,
}

/// A place to which a writer is reset.
#[derive(Clone, Copy, Debug)]
pub struct Mark {
    count: Counts,
    held: Counts,
    variables: usize,
    code: usize,
    notes: usize,
}

impl<'a> Writer<'a> {
    /// Returns a writer that has written nothing.
    pub fn new(declared: &'a Declared, figure: &Figure, is_cpp: bool) -> Writer<'a> {
        Writer {
            declared,
            is_cpp,
            is_filled: figure.verb == "FILL",
            points: figure.points,
            notation: Notation::default(),
            takes_unnamed: false,
            collects: true,
            taken: [0; 2],
            count: [0; ROLES],
            held: [0; ROLES],
            point: None,
            variables: 0,
            names: Vec::new(),
            notes: Vec::new(),
            takes_whole: false,
            code: String::new(),
        }
    }

    /// Begins again.
    pub fn begin(&mut self, notation: Notation, takes_unnamed: bool) {
        (self.notation, self.takes_unnamed, self.collects) = (notation, takes_unnamed, false);
        (self.count, self.held, self.variables, self.point) = ([0; ROLES], [0; ROLES], 0, None);
        (self.code, self.notes, self.names) = (String::new(), Vec::new(), Vec::new());
    }

    /// Returns the place that is reached.
    pub fn mark(&self) -> Mark {
        let [code, notes] = [self.code.len(), self.notes.len()];
        Mark { count: self.count, held: self.held, variables: self.variables, code, notes }
    }

    /// Takes back what was written since.
    pub fn reset(&mut self, mark: Mark) {
        (self.count, self.held, self.variables) = (mark.count, mark.held, mark.variables);
        self.code.truncate(mark.code);
        self.notes.truncate(mark.notes);
    }

    /// Returns what is passed for a parameter of the function itself.
    pub fn whole_argument(&mut self, parameter: &Parameter) -> Result<String, String> {
        if self.is_scalar(&parameter.kind) {
            return self.argument(parameter, 0);
        }
        if parameter.pointers + parameter.arrays > 1 + usize::from(parameter.arrays == 1) {
            return Err(format!("{} is an array of arrays, or a pointer to pointers", parameter.name));
        }
        let element = vector_of(&parameter.kind);
        let is_vector = element.is_some();
        if element.as_ref().is_some_and(|kind| self.is_scalar(kind)) {
            return self.argument(parameter, 0);
        }
        if !is_list(parameter) && !is_vector {
            return self.of_a_point(parameter);
        }
        let kind = element.unwrap_or_else(|| parameter.kind.clone());
        let single = Parameter { kind: kind.clone(), name: parameter.name.clone(), ..Parameter::default() };
        let count = parameter.len.unwrap_or(self.points);
        let elements: Vec<String> =
            (0..count.min(6)).map(|_| self.of_a_point(&single)).collect::<Result<_, _>>()?;
        let name = self.variable();
        if is_vector {
            let _ = writeln!(self.code, "    {} {name};", parameter.kind);
            elements.iter().for_each(|e| _ = writeln!(self.code, "    {name}.push_back({e});"));
            return Ok(if parameter.pointers > 0 { format!("&{name}") } else { name });
        }
        let is_pointers = parameter.pointers > 0 && parameter.arrays > 0;
        let (star, address) = if is_pointers { ("*", "&") } else { ("", "") };
        let elements: Vec<String> = elements.iter().map(|element| format!("{address}{element}")).collect();
        let _ = writeln!(self.code, "    {kind} {star}{name}[] = {{ {} }};", elements.join(", "));
        Ok(name)
    }

    /// Returns what is passed for a record; if it has a point and colours, these are the point's.
    fn of_a_point(&mut self, parameter: &Parameter) -> Result<String, String> {
        let before = self.mark();
        let value = self.argument(parameter, 0)?;
        let point = before.count[Role::X as usize];
        if self.count[Role::X as usize] == point
            || self.count[Role::Red as usize] == before.count[Role::Red as usize]
        {
            return Ok(value);
        }
        self.reset(before);
        self.point = Some(point);
        let value = self.argument(parameter, 0);
        self.point = None;
        value
    }

    fn variable(&mut self) -> String {
        self.variables += 1;
        format!("fbptr_{}", self.variables - 1)
    }

    /// Returns what is passed for a parameter.
    fn argument(&mut self, parameter: &Parameter, depth: usize) -> Result<String, String> {
        let Parameter { kind, name: own, pointers, arrays, len, .. } = parameter;
        if depth > DEPTH {
            return Err(format!("{kind} has records in records"));
        }
        let element = vector_of(kind);
        let is_vector = element.is_some();
        if !is_vector && self.is_scalar(kind) && *pointers == 0 && *arrays == 0 {
            return self.number(kind, own);
        }
        if is_vector || self.is_scalar(kind) {
            let element = element.unwrap_or_else(|| kind.clone());
            if pointers + arrays > 1 || !self.is_scalar(&element) {
                return Err(format!("{own} is an array of arrays, or a pointer to pointers"));
            }
            let values = self.array(&element, own, *len)?;
            let name = self.variable();
            let (kind, brackets) = if is_vector { (kind, "") } else { (&element, "[]") };
            let _ = writeln!(self.code, "    {kind} {name}{brackets} = {{ {} }};", values.join(", "));
            return Ok(if is_vector && *pointers > 0 { format!("&{name}") } else { name });
        }
        let name = self.variable();
        self.record(kind, &name, depth)?;
        Ok(if *pointers > 0 { format!("&{name}") } else { name })
    }

    /// Returns a type without its other names.
    fn resolved<'k>(&'k self, kind: &'k str) -> &'k str {
        let mut kind = kind;
        for _ in 0..8 {
            let tag = own_tag(kind);
            match self.declared.aliases.iter().find(|(name, other)| name == tag && other != kind) {
                Some((_, other)) => kind = other,
                None => break,
            }
        }
        kind
    }

    /// Writes a variable of a record's type.
    fn record(&mut self, kind: &str, name: &str, depth: usize) -> Result<(), String> {
        let tag = own_tag(self.resolved(kind)).to_owned();
        let own = || self.declared.records.iter().filter(|record| record.names.contains(&tag));
        let Some(record) = own().find(|record| !record.is_empty()).or(own().next()).cloned() else {
            return Err(format!("the type {kind} is not understood"));
        };
        let (before, mut why) = (self.mark(), None);
        let mut constructors = record.constructors.clone();
        constructors.retain(|values| !values.is_empty());
        constructors.sort_by_key(|values| usize::MAX - values.len());
        for constructor in &constructors {
            let values: Result<Vec<String>, String> =
                constructor.iter().map(|value| self.argument(value, depth + 1)).collect();
            match (values, self.is_whole_since(&before)) {
                (Ok(values), true) => {
                    let _ = writeln!(self.code, "    {kind} {name}({});", values.join(", "));
                    let [x, red] = [Role::X, Role::Red].map(|role| self.since(&before, role));
                    return self.fields(&record, name, depth, [x == 0, red == 0]);
                }
                (Ok(_), false) => {}
                (Err(text), _) => _ = why.get_or_insert(text),
            }
            self.reset(before);
        }
        if !record.is_made_of_nothing {
            let text = why.unwrap_or_else(|| "none is public that takes a point or a colour".to_owned());
            return Err(format!("no constructor of {kind} is understood: {text}"));
        }
        let first = if self.is_cpp { format!("{}()", own_kind(kind)) } else { "{ 0 }".to_owned() };
        let _ = writeln!(self.code, "    {kind} {name} = {first};");
        self.fields(&record, name, depth, [true, true])
    }

    /// Writes the values of a record's fields, of those of a point and of a colour that are needed;
    /// what is neither keeps its value.
    fn fields(&mut self, record: &Record, name: &str, depth: usize, needs: [bool; 2]) -> Result<(), String> {
        for field in &record.fields {
            let is_scalar = self.is_scalar(&field.kind);
            let is_value = field.pointers == 0 && field.arrays == 0;
            let before = self.mark();
            if is_scalar && field.arrays == 1 && field.pointers == 0 {
                let values = self.array(&field.kind, &field.name, field.len)?;
                if self.keeps(&before, needs) {
                    for (at, value) in values.iter().take(field.len.unwrap_or(4)).enumerate() {
                        let _ = writeln!(self.code, "    {name}.{}[{at}] = {value};", field.name);
                    }
                    continue;
                }
            } else if is_scalar && is_value {
                let is_known = self.takes_unnamed
                    || role(&field.name, self.notation) != Role::Other
                    || is_color(&field.name);
                self.names.push(field.name.clone());
                if !is_known {
                    continue;
                }
                let value = self.number(&field.kind, &field.name)?;
                if self.keeps(&before, needs) {
                    let _ = writeln!(self.code, "    {name}.{} = {value};", field.name);
                    continue;
                }
            } else if is_value && (needs[0] || needs[1]) {
                let value = self.argument(field, depth + 1)?;
                if self.keeps(&before, needs) {
                    let _ = writeln!(self.code, "    {name}.{} = {value};", field.name);
                    continue;
                }
            } else {
                continue;
            }
            self.reset(before);
        }
        Ok(())
    }

    /// Returns whether what was written since is needed.
    fn keeps(&self, before: &Mark, needs: [bool; 2]) -> bool {
        let grew = |role: Role| self.since(before, role) > 0;
        let is_point = grew(Role::X) || grew(Role::Y);
        let is_color = grew(Role::Red) || grew(Role::Green) || grew(Role::Blue);
        (needs[0] || !is_point) && (needs[1] || !is_color)
    }

    /// Returns the numbers of a role since a place.
    fn since(&self, before: &Mark, role: Role) -> usize {
        let role = role as usize;
        self.count[role] + self.held[role] - before.count[role] - before.held[role]
    }

    /// Returns whether points or colours were taken since a place, and these whole.
    fn is_whole_since(&self, before: &Mark) -> bool {
        let [x, y, red, green, blue] =
            [Role::X, Role::Y, Role::Red, Role::Green, Role::Blue].map(|role| self.since(before, role));
        self.collects || (x == y && red == green && red == blue && x + red > 0)
    }

    /// Returns the numbers of an array: those of a point or a colour, or one of each point.
    fn array(&mut self, kind: &str, name: &str, len: Option<usize>) -> Result<Vec<String>, String> {
        self.names.push(name.to_owned());
        let own = role(name, self.notation);
        let is_channel = self.notation.has_channels || matches!(own, Role::X | Role::Y);
        let each = |names: &[&str], count: usize| -> Vec<String> {
            names.iter().cycle().take(names.len() * count).map(|name| (*name).to_owned()).collect()
        };
        let count = len.unwrap_or(self.points);
        let names = match (own, len) {
            (Role::X | Role::Y | Role::Red | Role::Green | Role::Blue, _)
                if self.points > 1 && is_channel =>
            {
                vec![name.to_owned(); count.min(6)]
            }
            _ if is_color(name) => match len {
                Some(3) => each(&["r", "g", "b"], 1),
                Some(4) => each(&["r", "g", "b", "a"], 1),
                None if !is_plural(name) => each(&["r", "g", "b", "a"], 1),
                Some(n) if self.points > 1 && n == 3 * self.points => each(&["r", "g", "b"], self.points),
                Some(n) if self.points > 1 && n == 4 * self.points => {
                    each(&["r", "g", "b", "a"], self.points)
                }
                _ => return Err(format!("how many numbers a colour of {name} has is not said")),
            },
            (_, Some(2)) => each(&["x", "y"], 1),
            (_, Some(3)) => each(&["x", "y", "z"], 1),
            (_, Some(4)) => each(&["x", "y", "z", "w"], 1),
            (_, Some(n)) if self.points > 2 && n == 2 * self.points => each(&["x", "y"], self.points),
            (_, None) if !is_plural(name) => each(&["x", "y", "z", "w"], 1),
            _ => return Err(format!("which numbers {name} has is not said")),
        };
        let unnamed = std::mem::replace(&mut self.takes_unnamed, false);
        let len = self.names.len();
        let values = names.iter().map(|name| self.number(kind, name)).collect();
        // Of these names the program has none, but that there are coordinates.
        self.names.truncate(len);
        self.names.extend(names.into_iter().find(|name| name == "x"));
        self.takes_unnamed = unnamed;
        values
    }

    /// Returns the next number of a role.
    fn number(&mut self, kind: &str, name: &str) -> Result<String, String> {
        self.names.push(name.to_owned());
        let mut role = role(name, self.notation);
        // Where a, b, c and d are coordinates they are no colours.
        if self.takes_unnamed && name.len() == 1 {
            role = Role::Other;
        }
        if self.collects {
            return Ok("0".to_owned());
        }
        if role == Role::Other && is_color(name) {
            return self.packed(kind, name);
        }
        if role == Role::Other && self.takes_unnamed {
            let [x, y] = [Role::X, Role::Y].map(|role| self.count[role as usize]);
            role = match (x == y, y < self.points) {
                (false, _) => Role::Y,
                (true, true) => Role::X,
                (true, false) => self.next_color(),
            };
        }
        let at = self.next(role);
        let value = match role {
            Role::X | Role::Y => {
                let place = format!("fbptr_p[{}]", 2 * self.place(at, 0) + usize::from(role == Role::Y));
                self.takes_whole |= self.is_whole(kind);
                if self.is_whole(kind) { format!("fbptr_whole({place})") } else { place }
            }
            Role::Red | Role::Green | Role::Blue => {
                let shift = [16, 8, 0][role as usize - Role::Red as usize];
                let byte = format!("(fbptr_c[{}] >> {shift} & 255)", self.color_place(at));
                match self.is_part(kind) {
                    true => {
                        self.note("colours from 0 to 1".to_owned());
                        format!("({byte} / 255.0)")
                    }
                    false => byte,
                }
            }
            Role::Alpha if self.is_part(kind) => "1".to_owned(),
            Role::Alpha => "255".to_owned(),
            Role::Filled => u8::from(self.is_filled).to_string(),
            Role::Zero => "0".to_owned(),
            Role::One => "1".to_owned(),
            Role::Other if name.is_empty() => return Err("a number without a name".to_owned()),
            Role::Other => return Err(format!("the meaning of {name} is not known")),
        };
        Ok(format!("({kind}){value}"))
    }

    /// Returns a colour that is one number.
    fn packed(&mut self, kind: &str, name: &str) -> Result<String, String> {
        if !PACKED.contains(&self.resolved(kind)) {
            return Err(format!("{name} is a colour in one {kind}, not in 32 bits without a sign"));
        }
        let at = self.next(Role::Red);
        [Role::Green, Role::Blue].iter().for_each(|role| _ = self.next(*role));
        let ([red, green, blue, alpha], form) = packed(name);
        self.note(format!("{name}: {form}"));
        let color = format!("fbptr_c[{}]", self.color_place(at));
        Ok(format!(
            "({kind})(({color} >> 16 & 255) << {red} | ({color} >> 8 & 255) << {green} | ({color} & 255) << {blue} | \
             255u << {alpha})"
        ))
    }

    /// Counts a number, and returns how many there were.
    fn next(&mut self, role: Role) -> usize {
        let is_color = matches!(role, Role::Red | Role::Green | Role::Blue | Role::Alpha);
        let counts = if is_color && self.point.is_some() { &mut self.held } else { &mut self.count };
        counts[role as usize] += 1;
        counts[role as usize] - 1
    }

    fn note(&mut self, text: String) {
        if !self.notes.contains(&text) {
            self.notes.push(text);
        }
    }

    fn next_color(&self) -> Role {
        let count = |role: Role| self.count[role as usize] + self.held[role as usize];
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

    /// Returns the figure's colour of the function's one.
    fn color_place(&self, at: usize) -> usize {
        match self.point {
            Some(point) => self.place(point, 0),
            None => self.place(at, 1),
        }
    }

    fn is_scalar(&self, kind: &str) -> bool {
        self.resolved(kind).split(' ').all(|word| is_scalar_word(word.trim_start_matches("std::")))
    }

    fn is_whole(&self, kind: &str) -> bool {
        let kind = self.resolved(kind);
        !["float", "double", "GLfloat", "GLdouble", "GLclampf"].iter().any(|word| kind.contains(word))
    }

    /// Returns whether a colour of a type is from 0 to 1.
    fn is_part(&self, kind: &str) -> bool {
        !self.is_whole(kind) && self.declared.is_scaled
    }
}

/// Returns the type of a vector's elements.
fn vector_of(kind: &str) -> Option<String> {
    let (before, rest) = kind.split_once("vector<")?;
    let is_plain = before.is_empty() || before == "std::";
    is_plain.then(|| rest.strip_suffix('>').map(|kind| kind.trim().to_owned())).flatten()
}

/// Returns a type's name without `struct` or `class`.
fn own_kind(kind: &str) -> &str {
    kind.trim_start_matches("struct ").trim_start_matches("class ")
}

/// Returns a type's name without its namespace too.
fn own_tag(kind: &str) -> &str {
    let kind = own_kind(kind);
    kind.rsplit_once("::").map_or(kind, |(_, name)| name)
}

impl Record {
    fn is_empty(&self) -> bool {
        self.fields.is_empty() && self.constructors.is_empty() && self.methods.is_empty()
    }
}
