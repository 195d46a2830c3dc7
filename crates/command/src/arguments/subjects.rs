//! Materials, textures, the error budget, and the arguments of `DRAWSCENE`: words of which some may
//! be left out.

use super::keywords::either;
use super::{Argument, TextArgument, expect_left, finite, from_zero, light_form};
use crate::args::{Args, ParseError};
use crate::commands::Quality;
use crate::encode::{EncodeError, LineWriter};
use crate::verb::{Arity, ParameterKind};
use fbptr_core::error::{Code, Fault};
use fbptr_core::scene::{Filter, Material, MaxError, Sampling, Wrap};
use glam::DVec3;

impl Argument for Material {
    type Value = Material;
    const KIND: ParameterKind = ParameterKind::Words;
    const WORDS: Arity = Arity::at_least(4);

    fn check_numbers(m: &Material) -> Result<(), Fault> {
        [m.ka, m.kd, m.ks, m.emissive].iter().try_for_each(DVec3::check_numbers)?;
        finite(&[m.n, m.transparency])
    }

    fn write(m: &Material, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        let said = Material {
            ka: m.ka,
            kd: m.kd,
            ks: m.ks,
            n: m.n,
            emissive: m.emissive,
            transparency: m.transparency,
            ..Material::default()
        };
        if said != *m {
            return line.no_text("a material's name, texture or other equation");
        }
        line.vectors(&[m.ka, m.kd, m.ks]);
        line.reals(&[m.n]);
        line.vectors(&[m.emissive]);
        line.reals(&[m.transparency]);
        Ok(())
    }
}

impl TextArgument for Material {
    fn read(args: &mut Args<'_>) -> Result<Material, ParseError> {
        let what = "MATERIAL ka kd ks n [emissive [transparency]], each r g b or its name";
        let form = light_form(args, &[10, 13, 14], what)?;
        let [ka, kd, ks] = [args.light_color(form)?, args.light_color(form)?, args.light_color(form)?];
        let n = args.real()?;
        let emissive = if args.left() == 0 { DVec3::ZERO } else { args.light_color(form)? };
        let transparency = if args.left() == 0 { 0.0 } else { args.real()? };
        Ok(Material { ka, kd, ks, n, emissive, transparency, ..Material::default() })
    }
}

/// Filter and wrap mode; each may be left out.
impl Argument for Sampling {
    type Value = Sampling;
    const KIND: ParameterKind = ParameterKind::Words;
    const WORDS: Arity = Arity::ZERO.or(Arity::ONE).or(Arity::exactly(2));

    fn write(sampling: &Sampling, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        if sampling.wrap_s != sampling.wrap_t {
            return line.no_text("two ways of wrapping");
        }
        line.word(sampling.filter.as_str());
        line.word(sampling.wrap_s.as_str());
        Ok(())
    }
}

impl TextArgument for Sampling {
    fn read(args: &mut Args<'_>) -> Result<Sampling, ParseError> {
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
        if args.left() == 0 {
            return Ok(sampling);
        }
        let filters: Vec<&str> = Filter::ALL.iter().map(|f| f.as_str()).collect();
        let wraps: Vec<&str> = Wrap::ALL.iter().map(|w| w.as_str()).collect();
        let expected = format!("expected {}, then {}", either(&filters), either(&wraps));
        Err(ParseError::new(Code::Args, expected, args.peek()))
    }
}

impl Argument for Quality {
    type Value = Quality;
    const KIND: ParameterKind = ParameterKind::Words;
    const WORDS: Arity = Arity::ONE.or(Arity::exactly(2)).or(Arity::exactly(3));

    fn check_numbers(quality: &Quality) -> Result<(), Fault> {
        match quality {
            Quality::MaxError(most) => finite(&[most.steps, most.shift]),
            Quality::Exact => Ok(()),
        }
    }

    fn check_sizes(quality: &Quality) -> Result<(), Fault> {
        match quality {
            Quality::MaxError(most) => {
                from_zero("error", most.steps)?;
                from_zero("shift", most.shift)
            }
            Quality::Exact => Ok(()),
        }
    }

    fn write(quality: &Quality, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        match quality {
            Quality::Exact => line.word("exact"),
            Quality::MaxError(MaxError { steps, shift }) => {
                line.word("max-error");
                let numbers = [*steps, *shift];
                line.reals(if *shift > 0.0 { &numbers } else { &numbers[..1] });
            }
        }
        Ok(())
    }
}

impl TextArgument for Quality {
    fn read(args: &mut Args<'_>) -> Result<Quality, ParseError> {
        let word = args.word();
        if word.eq_ignore_ascii_case(b"exact") {
            expect_left(args, &[0], "exact")?;
            return Ok(Quality::Exact);
        }
        if !word.eq_ignore_ascii_case(b"max-error") {
            return args.refuse(Code::Args, "exact or max-error", word);
        }
        expect_left(args, &[1, 2], "max-error")?;
        let steps = args.real()?;
        let shift = if args.left() > 0 { args.real()? } else { 0.0 };
        Ok(Quality::MaxError(MaxError { steps, shift }))
    }
}

/// The time of `DRAWSCENE`, 0 unless given.
pub struct SceneTime;

impl Argument for SceneTime {
    type Value = f64;
    const KIND: ParameterKind = ParameterKind::Real;
    const WORDS: Arity = Arity::ZERO.or(Arity::ONE);

    fn check_numbers(time: &f64) -> Result<(), Fault> {
        finite(&[*time])
    }

    fn write(time: &f64, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        f64::write(time, line)
    }
}

impl TextArgument for SceneTime {
    fn read(args: &mut Args<'_>) -> Result<f64, ParseError> {
        let is_left_out = args.left() == 0 || args.peek().eq_ignore_ascii_case(b"sorted");
        if is_left_out { Ok(0.0) } else { args.real() }
    }
}

/// `SORTED` after the time, or nothing.
pub struct Sorted;

impl Argument for Sorted {
    type Value = bool;
    const KIND: ParameterKind = ParameterKind::Flag("SORTED");
    const WORDS: Arity = Arity::ZERO.or(Arity::ONE);

    fn write(sorted: &bool, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        if *sorted {
            line.word("SORTED");
        }
        Ok(())
    }
}

impl TextArgument for Sorted {
    fn read(args: &mut Args<'_>) -> Result<bool, ParseError> {
        match args.left() {
            0 => Ok(false),
            1 if args.take_keyword("sorted") => Ok(true),
            left => {
                let message = "after the time stands SORTED or nothing";
                Err(ParseError::new(Code::Args, message, args.nth_left(left - 1)))
            }
        }
    }
}
