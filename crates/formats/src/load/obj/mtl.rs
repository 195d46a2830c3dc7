//! MTL files: materials, lit by the format's own equation (Blinn's half vector).
//!
//! Statements in use: `newmtl`, `Ka`, `Kd`, `Ks`, `Ke`, `Ns`, `d`, `Tr`, `illum`, `map_Kd`, `map_d`.
//! Defaults: Ka, Ks and Ke are 0, Kd is 0.8 (1 with a texture), Ns is 1, and the surface is opaque.
//! `illum 0` is Kd alone, unlit; `illum 1` has no highlight. If both `d` and `Tr` are given, `d`
//! counts. `Tr` of 1 or more without `d` is read as opaque, and `Ns` below 1 as no highlight: both
//! are written by programs that mean that.

use super::lines::{Lines, keyword, number, shown, text, words};
use super::placement::Placement;
use super::through_tobj::{self, RawMaterial};
use crate::load::defects::Defects;
use crate::load::{FilePosition, LoadError, LoadErrorKind, LoadMemory, LoadWarning};
use fbptr_core::scene::{LightingModel, Material};
use glam::{DVec2, DVec3};
use std::collections::HashSet;
use std::io::Write;
use std::ops::RangeInclusive;

/// Least exponent that makes a highlight: below 1 it is as wide as the diffuse light.
const LEAST_EXPONENT: f64 = 1.0;

/// Lines that are read between two looks at the token that cancels the load.
const LINES_BETWEEN_CHECKS: u32 = 1024;

/// A material, and the position of its `map_Kd`.
#[derive(Clone, Debug)]
pub(super) struct FileMaterial {
    pub(super) material: Material,
    /// Options of its texture.
    pub(super) placement: Placement,
    pub(super) texture_place: FilePosition,
    /// Name of the picture of its opacity (`map_d`), and where it stands.
    pub(super) opacity_map: Option<String>,
    pub(super) opacity_place: FilePosition,
}

/// Statements of a material that are not passed to `tobj`, and lines of some that are.
#[derive(Clone, Debug, Default)]
struct MaterialLines {
    /// Name, which may be empty.
    name: String,
    /// Line of its `newmtl`.
    line: u32,
    placement: Placement,
    /// Line of its `map_Kd`.
    texture_line: u32,
    /// Line and name of its `map_d`.
    opacity_map: Option<(u32, String)>,
    /// Line of its `Ns`.
    exponent_line: u32,
    /// Line and value of its `Tr`.
    transparency: Option<(u32, f64)>,
}

/// State of the line check of an MTL file.
struct Check<'a> {
    file_name: &'a str,
    line: u32,
    /// Checked lines for `tobj`.
    out: Vec<u8>,
    materials: Vec<MaterialLines>,
    warned: HashSet<String>,
    warnings: Vec<LoadWarning>,
    /// Statements that cannot be read.
    unreadable: Defects,
}

/// Parses an MTL file. Returns its materials in the file's order, and warnings about skipped parts.
///
/// # Errors
/// If `memory` is cancelled, or a material is lost.
pub(super) fn parse(
    bytes: &[u8],
    file_name: &str,
    memory: &LoadMemory,
) -> Result<(Vec<FileMaterial>, Vec<LoadWarning>), LoadError> {
    let mut check = Check {
        file_name,
        line: 0,
        out: Vec::new(),
        materials: Vec::new(),
        warned: HashSet::new(),
        warnings: Vec::new(),
        unreadable: Defects::default(),
    };
    for (line, statement) in Lines::new(bytes) {
        if line.is_multiple_of(LINES_BETWEEN_CHECKS) {
            memory.check_cancelled().map_err(|kind| LoadError::new(check.place(), kind))?;
        }
        check.line = line;
        let (word, arguments) = keyword(&statement);
        if let Err(error) = check.statement(word, arguments) {
            check.unreadable.note(|| error);
        }
    }
    let Check { out, materials: lines, mut warnings, unreadable, .. } = check;
    warnings.extend(unreadable.warning("the statement is left out"));
    let raw = through_tobj::mtl(&mut out.as_slice(), file_name)?;
    if raw.len() != lines.len() {
        let reason = format!("{} materials are defined, and {} came back", lines.len(), raw.len());
        return Err(LoadError::new(
            FilePosition::file(file_name),
            LoadErrorKind::Undecodable { format: "MTL", reason },
        ));
    }
    let mut names = HashSet::new();
    let mut materials = Vec::new();
    let (mut opaque, mut matte) = (Alike::default(), Alike::default());
    for (raw, statements) in raw.into_iter().zip(lines) {
        let MaterialLines { name, line, placement, texture_line, opacity_map, exponent_line, transparency } =
            statements;
        if !names.insert(name.clone()) {
            let message = format!("material {name:?} is defined again: the first one counts");
            warnings.push(LoadWarning { place: FilePosition::line(file_name, line), message });
        }
        let has_opacity = raw.d.is_some();
        let is_without_highlight = raw.ns.is_some_and(|n| n < LEAST_EXPONENT);
        let mut material = Material { name, ..material(raw) };
        match transparency {
            Some((line, 1.0)) if !has_opacity => opaque.note(line, &material.name),
            Some((_, tr)) if !has_opacity => material.transparency = tr,
            _ => {}
        }
        let is_lit = material.model != LightingModel::Unlit;
        if is_without_highlight && is_lit && material.ks != DVec3::ZERO {
            material.ks = DVec3::ZERO;
            matte.note(exponent_line, &material.name);
        }
        let texture_place = FilePosition::line(file_name, texture_line);
        let (opacity_line, opacity_map) = opacity_map.unzip();
        let opacity_place = FilePosition::line(file_name, opacity_line.unwrap_or(0));
        materials.push(FileMaterial { material, placement, texture_place, opacity_map, opacity_place });
    }
    let tr = "is read as opaque: some programs write the opacity there (d has one meaning)";
    let ns = "is read as no highlight, without Ks: some programs write 0 for that";
    warnings.extend(opaque.warning(file_name, "Tr 1", tr));
    warnings.extend(matte.warning(file_name, "Ns below 1", ns));
    Ok((materials, warnings))
}

/// Materials that are read in the same way: line and name of the first, and the number of others.
#[derive(Default)]
pub(super) struct Alike {
    first: Option<(u32, String)>,
    others: usize,
}

impl Alike {
    pub(super) fn note(&mut self, line: u32, name: &str) {
        match self.first {
            Some(_) => self.others += 1,
            None => self.first = Some((line, name.to_owned())),
        }
    }

    /// Returns one warning for all of them, if there are any.
    pub(super) fn warning(self, file_name: &str, what: &str, why: &str) -> Option<LoadWarning> {
        let (line, name) = self.first?;
        let others = match self.others {
            0 => String::new(),
            others => format!(" and {others} more"),
        };
        let message = format!("{what} of material {name:?}{others} {why}");
        Some(LoadWarning { place: FilePosition::line(file_name, line), message })
    }
}

impl Check<'_> {
    fn place(&self) -> FilePosition {
        FilePosition::line(self.file_name, self.line)
    }

    fn syntax(&self, expected: &str, found: &[u8]) -> LoadError {
        let kind = LoadErrorKind::Syntax { expected: expected.into(), found: shown(found) };
        LoadError::new(self.place(), kind)
    }

    fn warn_of(&mut self, keyword: &[u8], why: &str) {
        let keyword = shown(keyword);
        if self.warned.len() < 100 && self.warned.insert(format!("{keyword} {why}")) {
            let message = format!("{keyword:?} {why}");
            self.warnings.push(LoadWarning { place: self.place(), message });
        }
    }

    fn statement(&mut self, word: &[u8], arguments: &[u8]) -> Result<(), LoadError> {
        match word {
            [] | [b'#', ..] => return Ok(()),
            b"newmtl" => {
                // Some exporters write an empty name, which `tobj` refuses: it gets a number.
                let name = text(arguments).trim().to_owned();
                writeln!(self.out, "newmtl {}", self.materials.len()).expect("memory can be written");
                self.materials.push(MaterialLines { name, line: self.line, ..MaterialLines::default() });
                return Ok(());
            }
            _ if self.materials.is_empty() => {
                self.warn_of(word, "stands before the first newmtl: it is skipped");
                return Ok(());
            }
            b"Ka" | b"Kd" | b"Ks" | b"Ke" => self.color(word, arguments)?,
            b"Ns" => {
                let value = self.number(word, arguments, "an exponent", 0.0..=f64::MAX)?;
                writeln!(self.out, "Ns {value:?}").expect("memory can be written");
                self.note(|material, line| material.exponent_line = line);
            }
            b"Tr" => {
                let value = self.number(word, arguments, "a transparency", 0.0..=f64::MAX)?.min(1.0);
                self.note(|material, line| material.transparency = Some((line, value)));
            }
            b"d" => {
                let mut list = words(arguments).peekable();
                let rest = match list.next_if(|w| *w == b"-halo") {
                    Some(_) => {
                        self.warn_of(b"d -halo", "is read as d: the surface does not depend on the view");
                        list.next().unwrap_or_default()
                    }
                    None => arguments,
                };
                let value = self.number(b"d", rest, "an opacity", 0.0..=1.0)?;
                writeln!(self.out, "d {value:?}").expect("memory can be written");
            }
            b"illum" => self.illumination(arguments)?,
            _ if word.eq_ignore_ascii_case(b"map_Kd") => self.texture(arguments, false),
            _ if word.eq_ignore_ascii_case(b"map_d") => self.texture(arguments, true),
            b"Ni" | b"Tf" | b"sharpness" | b"Km" | b"map_aat" => {}
            b"map_Ka" | b"map_Ks" | b"map_Ke" | b"map_Ns" | b"map_NS" | b"map_ns" | b"map_Bump"
            | b"map_bump" | b"map_Tr" | b"bump" | b"disp" | b"decal" | b"refl" | b"norm" | b"map_Kn"
            | b"Pr" | b"Pm" | b"Ps" | b"Pc" | b"Pcr" | b"aniso" | b"anisor" | b"map_Pr" | b"map_Pm"
            | b"map_Ps" => {
                self.warn_of(word, "is not used");
            }
            _ => self.warn_of(word, "is not an MTL statement: it is skipped"),
        }
        Ok(())
    }

    /// Handles `Kd r g b`, or `Kd r` for a grey.
    fn color(&mut self, word: &[u8], arguments: &[u8]) -> Result<(), LoadError> {
        let mut list = words(arguments);
        let first = list.next().unwrap_or_default();
        if first == b"spectral" || first == b"xyz" {
            self.warn_of(word, "is skipped: only red, green and blue are used");
            return Ok(());
        }
        let mut rgb = [0.0; 3];
        let mut count = 0;
        for word in words(arguments) {
            let value = number(word, "a colour", || self.place())?;
            if count < 3 {
                rgb[count] = value;
            }
            count += 1;
        }
        match count {
            1 => rgb = [rgb[0]; 3],
            3 => {}
            4.. => self.warn_of(word, "has more than 3 numbers: the first 3 are used"),
            _ => return Err(self.syntax("a colour has 3 numbers, or 1 for a grey", arguments)),
        }
        let [r, g, b] = rgb;
        writeln!(self.out, "{} {r:?} {g:?} {b:?}", text(word)).expect("memory can be written");
        Ok(())
    }

    /// Handles `illum`, whose number may be written as a real.
    fn illumination(&mut self, arguments: &[u8]) -> Result<(), LoadError> {
        let word = words(arguments).next().unwrap_or_default();
        let number = std::str::from_utf8(word).ok().and_then(|text| text.parse::<f64>().ok());
        match number.filter(|n| n.fract() == 0.0 && (0.0..=10.0).contains(n)) {
            Some(model) => writeln!(self.out, "illum {}", model as u8).expect("memory can be written"),
            None => return Err(self.syntax("illum is a whole number from 0 to 10", word)),
        }
        Ok(())
    }

    /// Notes a statement of the material that is being read, with its line.
    fn note(&mut self, set: impl FnOnce(&mut MaterialLines, u32)) {
        if let Some(material) = self.materials.last_mut() {
            set(material, self.line);
        }
    }

    /// Reads the number of a statement, clamped to `range` with a warning.
    fn number(
        &mut self,
        word: &[u8],
        arguments: &[u8],
        what: &'static str,
        range: RangeInclusive<f64>,
    ) -> Result<f64, LoadError> {
        let token = words(arguments).next().unwrap_or_default();
        let value = number(token, what, || self.place())?;
        let nearest = value.clamp(*range.start(), *range.end());
        if nearest != value {
            self.warn_of(word, &format!("{value:?} is out of range: {nearest:?} is taken"));
        }
        Ok(nearest)
    }

    /// Handles `map_Kd [options] name`, or `map_d`, whose options are those of `map_Kd` or left out.
    /// The name may contain blanks; options that would change the picture and are not supported get a
    /// warning.
    fn texture(&mut self, arguments: &[u8], is_opacity: bool) {
        let statement = if is_opacity { "map_d" } else { "map_Kd" };
        let mut rest = arguments;
        let mut placement = Placement::default();
        while rest.starts_with(b"-") {
            let (option, after) = keyword(rest);
            // Least and most words that belong to an option; those beyond the least must be
            // numbers.
            let (least, most) = match option {
                b"-blendu" | b"-blendv" | b"-cc" | b"-clamp" | b"-imfchan" | b"-texres" | b"-bm"
                | b"-boost" | b"-type" | b"-colorspace" => (1, 1),
                b"-mm" => (2, 2),
                b"-o" | b"-s" | b"-t" => (1, 3),
                _ => break,
            };
            rest = after;
            let mut numbers = [None; 3];
            let mut is_on = false;
            for (taken, slot) in numbers.iter_mut().enumerate().take(most) {
                let (value, after) = keyword(rest);
                let number = std::str::from_utf8(value).ok().and_then(|t| t.parse::<f64>().ok());
                if taken >= least && (number.is_none() || after.is_empty()) {
                    break;
                }
                *slot = number.filter(|n| n.is_finite());
                is_on |= value == b"on";
                rest = after;
            }
            let pair =
                |default: f64| DVec2::new(numbers[0].unwrap_or(default), numbers[1].unwrap_or(default));
            match option {
                b"-s" => placement.scale = pair(1.0),
                b"-o" => placement.offset = pair(0.0),
                b"-clamp" => placement.is_clamped = is_on,
                // Colours are not converted.
                b"-colorspace" => {}
                _ => self.warn_of(option, &format!("of {statement} is not used")),
            }
        }
        let name = text(rest).trim().to_owned();
        if name.is_empty() {
            // Some exporters write an empty one for a material without a texture.
            return self.warn_of(statement.as_bytes(), "names no file: it is left out");
        }
        if is_opacity {
            return self.note(|material, line| material.opacity_map = Some((line, name)));
        }
        self.note(|material, line| (material.placement, material.texture_line) = (placement, line));
        writeln!(self.out, "map_Kd {name}").expect("memory can be written");
    }
}

/// Makes a black material white, if it has no colour of its own but that of its texture; returns
/// whether it did. Exporters write Kd 0 0 0 there, and programs show the texture.
pub(super) fn show_texture(material: &mut Material) -> bool {
    let is_unlit = material.model == LightingModel::Unlit;
    let own = if is_unlit { &mut material.emissive } else { &mut material.kd };
    let is_black = *own == DVec3::ZERO;
    if is_black {
        *own = DVec3::ONE;
    }
    is_black
}

/// Converts a material as read by `tobj`, with the defaults of the format and the effect of
/// `illum`, but without its name and `Tr`.
fn material(raw: RawMaterial) -> Material {
    let defaults = Material::default();
    let color = |c: Option<[f64; 3]>, default: DVec3| c.map_or(default, DVec3::from_array);
    let mut material = Material {
        ka: color(raw.ka, DVec3::ZERO),
        kd: color(raw.kd, if raw.map_kd.is_some() { DVec3::ONE } else { defaults.kd }),
        ks: color(raw.ks, DVec3::ZERO),
        n: raw.ns.unwrap_or(defaults.n),
        emissive: color(raw.ke, DVec3::ZERO),
        transparency: raw.d.map_or(0.0, |d| 1.0 - d),
        model: LightingModel::Blinn,
        texture: raw.map_kd,
        name: String::new(),
    };
    match raw.illum {
        Some(0) => {
            material.emissive = material.kd;
            material.model = LightingModel::Unlit;
        }
        Some(1) => material.ks = DVec3::ZERO,
        _ => {}
    }
    material
}
