//! Parsers of meshes and scenes, cameras, the model matrix, lights, materials and drawing modes.

use super::memory::rectangle;
use super::{Parsed, expect_left, light_form};
use crate::command::args::{Args, ParseError};
use crate::command::commands::{Command, FileKind, LightCommand, MeshSource, Quality};
use crate::error::Code;
use crate::memory::DepthFormat;
use crate::scene::{
    Attenuation, Cull, Filter, HiddenSurface, Interpolation, Material, ObliqueKind, Projection, Sampling,
    ShadeMode, ViewportRule, Wrap,
};
use glam::{DMat4, DVec3};

pub fn mesh(args: &mut Args<'_>) -> Parsed {
    let name = args.name()?;
    let what = args.word();
    let source = match what.to_ascii_lowercase().as_slice() {
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
            MeshSource::Teapot(if args.left() == 0 { DEFAULT_TEAPOT_LEVEL } else { args.count_number()? })
        }
        b"knot" => {
            expect_left(args, &[2], "KNOT")?;
            MeshSource::Knot(args.count_number()?, args.count_number()?)
        }
        _ => {
            let expected = "argument 2 must be OBJ, BOX, SPHERE, CONE, CYLINDER, TEAPOT or KNOT";
            return Err(ParseError::new(Code::Args, expected, what));
        }
    };
    Ok(Command::Mesh { name, source: Box::new(source) })
}

/// Subdivisions of a teapot patch per side if the line gives none.
const DEFAULT_TEAPOT_LEVEL: u32 = 10;

fn radius_and_height(args: &mut Args<'_>, what: &str) -> Result<[f64; 2], ParseError> {
    expect_left(args, &[0, 2], what)?;
    if args.left() == 0 { Ok([1.0, 2.0]) } else { args.reals() }
}

pub fn tex(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Texture { name: args.name()?, file: Vec::new() })
}

pub fn scene(args: &mut Args<'_>) -> Parsed {
    args.keyword("X3D", |word| word.eq_ignore_ascii_case("x3d").then_some(()))?;
    Ok(Command::Scene { x3d: Vec::new() })
}

pub fn eye(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Eye { name: args.name()?, json: Vec::new() })
}

pub fn free(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Free { name: args.name()? })
}

pub fn load(args: &mut Args<'_>) -> Parsed {
    let kind = args.keyword("MESH, TEX or SCENE", |word| match word.to_ascii_lowercase().as_str() {
        "mesh" => Some(FileKind::Mesh),
        "tex" => Some(FileKind::Texture),
        "scene" => Some(FileKind::Scene),
        _ => None,
    })?;
    let name = match kind {
        FileKind::Scene => {
            expect_left(args, &[1], "SCENE")?;
            String::new()
        }
        FileKind::Mesh | FileKind::Texture => {
            expect_left(args, &[2], "a named file")?;
            args.name()?
        }
    };
    Ok(Command::Load { kind, name, path: args.name()? })
}

pub fn lookat(args: &mut Args<'_>) -> Parsed {
    Ok(Command::LookAt { eye: args.vector()?, reference: args.vector()?, up: args.vector()? })
}

fn projection(projection: Projection) -> Parsed {
    Ok(Command::Projection(Box::new(projection)))
}

pub fn perspective(args: &mut Args<'_>) -> Parsed {
    let [fov_rad, near, far] = args.reals()?;
    let on_smaller_side = args.left() > 0;
    if on_smaller_side {
        args.keyword("FOVMIN", |word| word.eq_ignore_ascii_case("fovmin").then_some(()))?;
    }
    projection(Projection::Perspective { fov_rad, near, far, on_smaller_side })
}

pub fn plane(args: &mut Args<'_>) -> Parsed {
    let [d, near, far] = args.reals()?;
    projection(Projection::Plane { d, near, far })
}

pub fn frustum(args: &mut Args<'_>) -> Parsed {
    let (window, [near, far]) = (args.reals()?, args.reals()?);
    projection(Projection::Frustum { window, near, far })
}

pub fn ortho(args: &mut Args<'_>) -> Parsed {
    let (window, [near, far]) = (args.reals()?, args.reals()?);
    projection(Projection::Ortho { window, near, far })
}

pub fn oblique(args: &mut Args<'_>) -> Parsed {
    let kind = args.keyword("cavalier or cabinet", |word| match () {
        () if word.eq_ignore_ascii_case("cavalier") => Some(ObliqueKind::Cavalier),
        () if word.eq_ignore_ascii_case("cabinet") => Some(ObliqueKind::Cabinet),
        () => None,
    })?;
    let (angle_rad, window, [near, far]) = (args.real()?, args.reals()?, args.reals()?);
    projection(Projection::Oblique { kind, angle_rad, window, near, far })
}

pub fn isometric(args: &mut Args<'_>) -> Parsed {
    let (window, [near, far]) = (args.reals()?, args.reals()?);
    projection(Projection::Isometric { window, near, far })
}

pub fn pseudoiso(args: &mut Args<'_>) -> Parsed {
    let (window, [near, far]) = (args.reals()?, args.reals()?);
    projection(Projection::PseudoIsometric { window, near, far })
}

pub fn window(args: &mut Args<'_>) -> Parsed {
    let (vrp, p, vup) = (args.vector()?, args.vector()?, args.vector()?);
    let (center, half, [dp, near, far]) = (args.reals()?, args.reals()?, args.reals()?);
    projection(Projection::Window { vrp, p, vup, center, half, dp, near, far })
}

pub fn viewport(args: &mut Args<'_>) -> Parsed {
    let rect = rectangle(args)?;
    let rule = match args.left() {
        0 => ViewportRule::Corners,
        _ => args.keyword("centres or corners", |word| match () {
            () if word.eq_ignore_ascii_case("centres") => Some(ViewportRule::Centres),
            () if word.eq_ignore_ascii_case("corners") => Some(ViewportRule::Corners),
            () => None,
        })?,
    };
    Ok(Command::Viewport { rect, rule })
}

pub fn identity(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Identity)
}

pub fn push(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Push)
}

pub fn pop(_: &mut Args<'_>) -> Parsed {
    Ok(Command::Pop)
}

pub fn translate(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Translate(args.vector()?))
}

pub fn rotate(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Rotate { axis: args.vector()?, angle_rad: args.real()? })
}

pub fn scale(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Scale(args.vector()?))
}

pub fn shear(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Shear(Box::new(args.reals()?)))
}

pub fn matrix(args: &mut Args<'_>) -> Parsed {
    let rows: [[f64; 4]; 4] = [args.reals()?, args.reals()?, args.reals()?, args.reals()?];
    Ok(Command::Matrix(Box::new(DMat4::from_cols_array_2d(&rows).transpose())))
}

pub fn ambient(args: &mut Args<'_>) -> Parsed {
    let form = light_form(args, &[3], "AMBIENT r g b or its name")?;
    Ok(Command::Ambient(args.light_color(form)?))
}

fn attenuation(args: &mut Args<'_>) -> Result<Attenuation, ParseError> {
    if args.left() == 0 {
        return Ok(Attenuation::NONE);
    }
    let [c, l, q] = args.reals()?;
    Ok(Attenuation { c, l, q })
}

pub fn light(args: &mut Args<'_>) -> Parsed {
    let index = args.int()?;
    let kind = args.word();
    let light = match kind.to_ascii_lowercase().as_slice() {
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
            let [angle_rad, exponent] = args.reals()?;
            let color = args.light_color(form)?;
            LightCommand::Spot {
                position,
                direction,
                angle_rad,
                exponent,
                color,
                attenuation: attenuation(args)?,
            }
        }
        b"off" => {
            expect_left(args, &[0], "OFF")?;
            LightCommand::Off
        }
        _ => return Err(ParseError::new(Code::Args, "argument 2 must be POINT, DIR, SPOT or OFF", kind)),
    };
    Ok(Command::Light { index, light: Box::new(light) })
}

pub fn material(args: &mut Args<'_>) -> Parsed {
    let form = light_form(
        args,
        &[10, 13, 14],
        "MATERIAL ka kd ks n [emissive [transparency]], each r g b or its name",
    )?;
    let [ka, kd, ks] = [args.light_color(form)?, args.light_color(form)?, args.light_color(form)?];
    let n = args.real()?;
    let emissive = if args.left() == 0 { DVec3::ZERO } else { args.light_color(form)? };
    let transparency = if args.left() == 0 { 0.0 } else { args.real()? };
    Ok(Command::Material(Box::new(Material { ka, kd, ks, n, emissive, transparency, ..Material::default() })))
}

pub fn texture(args: &mut Args<'_>) -> Parsed {
    let name = if args.take_keyword("off") { None } else { Some(args.name()?) };
    let mut sampling = Sampling::default();
    let word = |args: &Args<'_>| String::from_utf8_lossy(args.peek()).into_owned();
    if let Some(filter) = Filter::from_keyword(&word(args)) {
        args.word();
        sampling.filter = filter;
    }
    if let Some(wrap) = Wrap::from_keyword(&word(args)) {
        args.word();
        (sampling.wrap_s, sampling.wrap_t) = (wrap, wrap);
    }
    match args.left() {
        0 => Ok(Command::UseTexture { name, sampling }),
        _ => {
            let expected = "expected nearest, bilinear, mipmap or trilinear, then repeat or clamp";
            Err(ParseError::new(Code::Args, expected, args.peek()))
        }
    }
}

pub fn shade(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Shade(args.keyword("wire, flat, gouraud or phong", ShadeMode::from_keyword)?))
}

pub fn cull(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Cull(args.keyword("back, front or none", Cull::from_keyword)?))
}

pub fn hide(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Hide(args.keyword("zbuffer, painter or none", HiddenSurface::from_keyword)?))
}

pub fn depth(args: &mut Args<'_>) -> Parsed {
    let format = args.keyword("u16, u24, u32, f32 or reversed", |word| {
        DepthFormat::ALL.into_iter().find(|f| f.as_str().eq_ignore_ascii_case(word))
    })?;
    Ok(Command::Depth(format))
}

pub fn interp(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Interp(args.keyword("perspective or affine", Interpolation::from_keyword)?))
}

pub fn draw(args: &mut Args<'_>) -> Parsed {
    Ok(Command::Draw { name: args.name()? })
}

pub fn drawscene(args: &mut Args<'_>) -> Parsed {
    let sorted = |word: &[u8]| word.eq_ignore_ascii_case(b"sorted");
    let time = if args.left() == 0 || sorted(args.peek()) { 0.0 } else { args.real()? };
    match args.left() {
        0 => Ok(Command::DrawScene { time, sorted: false }),
        1 if args.take_keyword("sorted") => Ok(Command::DrawScene { time, sorted: true }),
        _ => Err(ParseError::new(
            Code::Args,
            "after the time stands SORTED or nothing",
            args.nth_left(args.left() - 1),
        )),
    }
}

pub fn draweye(args: &mut Args<'_>) -> Parsed {
    Ok(Command::DrawEye { name: args.name()?, rect: rectangle(args)? })
}

pub fn quality(args: &mut Args<'_>) -> Parsed {
    let exact = args.keyword("exact or max-error", |word| match () {
        () if word.eq_ignore_ascii_case("exact") => Some(true),
        () if word.eq_ignore_ascii_case("max-error") => Some(false),
        () => None,
    })?;
    match exact {
        true => {
            expect_left(args, &[0], "exact")?;
            Ok(Command::Quality(Quality::Exact))
        }
        false => {
            expect_left(args, &[1], "max-error")?;
            Ok(Command::Quality(Quality::MaxError(args.real()?)))
        }
    }
}
