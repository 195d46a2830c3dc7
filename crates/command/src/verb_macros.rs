//! The macros that turn the verb table into code: the enums of commands, their parsers, checks and
//! encoders, and the rows that HELP and other programs read.
//!
//! In: blocks of rows, one a verb:
//!
//! ```text
//! Group Encoding Enum {
//!     VERB Variant { field["words"]: Type = Kind, ... } = fn name with pass = function -> Reply in clip:
//!         "about" eg "example";
//! }
//! ```
//!
//! - `Variant { .. }`, `Variant(..)` or `Variant`: the variant of `Enum` that the verb makes;
//!   several are separated by `|`, the first one that takes the line's number of words is read.
//! - `["words"]`: the argument's words in the syntax, by default the field's name.
//! - `= Kind`: the [`Argument`](super::arguments::Argument) that reads, checks and writes the
//!   field, by default its type.
//! - `= fn name`: the function that does it, called with the fields: of a figure, a method of
//!   [`FigureTarget`](fbptr_core::draw2d::FigureTarget); of another command, one of the engine.
//!   `= job name` if it only makes a job, whose result is what is recorded. The rows of projections
//!   have none. Its name is also that of the verb's method of `Client`, and of `Framebuffer` if it
//!   is a figure, unless that is written by hand ([`super::methods`]).
//! - `with pass = function`: a function in place of one pass of [`Codec`](super::codec::Codec), for
//!   what depends on several arguments.
//! - `-> Reply`: a variant of [`Reply`](super::verb::Reply), by default `Never`.
//! - `in target`: the verb reads or writes the connection's target; `in clip`: it draws there, within
//!   the clip rectangle; by default it does neither. See [`Reach`](super::verb::Reach).
//! - `"about"`: one line for HELP; or `["syntax": "about", ...]` for a verb of several forms.
//! - `eg "example"`: a valid command with its payload.
//!
//! Out, by `language!`: the enums `Command` and `Figure` with `Codec`, `Codec` for `Projection`,
//! the static tables `TABLE`, `PARSERS` and `PLAIN`.

/// The kind of a field: the one that its row names, or its type.
macro_rules! kind {
    ($type:ty) => {
        $type
    };
    ($type:ty, $kind:ty) => {
        $kind
    };
}

/// Command that contains a value of one of the enums.
macro_rules! wrap {
    (Command, $value:expr) => {
        $value
    };
    (Figure, $value:expr) => {
        Command::Figure($value)
    };
    (Projection, $value:expr) => {
        Command::Projection(Box::new($value))
    };
}

/// Words of an argument in the syntax.
macro_rules! words {
    ($field:ident []) => {
        stringify!($field)
    };
    ($field:ident [$words:literal]) => {
        $words
    };
}

/// Forms of a verb.
macro_rules! forms {
    ([$verb:ident $($field:ident $words:tt)*] $about:literal) => {
        &[Form { syntax: concat!(stringify!($verb) $(, " ", words!($field $words))*), about: $about }]
    };
    ($derived:tt [$($syntax:literal : $about:literal),* $(,)?]) => {
        &[$(Form { syntax: $syntax, about: $about }),*]
    };
}

/// Documentation of a variant: its verb's forms.
macro_rules! variant_doc {
    ([$verb:ident $($field:ident $words:tt)*] $about:literal) => {
        concat!("`", stringify!($verb) $(, " ", words!($field $words))*, "`: ", $about)
    };
    ($derived:tt [$($syntax:literal : $about:literal),* $(,)?]) => {
        concat!($("`", $syntax, "`: ", $about, "\n\n"),*)
    };
}

/// Reply of a verb.
macro_rules! reply {
    () => {
        Reply::Never
    };
    ($reply:ident) => {
        Reply::$reply
    };
}

/// Reach of a verb.
macro_rules! reach {
    () => {
        Reach::Connection
    };
    (target) => {
        Reach::Target
    };
    (clip) => {
        Reach::Clip
    };
}

/// Parameters of the first variant.
macro_rules! first {
    ([$($first:tt)*] $($others:tt)*) => { &[$($first)*] };
}

/// Reads the arguments of the first variant that takes the line's number of words.
macro_rules! read_variant {
    ($args:ident $target:ident $variant:ident
        $({ $($f:ident : $t:ty $(= $k:ty)?),* })? $(( $($g:ident : $u:ty $(= $l:ty)?),* ))?
    ) => {{
        $($( <kind!($t $(, $k)?) as TextArgument>::expect($args)?; )*)?
        $($( <kind!($u $(, $l)?) as TextArgument>::expect($args)?; )*)?
        Ok(wrap!($target, $target::$variant
            $({ $($f: <kind!($t $(, $k)?) as TextArgument>::read($args)?),* })?
            $(( $(<kind!($u $(, $l)?) as TextArgument>::read($args)?),* ))?
        ))
    }};
    ($args:ident $target:ident $variant:ident
        $({ $($f:ident : $t:ty $(= $k:ty)?),* })? $(( $($g:ident : $u:ty $(= $l:ty)?),* ))?
        | $($others:tt)+
    ) => {{
        const ARITY: Arity = Arity::ZERO
            $($(.plus(<kind!($t $(, $k)?) as Argument>::WORDS))*)?
            $($(.plus(<kind!($u $(, $l)?) as Argument>::WORDS))*)?;
        if ARITY.allows($args.count()) {
            read_variant!($args $target $variant
                $({ $($f: $t $(= $k)?),* })? $(( $($g: $u $(= $l)?),* ))?)
        } else {
            read_variant!($args $target $($others)+)
        }
    }};
}

/// Parser of a verb, `None` for a binary one.
macro_rules! parser {
    (Binary $target:ident $($variants:tt)*) => { None };
    (Text $target:ident $($variants:tt)*) => {{
        #[allow(unused_variables, reason = "some verbs take no arguments")]
        fn parse(args: &mut Args<'_>) -> Result<Command, ParseError> {
            read_variant!(args $target $($variants)*)
        }
        Some(parse as Parse<Command>)
    }};
}

/// Reader of a figure's plain lines, `None` for other verbs. A value that a check would refuse is left to
/// the parser.
macro_rules! plain_reader {
    (Text Figure $variant:ident { $($f:ident : $t:ty $(= $k:ty)?),* }) => {{
        fn read(words: &mut PlainWords<'_>) -> Option<Figure> {
            $(
                let $f = <kind!($t $(, $k)?) as TextArgument>::read_plain(words)?;
                if <kind!($t $(, $k)?) as Argument>::check_sizes(&$f).is_err()
                    || <kind!($t $(, $k)?) as Argument>::check_content(&$f).is_err()
                {
                    return None;
                }
            )*
            Some(Figure::$variant { $($f),* })
        }
        Some(read as ReadPlain<Figure>)
    }};
    ($($other:tt)*) => { None };
}

/// The static tables `TABLE`, `PARSERS` and `PLAIN`, one element a verb.
macro_rules! table {
    ($( $group:ident $encoding:ident $target:ident {$(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            $(= $way:ident $function:ident)?
            $(with $($pass:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)? $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*} )*) => {
        /// All verbs, in the order of HELP.
        pub(crate) static TABLE: &[Verb] = &[$($(
            Verb {
                name: stringify!($verb),
                group: Group::$group,
                arity: Arity::NEVER $(.or(Arity::ZERO
                    $($(.plus(<kind!($t $(, $k)?) as Argument>::WORDS))*)?
                    $($(.plus(<kind!($u $(, $l)?) as Argument>::WORDS))*)?
                ))+,
                payload: Payload::Never $(
                    $($(.and(<kind!($t $(, $k)?) as Argument>::PAYLOAD))*)?
                    $($(.and(<kind!($u $(, $l)?) as Argument>::PAYLOAD))*)?
                )+,
                reply: reply!($($reply)?),
                reach: reach!($($reach)?),
                example: $example,
                forms: forms!([$verb $($($($f [$($w)?])*)? $($($g [$($x)?])*)?)+] $forms),
                parameters: first!($([
                    $($(parameter::<kind!($t $(, $k)?)>(stringify!($f), words!($f [$($w)?])),)*)?
                    $($(parameter::<kind!($u $(, $l)?)>(stringify!($g), words!($g [$($x)?])),)*)?
                ])+),
                encoding: Encoding::$encoding,
            },
        )*)*];

        /// Parsers of the verbs, by their place in `TABLE`.
        pub(crate) static PARSERS: &[Option<Parse<Command>>] = &[$($(
            parser!($encoding $target $($variant
                $({ $($f: $t $(= $k)?),* })? $(( $($g: $u $(= $l)?),* ))?
            )|+),
        )*)*];

        /// Readers of the verbs' plain lines, by their place in `TABLE`.
        pub(crate) static PLAIN: &[Option<ReadPlain<Figure>>] = &[$($(
            plain_reader!($encoding $target $($variant
                $({ $($f: $t $(= $k)?),* })? $(( $($g: $u $(= $l)?),* ))?
            )|+),
        )*)*];
    };
}

/// An enum with one variant a row, and the variants `nested`, which hold other enums.
macro_rules! command_enum {
    ($(#[$attribute:meta])* $target:ident [$($nest:ident ($nested:ty) = fn $runs:ident),*] $(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            $(= $way:ident $function:ident)?
            $(with $($pass:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)? $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*) => {
        $(#[$attribute])*
        #[derive(Clone, Debug, PartialEq)]
        #[allow(missing_docs, reason = "fields carry the names of the text form in each variant's doc")]
        pub enum $target {
            $($(
                #[doc = variant_doc!([$verb $($($f [$($w)?])*)? $($($g [$($x)?])*)?] $forms)]
                $variant $({ $($f: $t),* })? $(( $($u),* ))?,
            )+)*
            $(
                #[doc = concat!("The verbs of [`", stringify!($nest), "`].")]
                $nest($nested),
            )*
        }
    };
}

/// Calls a function with a value and the further arguments of a pass.
macro_rules! call {
    ([$($function:tt)*] $value:ident ()) => { $($function)*($value) };
    ([$($function:tt)*] $value:ident ($more:ident)) => { $($function)*($value, $more) };
}

/// Calls a method of a nested enum with the further arguments of a pass.
macro_rules! call_nested {
    ($nested:ident $pass:ident ()) => {
        $nested.$pass()
    };
    ($nested:ident $pass:ident ($more:ident)) => {
        $nested.$pass($more)
    };
}

/// The function in place of a pass, or the pass itself.
macro_rules! hooked {
    ($pass:ident $me:ident $more:tt [] $default:block) => { $default };
    (check_names $me:ident $more:tt [check_names = $hook:ident $($others:tt)*] $default:block) => {
        call!([$hook] $me $more)
    };
    (check_length $me:ident $more:tt [check_length = $hook:ident $($others:tt)*] $default:block) => {
        call!([$hook] $me $more)
    };
    (write $me:ident $more:tt [write = $hook:ident $($others:tt)*] $default:block) => {
        call!([$hook] $me $more)
    };
    ($pass:ident $me:ident $more:tt [$other:ident = $hook:ident $(, $($others:tt)+)?] $default:block) => {
        hooked!($pass $me $more [$($($others)+)?] $default)
    };
}

/// A method of `Codec` that calls the method of its name of every argument in order, with the
/// value and `more`.
macro_rules! pass {
    ($pass:ident($me:ident $(, $name:ident : $type:ty)?) $more:tt -> $error:ty;
        $target:ident [$($nest:ident ($nested:ty) = fn $runs:ident),*] $(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            $(= $way:ident $function:ident)?
            $(with $($hooked:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)? $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*) => {
        #[allow(unused_variables, reason = "some verbs take no arguments, or have a function of their own")]
        fn $pass(&$me $(, $name: $type)?) -> Result<(), $error> {
            match $me {
                $($( $target::$variant $({ $($f),* })? $(( $($g),* ))? => {
                    hooked!($pass $me $more [$($($hooked = $hook),+)?] {
                        $($( call!([<kind!($t $(, $k)?) as Argument>::$pass] $f $more)?; )*)?
                        $($( call!([<kind!($u $(, $l)?) as Argument>::$pass] $g $more)?; )*)?
                        Ok(())
                    })
                } )+)*
                $( $target::$nest(nested) => call_nested!(nested $pass $more), )*
            }
        }
    };
}

/// A method of `Codec` that returns the first argument's payload.
macro_rules! payload_of {
    ($payload:ident($me:ident : $borrowed:ty) -> $bytes:ty;
        $target:ident [$($nest:ident ($nested:ty) = fn $runs:ident),*] $(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            $(= $way:ident $function:ident)?
            $(with $($hooked:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)? $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*) => {
        #[allow(unused_variables, reason = "some verbs take no arguments")]
        #[allow(clippy::needless_arbitrary_self_type, reason = "the macro is given the whole type")]
        fn $payload($me: $borrowed) -> Option<$bytes> {
            match $me {
                $($( $target::$variant $({ $($f),* })? $(( $($g),* ))? => {
                    None
                        $($( .or(<kind!($t $(, $k)?) as Argument>::$payload($f)) )*)?
                        $($( .or(<kind!($u $(, $l)?) as Argument>::$payload($g)) )*)?
                } )+)*
                $( $target::$nest(nested) => nested.$payload(), )*
            }
        }
    };
}

/// The method `Codec::verb`.
macro_rules! verb_of {
    ($target:ident [$($nest:ident ($nested:ty) = fn $runs:ident),*] $(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            $(= $way:ident $function:ident)?
            $(with $($hooked:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)? $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*) => {
        fn verb(&self) -> &'static str {
            match self {
                $($( $target::$variant { .. } => stringify!($verb), )+)*
                $( $target::$nest(nested) => nested.verb(), )*
            }
        }
    };
}

/// `Codec` for an enum.
macro_rules! codec {
    ($target:ident $($rows:tt)*) => {
        impl Codec for $target {
            verb_of! { $target $($rows)* }
            payload_of! { payload(self: &Self) -> &[u8]; $target $($rows)* }
            payload_of! { payload_mut(self: &mut Self) -> &mut Vec<u8>; $target $($rows)* }
            pass! { check_numbers(self) () -> Fault; $target $($rows)* }
            pass! { check_sizes(self) () -> Fault; $target $($rows)* }
            pass! { check_names(self) () -> Fault; $target $($rows)* }
            pass! { check_length(self, length: u64) (length) -> Fault; $target $($rows)* }
            pass! { check_content(self) () -> Fault; $target $($rows)* }
            pass! { write(self, line: &mut LineWriter<'_>) (line) -> EncodeError; $target $($rows)* }
        }
    };
}

/// Sorts the blocks by their enum, keeping the order, and defines the enums.
macro_rules! enums {
    ([$($c:tt)*] $f:tt $p:tt $nested:tt Command { $($rows:tt)* } $($blocks:tt)*) => {
        enums! { [$($c)* $($rows)*] $f $p $nested $($blocks)* }
    };
    ($c:tt [$($f:tt)*] $p:tt $nested:tt Figure { $($rows:tt)* } $($blocks:tt)*) => {
        enums! { $c [$($f)* $($rows)*] $p $nested $($blocks)* }
    };
    ($c:tt $f:tt [$($p:tt)*] $nested:tt Projection { $($rows:tt)* } $($blocks:tt)*) => {
        enums! { $c $f [$($p)* $($rows)*] $nested $($blocks)* }
    };
    ([$($c:tt)*] [$($f:tt)*] [$($p:tt)*] $nested:tt) => {
        command_enum! {
            /// One command. Each variant is a form of the verb that its documentation shows.
            ///
            /// Numbers are parsed and finite, names are text without blanks, payloads are complete.
            /// When it runs, a command can still be refused for ranges, names, formats of payloads,
            /// limits and permissions.
            Command $nested $($c)*
        }
        codec! { Command $nested $($c)* }
        figures! { $($f)* }
        projections! { $($p)* }
    };
}

/// The enum `Figure`, if there are rows for it.
macro_rules! figures {
    () => {};
    ($($rows:tt)+) => {
        command_enum! {
            /// Line, area or text of two dimensions. Each variant is the verb that its
            /// documentation shows.
            Figure [] $($rows)+
        }
        codec! { Figure [] $($rows)+ }
        draw_figures! { $($rows)+ }
    };
}

/// `Codec` for [`Projection`](fbptr_core::scene::Projection), if there are rows for it.
macro_rules! projections {
    () => {};
    ($($rows:tt)+) => { codec! { Projection [] $($rows)+ } };
}

/// `DrawFigure` for the enum `Figure`.
macro_rules! draw_figures {
    ($(
        $verb:ident
        $( $variant:ident
            { $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? }
            = fn $function:ident
            $(with $($hooked:ident = $hook:ident),+)?
        )|+
        $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )+) => {
        impl DrawFigure for Figure {
            fn draw(&self, target: &mut FigureTarget<'_>) -> Result<(), DrawError> {
                match self {
                    $($( Figure::$variant { $($f),* } => target.$function($($f.lend()),*).drawn(), )+)+
                }
            }
        }
    };
}

/// Defines a command language: its enums, and the static tables `TABLE`, `PARSERS` and `PLAIN`.
macro_rules! language {
    (nested $nested:tt; $($group:ident $encoding:ident $target:ident $rows:tt)*) => {
        table! { $($group $encoding $target $rows)* }
        enums! { [] [] [] $nested $($target $rows)* }
    };
}

pub(super) use {
    call, call_nested, codec, command_enum, draw_figures, enums, figures, first, forms, hooked, kind,
    language, parser, pass, payload_of, plain_reader, projections, reach, read_variant, reply, table,
    variant_doc, verb_of, words, wrap,
};
