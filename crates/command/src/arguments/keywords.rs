//! Keywords: closed lists of words, in either case.
//!
//! The words stand here or with their type, and nowhere else: what a refused line was expected to
//! have is put together from them.

use super::{Argument, TextArgument};
use crate::args::{Args, ParseError};
use crate::commands::{ErrorMode, FileKind};
use crate::encode::{EncodeError, LineWriter};
use crate::verb::{Arity, ParameterKind};
use fbptr_core::error::Code;
use fbptr_core::memory::DepthFormat;
use fbptr_core::scene::{Cull, HiddenSurface, Interpolation, ObliqueKind, ShadeMode, ViewportRule};

/// A kind of argument that is one of a list of words.
pub(super) trait Keyword {
    /// Type of the field.
    type Value: Copy + PartialEq + 'static;
    /// The words and their values.
    const LIST: &'static [(&'static str, Self::Value)];
    /// The words alone.
    const NAMES: &'static [&'static str];

    /// Takes a word of the list.
    fn take(args: &mut Args<'_>) -> Result<Self::Value, ParseError> {
        let word = args.word();
        let found = Self::LIST.iter().find(|(keyword, _)| keyword.as_bytes().eq_ignore_ascii_case(word));
        match found {
            Some((_, value)) => Ok(*value),
            None => args.refuse(Code::Args, &either(Self::NAMES), word),
        }
    }

    /// Returns the word of a value.
    fn word(value: Self::Value) -> &'static str {
        Self::LIST.iter().find(|(_, listed)| *listed == value).map_or("", |(word, _)| *word)
    }
}

/// Joins words as in `wire, flat, gouraud or phong`.
pub(super) fn either(words: &[&str]) -> String {
    match words {
        [others @ .., last] if !others.is_empty() => format!("{} or {last}", others.join(", ")),
        words => words.concat(),
    }
}

/// Returns the words of a list of `N`.
const fn names<T: Copy, const N: usize>(list: &[(&'static str, T)]) -> [&'static str; N] {
    let (mut names, mut i) = ([""; N], 0);
    while i < N {
        names[i] = list[i].0;
        i += 1;
    }
    names
}

/// Makes a list of words an argument.
macro_rules! keyword {
    ($(#[$doc:meta])* $kind:ty: $value:ty = $list:expr) => {
        $(#[$doc])*
        impl Keyword for $kind {
            type Value = $value;
            const LIST: &'static [(&'static str, $value)] = $list;
            const NAMES: &'static [&'static str] =
                &names::<$value, { <$kind as Keyword>::LIST.len() }>(<$kind as Keyword>::LIST);
        }

        impl Argument for $kind {
            type Value = $value;
            const KIND: ParameterKind = ParameterKind::Keyword(<$kind as Keyword>::NAMES);
            const WORDS: Arity = Arity::ONE;

            fn write(value: &$value, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
                line.word(<$kind as Keyword>::word(*value));
                Ok(())
            }
        }

        impl TextArgument for $kind {
            fn read(args: &mut Args<'_>) -> Result<$value, ParseError> {
                <$kind as Keyword>::take(args)
            }
        }
    };
}

/// Makes an enum with `ALL` and `as_str` an argument.
macro_rules! mode {
    ($($mode:ty),*) => {$(
        keyword! {
            $mode: $mode = &{
                let (mut list, mut i) = ([("", <$mode>::ALL[0]); <$mode>::ALL.len()], 0);
                while i < list.len() {
                    list[i] = (<$mode>::ALL[i].as_str(), <$mode>::ALL[i]);
                    i += 1;
                }
                list
            }
        }
    )*};
}

mode!(ShadeMode, Cull, HiddenSurface, Interpolation, DepthFormat);

keyword! {
    ErrorMode: ErrorMode =
        &[("count", ErrorMode::Count), ("report", ErrorMode::Report), ("close", ErrorMode::Close)]
}
keyword! {
    ObliqueKind: ObliqueKind = &[("cavalier", ObliqueKind::Cavalier), ("cabinet", ObliqueKind::Cabinet)]
}
keyword! {
    FileKind: FileKind = &[("MESH", FileKind::Mesh), ("TEX", FileKind::Texture), ("SCENE", FileKind::Scene)]
}

/// `on` or `off`.
pub struct OnOff;

keyword! {
    OnOff: bool = &[("on", true), ("off", false)]
}

/// The mode of `BLEND`; true is `over`.
pub struct BlendOver;

keyword! {
    BlendOver: bool = &[("replace", false), ("over", true)]
}

/// Makes a word that may be left out an argument.
macro_rules! flag {
    ($(#[$doc:meta])* $kind:ident = $word:literal) => {
        $(#[$doc])*
        pub struct $kind;

        impl Argument for $kind {
            type Value = bool;
            const KIND: ParameterKind = ParameterKind::Flag($word);
            const WORDS: Arity = Arity::ZERO.or(Arity::ONE);

            fn write(value: &bool, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
                if *value {
                    line.word($word);
                }
                Ok(())
            }
        }

        impl TextArgument for $kind {
            fn read(args: &mut Args<'_>) -> Result<bool, ParseError> {
                match args.left() {
                    0 => Ok(false),
                    _ => take_keyword(args, $word).map(|()| true),
                }
            }
        }
    };
}

flag! {
    /// `wait`, or nothing.
    Wait = "wait"
}
flag! {
    /// `FOVMIN`, or nothing.
    FovMin = "FOVMIN"
}

/// Takes this word.
pub(super) fn take_keyword(args: &mut Args<'_>, keyword: &'static str) -> Result<(), ParseError> {
    let word = args.word();
    match word.eq_ignore_ascii_case(keyword.as_bytes()) {
        true => Ok(()),
        false => args.refuse(Code::Args, keyword, word),
    }
}

/// The rule of a viewport, `corners` unless given.
pub struct ViewportKind;

impl Keyword for ViewportKind {
    type Value = ViewportRule;
    const LIST: &'static [(&'static str, ViewportRule)] =
        &[("centres", ViewportRule::Centres), ("corners", ViewportRule::Corners)];
    const NAMES: &'static [&'static str] = &names::<ViewportRule, 2>(Self::LIST);
}

impl Argument for ViewportKind {
    type Value = ViewportRule;
    const KIND: ParameterKind = ParameterKind::Keyword(<Self as Keyword>::NAMES);
    const WORDS: Arity = Arity::ZERO.or(Arity::ONE);

    fn write(rule: &ViewportRule, line: &mut LineWriter<'_>) -> Result<(), EncodeError> {
        if *rule == ViewportRule::Centres {
            line.word(<Self as Keyword>::word(*rule));
        }
        Ok(())
    }
}

impl TextArgument for ViewportKind {
    fn read(args: &mut Args<'_>) -> Result<ViewportRule, ParseError> {
        if args.left() == 0 { Ok(ViewportRule::Corners) } else { <Self as Keyword>::take(args) }
    }
}
