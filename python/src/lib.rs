//! The engine for Python: a framebuffer with every verb of the command language, in the process.
//!
//! In: Python values. Out: commands to the engine, replies, exceptions, and the video memory itself
//! through the buffer protocol. `fbptr/framebuffer.py` makes the methods of the public class of it.
//!
//! Promises: no input causes a panic or undefined behaviour; the interpreter's lock is released while
//! something is drawn, unless a view of the memory is held ([`access`]).
#![deny(missing_docs)]

mod access;
mod arguments;
mod batches;
mod errors;
mod framebuffer;
mod items;
mod movie;
mod offsets;
mod paths;
mod scene;
mod slots;
mod view;
mod window;

use fbptr::command::{Encoding, Reply, help_on, parse_color, parse_light_color};
use pyo3::prelude::*;
use slots::SlotKind;

/// A slot: the parameter's name, the word of the form, its kind, whether it may be left out, and the
/// words that may stand there.
type SlotRow = (&'static str, &'static str, &'static str, bool, Vec<&'static str>);
/// A row of the verb table: name, group, whether it is binary, kind of its reply, its forms with their
/// descriptions, its example as text, its slots.
type Row =
    (&'static str, String, bool, &'static str, Vec<(&'static str, &'static str)>, &'static str, Vec<SlotRow>);

/// Returns the rows of the verb table.
#[pyfunction]
fn verbs() -> Vec<Row> {
    slots::forms().iter().map(row).collect()
}

fn row(form: &slots::Form) -> Row {
    let verb = form.verb;
    let reply = match verb.reply {
        Reply::Never => "never",
        Reply::Line => "line",
        Reply::Bytes => "bytes",
        Reply::Lines => "lines",
        Reply::ByForm => "form",
    };
    let forms = verb.forms.iter().map(|form| (form.syntax, form.about)).collect();
    let slots = form.slots.iter().map(|slot| {
        let (kind, words) = match slot.kind {
            SlotKind::Integer => ("integer", Vec::new()),
            SlotKind::Real => ("real", Vec::new()),
            SlotKind::Color => ("color", Vec::new()),
            SlotKind::Word(list, _) => ("word", list.to_vec()),
            SlotKind::Flag(_) => ("flag", Vec::new()),
            SlotKind::Literal(_) => ("literal", Vec::new()),
            SlotKind::Hex => ("hex", Vec::new()),
            SlotKind::Text => ("text", Vec::new()),
            SlotKind::Payload => ("payload", Vec::new()),
            SlotKind::Many => ("many", Vec::new()),
        };
        (slot.field, slot.word, kind, slot.is_optional, words)
    });
    let is_binary = verb.encoding == Encoding::Binary;
    let group = format!("{:?}", verb.group);
    (verb.name, group, is_binary, reply, forms, verb.example, slots.collect())
}

/// Returns what `HELP verb` says.
#[pyfunction]
fn help(verb: &str) -> Option<String> {
    help_on(verb).ok()
}

/// Returns the red, green and blue of a colour of light that is text, 0..1.
#[pyfunction]
fn light_colour(text: &str) -> Option<[f64; 3]> {
    parse_light_color(text.as_bytes())
}

/// Returns the bytes R, G, B, A of a colour that is text; `None` if it is no colour.
#[pyfunction]
fn colour(text: &str) -> Option<[u8; 4]> {
    parse_color(items::colour_word(text).as_bytes())
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<framebuffer::Framebuffer>()?;
    module.add_class::<movie::Movie>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<window::Input>()?;
    module.add_function(wrap_pyfunction!(window::run, module)?)?;
    module.add_function(wrap_pyfunction!(scene::write_file, module)?)?;
    module.add_function(wrap_pyfunction!(scene::remove_leftovers, module)?)?;
    module.add_function(wrap_pyfunction!(scene::model_names, module)?)?;
    module.add_function(wrap_pyfunction!(scene::suzanne, module)?)?;
    module.add_function(wrap_pyfunction!(verbs, module)?)?;
    module.add_function(wrap_pyfunction!(help, module)?)?;
    module.add_function(wrap_pyfunction!(light_colour, module)?)?;
    module.add_function(wrap_pyfunction!(colour, module)?)?;
    Ok(())
}
