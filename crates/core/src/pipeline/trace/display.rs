//! Text form of a trace: stage by stage, each number in full precision.

use super::{CornerTrace, FastTrace, LitAt, PixelTrace, Texel, Trace};
use crate::pipeline::sampler::Footprint;
use crate::scene::LightingModel;
use glam::{DMat4, DVec2, DVec3, DVec4};
use std::fmt::{self, Display, Formatter};

/// Numbers in parentheses, each in full f64 precision.
struct Numbers<'a>(&'a [f64]);

impl Display for Numbers<'_> {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        f.write_str("(")?;
        for (i, v) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str(", ")?;
            }
            number(f, *v)?;
        }
        f.write_str(")")
    }
}

/// Writes the shortest digits that parse to the same number, with an exponent if very large or
/// small.
fn number(f: &mut Formatter<'_>, v: f64) -> fmt::Result {
    let size = v.abs();
    match v == 0.0 || !v.is_finite() || (1e-5..1e16).contains(&size) {
        true => write!(f, "{}", v + 0.0),
        false => write!(f, "{v:e}"),
    }
}

fn v3(v: DVec3) -> [f64; 3] {
    v.to_array()
}

fn v4(v: DVec4) -> [f64; 4] {
    v.to_array()
}

/// Writes a matrix in four rows.
fn matrix(f: &mut Formatter<'_>, name: &str, m: DMat4) -> fmt::Result {
    for row in 0..4 {
        let name = if row == 0 { name } else { "" };
        writeln!(f, "  {name:<12}{}", Numbers(&v4(m.row(row))))?;
    }
    Ok(())
}

impl Display for Trace {
    fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
        let (object, name) = &self.object;
        let [width, height] = self.frame;
        writeln!(
            f,
            "triangle {} of object {object} {name:?} (polygon {}), frame {width}x{height}, {}",
            self.triangle.0,
            self.triangle.1,
            format!("{:?}", self.shade).to_lowercase(),
        )?;
        writeln!(f, "\nmatrices (rows; columns are multiplied from the right)")?;
        matrix(f, "model", self.model)?;
        matrix(f, "view", self.camera.view)?;
        matrix(f, "projection", self.camera.projection)?;
        if let Some(t) = &self.viewing {
            for (name, m) in [("A", t.a), ("B", t.b), ("C", t.c), ("D", t.d), ("P", t.p)] {
                matrix(f, name, m)?;
            }
        }
        matrix(f, "M1 (clip)", self.m1())?;
        matrix(f, "M2 (screen)", self.to_screen)?;
        for (i, corner) in self.corners.iter().enumerate() {
            write_corner(f, i, corner)?;
        }
        writeln!(f, "\nclipped by the six planes: {} corners in clip space", self.clipped.len())?;
        for p in &self.clipped {
            writeln!(f, "              {}", Numbers(&v4(*p)))?;
        }
        writeln!(f, "\nface")?;
        if let Some(area) = self.doubled_area {
            let turn = match area.signum() {
                -1 => "counter-clockwise",
                1 => "clockwise",
                _ => "nothing",
            };
            write!(f, "  2 x area    {area} in 1/65536 pixel^2 = ")?;
            number(f, area as f64 / 65536.0)?;
            writeln!(f, " pixel^2: {turn} as seen")?;
        }
        writeln!(f, "  verdict     {}", self.verdict)?;
        writeln!(f, "  normal      {}", Numbers(&v3(self.face_normal)))?;
        if let Some(plane) = self.eye_plane() {
            let side = match plane.w {
                d if d > 0.0 => "D > 0: the eye is in front of it",
                d if d < 0.0 => "D < 0: the eye is behind it",
                _ => "D = 0: the eye is in it",
            };
            writeln!(f, "  A, B, C, D  {} of its plane in eye space; {side}", Numbers(&v4(plane)))?;
        }
        let m = &self.material;
        writeln!(f, "  material    Ka {} Kd {}", Numbers(&v3(m.ka)), Numbers(&v3(m.kd)))?;
        write!(f, "              Ks {} n ", Numbers(&v3(m.ks)))?;
        number(f, m.n)?;
        writeln!(f, " Ke {}", Numbers(&v3(m.emissive)))?;
        match &self.pixel {
            Some(pixel) => write_pixel(f, pixel, self)?,
            None => writeln!(f, "\nno pixel of it is drawn")?,
        }
        self.fast.as_ref().map_or(Ok(()), |fast| write_fast(f, fast))
    }
}

fn write_corner(f: &mut Formatter<'_>, i: usize, c: &CornerTrace) -> fmt::Result {
    writeln!(f, "\ncorner {i} (position {})", c.position)?;
    writeln!(f, "  object      {}", Numbers(&v3(c.object)))?;
    writeln!(f, "  world       {}", Numbers(&v3(c.world)))?;
    writeln!(f, "  eye         {}", Numbers(&v3(c.view)))?;
    writeln!(f, "  clip        {}", Numbers(&v4(c.clip)))?;
    match c.clip.w > 0.0 {
        true => writeln!(f, "  NDC         {}", Numbers(&v3(c.ndc)))?,
        false => writeln!(f, "  NDC         none: w is not above 0, the corner lies behind the eye")?,
    }
    if c.screen.iter().all(|v| v.is_finite()) {
        writeln!(f, "  screen      {}", Numbers(&c.screen))?;
    }
    if let Some([x, y]) = c.snapped {
        writeln!(f, "  snapped     ({x}, {y}) / 256 = {}", Numbers(&[x as f64 / 256.0, y as f64 / 256.0]))?;
    }
    writeln!(f, "  normal      {}", Numbers(&v3(c.normal)))?;
    match c.texcoord {
        Some(uv) => writeln!(f, "  u, v        {}", Numbers(&[uv.x, uv.y])),
        None => Ok(()),
    }
}

fn write_pixel(f: &mut Formatter<'_>, p: &PixelTrace, trace: &Trace) -> fmt::Result {
    let [x, y] = p.at;
    let center = [f64::from(x) + 0.5, f64::from(y) + 0.5];
    writeln!(f, "\npixel ({x}, {y})")?;
    writeln!(f, "  centre      {} = NDC {}", Numbers(&center), Numbers(&p.ndc))?;
    if let Some(edges) = p.edges {
        let list = edges.map(|e| e.to_string()).join(", ");
        writeln!(f, "  edges       ({list}) in 1/65536 pixel^2, inside positive")?;
    }
    let covered = if p.is_covered { "covered" } else { "not covered: the rest is of the face's plane" };
    writeln!(f, "  coverage    {covered}")?;
    writeln!(f, "  on screen   {}", Numbers(&p.screen_weights))?;
    writeln!(f, "  perspective {}", Numbers(&p.weights))?;
    write!(f, "  1/w         ")?;
    number(f, p.inverse_w)?;
    if p.inverse_w != 0.0 {
        write!(f, ", w ")?;
        number(f, 1.0 / p.inverse_w)?;
    }
    write!(f, "\n  depth       ")?;
    number(f, p.z)?;
    write!(f, " stored as {} ({:?}) = ", p.depth_word, p.depth_format)?;
    number(f, p.depth_format.decode(p.depth_word))?;
    writeln!(f)?;
    if let Some(normal) = p.normal {
        write!(f, "  normal      {} of length ", Numbers(&v3(normal)))?;
        number(f, normal.length())?;
        writeln!(f)?;
    }
    for lit in &p.lit {
        write_light(f, lit, trace)?;
    }
    if let Some(t) = &p.texel {
        write!(f, "  texture     {}x{} at {}, level ", t.size[0], t.size[1], Numbers(&[t.uv.x, t.uv.y]))?;
        number(f, t.level)?;
        writeln!(f, ": {}", Numbers(&t.color))?;
        write_footprint(f, t)?;
    }
    writeln!(f, "  colour      {}", Numbers(&v3(p.color)))?;
    if p.opacity < 1.0 {
        write!(f, "  opacity     ")?;
        number(f, p.opacity)?;
        writeln!(f, ": the bytes are over black")?;
    }
    let [r, g, b, a] = p.bytes;
    let place = p.offset.map_or("off the frame".to_owned(), |o| o.to_string());
    writeln!(f, "  bytes       {r} {g} {b} {a} = #{r:02x}{g:02x}{b:02x} at {place}")
}

/// Writes the derivatives that the level follows from.
fn write_footprint(f: &mut Formatter<'_>, t: &Texel) -> fmt::Result {
    let Footprint::Steps(right, down) = t.footprint else {
        return writeln!(f, "    steps     a neighbour lies beyond the horizon of the face's plane");
    };
    let size = DVec2::new(t.size[0].into(), t.size[1].into());
    let steps = [right, down].map(|step| Numbers(&[step.x, step.y]).to_string());
    writeln!(f, "    steps     {} to the right, {} down, in u, v", steps[0], steps[1])?;
    let lengths = [right, down].map(|step| (step * size).length());
    writeln!(f, "    texels    {} long: D = log2 of the longer", Numbers(&lengths))
}

fn write_light(f: &mut Formatter<'_>, lit: &LitAt, trace: &Trace) -> fmt::Result {
    let blinn = trace.material.model == LightingModel::Blinn;
    let (mirror, cosine) = if blinn { ("H", "N.H") } else { ("R", "R.V") };
    writeln!(f, "  light at {}", lit.place)?;
    writeln!(f, "    P         {}", Numbers(&v3(lit.point.position)))?;
    writeln!(f, "    N         {}", Numbers(&v3(lit.point.normal)))?;
    writeln!(f, "    V         {}", Numbers(&v3(lit.to_viewer)))?;
    let ambient = trace.material.ka * trace.ambient;
    writeln!(f, "    ambient   {} = Ka Ia", Numbers(&v3(ambient)))?;
    for (i, t) in lit.terms.iter().enumerate() {
        write!(f, "    light {i}   L {}, strength ", Numbers(&v3(t.to_light)))?;
        number(f, t.strength)?;
        write!(f, ", N.L ")?;
        number(f, t.n_dot_l)?;
        writeln!(f)?;
        if t.ambient != DVec3::ZERO {
            writeln!(f, "      ambient {}", Numbers(&v3(t.ambient)))?;
        }
        writeln!(f, "      diffuse {} = strength Kd N.L Il", Numbers(&v3(t.diffuse)))?;
        if let Some(m) = t.mirror {
            write!(f, "      {mirror}       {}, {cosine} ", Numbers(&v3(m)))?;
            number(f, t.cosine)?;
            write!(f, ", to the power n ")?;
            number(f, t.power)?;
            writeln!(f, "\n      highlight {}", Numbers(&v3(t.specular)))?;
        }
    }
    writeln!(
        f,
        "    sum       {} + {}",
        Numbers(&v3(lit.diffuse_ambient)),
        Numbers(&v3(lit.specular_emissive))
    )
}

fn write_fast(f: &mut Formatter<'_>, fast: &FastTrace) -> fmt::Result {
    writeln!(f, "\nthe fast path")?;
    if let Some(reason) = fast.unsupported_reason {
        writeln!(f, "  leaves it to the plain one: {reason}")?;
    }
    for (i, c) in fast.corners.iter().enumerate() {
        match c.inverse_w == 0.0 {
            true => writeln!(f, "  corner {i}    beyond what a record holds: set up in f64")?,
            false => {
                let [x, y] = c.position_fixed;
                let pixels = [f64::from(x) / 65536.0, f64::from(y) / 65536.0];
                writeln!(
                    f,
                    "  corner {i}    ({x}, {y}) / 65536 = {}, z {}, 1/w {}",
                    Numbers(&pixels),
                    c.z,
                    c.inverse_w
                )?;
            }
        }
    }
    match fast.stored {
        None => writeln!(f, "  stored      nothing at this pixel"),
        Some((z, [r, g, b, a])) => {
            write!(f, "  stored      ")?;
            if let Some(z) = z {
                write!(f, "depth {z}, ")?;
            }
            writeln!(f, "bytes {r} {g} {b} {a} = #{r:02x}{g:02x}{b:02x}")
        }
    }
}
