//! Sources of meshes and kinds of lights: a word that decides about those after it.

use super::colors::not_negative;
use super::{Argument, TextArgument, expect_left, finite, from_zero, light_form};
use crate::args::{Args, ParseError};
use crate::commands::{LightCommand, MeshSource};
use crate::encode::{EncodeError, LineWriter};
use crate::verb::{Arity, ParameterKind, Payload};
use fbptr_core::error::{Code, Fault};
use fbptr_core::scene::Attenuation;
use glam::DVec3;

/// Subdivisions of a teapot patch per side if the line gives none.
const DEFAULT_TEAPOT_LEVEL: u32 = 10;

impl Argument for MeshSource {
    type Value = MeshSource;
    const KIND: ParameterKind = ParameterKind::Words;
    const WORDS: Arity = Arity::at_least(1);
    const PAYLOAD: Payload = Payload::BySubject;

    fn check_numbers(source: &MeshSource) -> Result<(), Fault> {
        match *source {
            MeshSource::Obj(_) | MeshSource::Teapot(_) | MeshSource::Knot(..) => Ok(()),
            MeshSource::Box(size) => finite(&size.to_array()),
            MeshSource::Sphere(r) => finite(&[r]),
            MeshSource::Cone(r, h) | MeshSource::Cylinder(r, h) => finite(&[r, h]),
        }
    }

    fn check_sizes(source: &MeshSource) -> Result<(), Fault> {
        match *source {
            MeshSource::Obj(_) => Ok(()),
            MeshSource::Box(size) => size.to_array().into_iter().try_for_each(|s| from_zero("side", s)),
            MeshSource::Sphere(r) => from_zero("radius", r),
            MeshSource::Cone(r, h) | MeshSource::Cylinder(r, h) => {
                from_zero("radius", r)?;
                from_zero("height", h)
            }
            MeshSource::Teapot(level) => in_i32("level", level),
            MeshSource::Knot(nu, nv) => {
                in_i32("nu", nu)?;
                in_i32("nv", nv)
            }
        }
    }

    fn payload(source: &MeshSource) -> Option<&[u8]> {
        match source {
            MeshSource::Obj(file) => Some(file),
            _ => None,
        }
    }

    fn payload_mut(source: &mut MeshSource) -> Option<&mut Vec<u8>> {
        match source {
            MeshSource::Obj(file) => Some(file),
            _ => None,
        }
    }

    fn write(source: &MeshSource, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        match *source {
            MeshSource::Obj(_) => line.word("OBJ"),
            MeshSource::Box(size) => {
                line.word("BOX");
                line.vectors(&[size]);
            }
            MeshSource::Sphere(r) => {
                line.word("SPHERE");
                line.reals(&[r]);
            }
            MeshSource::Cone(r, h) => {
                line.word("CONE");
                line.reals(&[r, h]);
            }
            MeshSource::Cylinder(r, h) => {
                line.word("CYLINDER");
                line.reals(&[r, h]);
            }
            MeshSource::Teapot(level) => {
                line.word("TEAPOT");
                line.word(level);
            }
            MeshSource::Knot(nu, nv) => {
                line.word("KNOT");
                line.word(nu);
                line.word(nv);
            }
        }
        Ok(())
    }
}

impl TextArgument for MeshSource {
    fn read(args: &mut Args<'_>) -> Result<MeshSource, ParseError> {
        let what = args.word();
        Ok(match what.to_ascii_lowercase().as_slice() {
            b"obj" => {
                expect_left(args, &[0], "OBJ")?;
                MeshSource::Obj(Vec::new())
            }
            b"box" => {
                expect_left(args, &[0, 3], "BOX")?;
                MeshSource::Box(if args.left() == 0 { DVec3::splat(2.0) } else { args.vector()? })
            }
            b"sphere" => {
                expect_left(args, &[0, 1], "SPHERE")?;
                MeshSource::Sphere(if args.left() == 0 { 1.0 } else { args.real()? })
            }
            b"cone" => {
                let [r, h] = radius_and_height(args, "CONE")?;
                MeshSource::Cone(r, h)
            }
            b"cylinder" => {
                let [r, h] = radius_and_height(args, "CYLINDER")?;
                MeshSource::Cylinder(r, h)
            }
            b"teapot" => {
                expect_left(args, &[0, 1], "TEAPOT")?;
                let level = if args.left() == 0 { DEFAULT_TEAPOT_LEVEL } else { args.count_number()? };
                MeshSource::Teapot(level)
            }
            b"knot" => {
                expect_left(args, &[2], "KNOT")?;
                MeshSource::Knot(args.count_number()?, args.count_number()?)
            }
            _ => {
                let expected = "OBJ, BOX, SPHERE, CONE, CYLINDER, TEAPOT or KNOT";
                return args.refuse(Code::Args, expected, what);
            }
        })
    }
}

fn radius_and_height(args: &mut Args<'_>, what: &str) -> Result<[f64; 2], ParseError> {
    expect_left(args, &[0, 2], what)?;
    if args.left() == 0 { Ok([1.0, 2.0]) } else { args.reals() }
}

/// Checks that a value fits in i32, as the text form requires.
fn in_i32(what: &str, value: u32) -> Result<(), Fault> {
    match i32::try_from(value) {
        Ok(_) => Ok(()),
        Err(_) => {
            Err(Fault::new(Code::Range, format!("{what} must be below 2147483648")).got(value.to_string()))
        }
    }
}

impl Argument for LightCommand {
    type Value = LightCommand;
    const KIND: ParameterKind = ParameterKind::Words;
    const WORDS: Arity = Arity::at_least(1);

    fn check_numbers(light: &LightCommand) -> Result<(), Fault> {
        let vectors = |vectors: &[DVec3]| vectors.iter().try_for_each(DVec3::check_numbers);
        let fading = |a: &Attenuation| finite(&[a.c, a.l, a.q]);
        match light {
            LightCommand::Point { position, color, attenuation } => {
                vectors(&[*position, *color])?;
                fading(attenuation)
            }
            LightCommand::Dir { direction, color } => vectors(&[*direction, *color]),
            LightCommand::Spot { position, direction, angle_rad, exponent, color, attenuation } => {
                vectors(&[*position, *direction, *color])?;
                finite(&[*angle_rad, *exponent])?;
                fading(attenuation)
            }
            LightCommand::Off => Ok(()),
        }
    }

    fn check_sizes(light: &LightCommand) -> Result<(), Fault> {
        match light {
            LightCommand::Point { color, .. }
            | LightCommand::Dir { color, .. }
            | LightCommand::Spot { color, .. } => not_negative(*color),
            LightCommand::Off => Ok(()),
        }
    }

    fn write(light: &LightCommand, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        match *light {
            LightCommand::Point { position, color, attenuation } => {
                line.word("POINT");
                line.vectors(&[position, color]);
                write_attenuation(attenuation, line);
            }
            LightCommand::Dir { direction, color } => {
                line.word("DIR");
                line.vectors(&[direction, color]);
            }
            LightCommand::Spot { position, direction, angle_rad, exponent, color, attenuation } => {
                line.word("SPOT");
                line.vectors(&[position, direction]);
                line.reals(&[angle_rad, exponent]);
                line.vectors(&[color]);
                write_attenuation(attenuation, line);
            }
            LightCommand::Off => line.word("OFF"),
        }
        Ok(())
    }
}

impl TextArgument for LightCommand {
    fn read(args: &mut Args<'_>) -> Result<LightCommand, ParseError> {
        let kind = args.word();
        Ok(match kind.to_ascii_lowercase().as_slice() {
            b"point" => {
                let form = light_form(args, &[6, 9], "POINT")?;
                let (position, color) = (args.vector()?, args.light_color(form)?);
                LightCommand::Point { position, color, attenuation: attenuation(args)? }
            }
            b"dir" => {
                let form = light_form(args, &[6], "DIR")?;
                LightCommand::Dir { direction: args.vector()?, color: args.light_color(form)? }
            }
            b"spot" => {
                let form = light_form(args, &[11, 14], "SPOT")?;
                let (position, direction) = (args.vector()?, args.vector()?);
                let (angle_rad, exponent) = (args.angle()?, args.real()?);
                let color = args.light_color(form)?;
                let attenuation = attenuation(args)?;
                LightCommand::Spot { position, direction, angle_rad, exponent, color, attenuation }
            }
            b"off" => {
                expect_left(args, &[0], "OFF")?;
                LightCommand::Off
            }
            _ => return args.refuse(Code::Args, "POINT, DIR, SPOT or OFF", kind),
        })
    }
}

fn attenuation(args: &mut Args<'_>) -> Result<Attenuation, ParseError> {
    if args.left() == 0 {
        return Ok(Attenuation::NONE);
    }
    let [c, l, q] = args.reals()?;
    Ok(Attenuation { c, l, q })
}

/// Appends an attenuation, unless it is the default.
fn write_attenuation(a: Attenuation, line: &mut LineWriter<'_>) {
    if a != Attenuation::NONE {
        line.reals(&[a.c, a.l, a.q]);
    }
}
