//! The dispatch of commands, made from the verb table: a row names the function that runs its verb.
//!
//! In: a command. Out: what its function returns, as progress. A function is a method of the engine
//! whose parameters are the call and the verb's arguments in the table's order. Where the call's
//! session is enough it takes that; it returns nothing, an effect, progress, or an error instead.

use super::{Call, Engine, Fault, Outcome, Progress};
use fbptr_command::{Command, verbs};

/// Sorts the blocks of the table: rows of Pixelflut's commands, and all rows of commands. Figures are
/// drawn as one, and projections are the camera's.
macro_rules! dispatch {
    (nested $nested:tt; $($group:ident $encoding:ident $target:ident $rows:tt)*) => {
        dispatch! { [] [] $nested $($group $target $rows)* }
    };
    ([$($p:tt)*] [$($c:tt)*] $nested:tt Pixelflut Command { $($rows:tt)* } $($blocks:tt)*) => {
        dispatch! { [$($p)* $($rows)*] [$($c)* $($rows)*] $nested $($blocks)* }
    };
    ($p:tt [$($c:tt)*] $nested:tt $group:ident Command { $($rows:tt)* } $($blocks:tt)*) => {
        dispatch! { $p [$($c)* $($rows)*] $nested $($blocks)* }
    };
    ($p:tt $c:tt $nested:tt $group:ident $target:ident $rows:tt $($blocks:tt)*) => {
        dispatch! { $p $c $nested $($blocks)* }
    };
    ([$($p:tt)*] [$($c:tt)*] $nested:tt) => {
        run_commands! { dispatch_command is_made_by_job $nested $($c)* }
        has_variant! { is_pixelflut $($p)* }
    };
}

/// The function `$dispatch` of the engine, which runs commands, and the function
/// `$is_made_by_job`.
macro_rules! run_commands {
    ($dispatch:ident $is_made_by_job:ident [$($nest:ident ($nested:ty) = fn $runs:ident),*] $(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            = $way:ident $function:ident
            $(with $($hooked:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)? $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*) => {
        impl Engine {
            /// Runs a command, or creates its job.
            #[inline(never)]
            pub(in crate::engine) fn $dispatch(
                &mut self,
                call: &mut Call<'_>,
                command: Command,
            ) -> Result<Progress, Fault> {
                match command {
                    $($( Command::$variant $({ $($f),* })? $(( $($g),* ))? => {
                        self.$function(call $($(, $f)*)? $($(, $g)*)?).outcome()
                    } )+)*
                    $( Command::$nest(nested) => self.$runs(call, nested).outcome(), )*
                }
            }
        }

        /// Returns whether a job always makes the effect of a command: its result is what is
        /// recorded.
        pub(in crate::engine) fn $is_made_by_job(command: &Command) -> bool {
            match command {
                $($( Command::$variant { .. } => is_job!($way), )+)*
                $( Command::$nest(_) => false, )*
            }
        }
    };
}

/// True for a row whose function only makes a job.
macro_rules! is_job {
    (fn) => {
        false
    };
    (job) => {
        true
    };
}
#[cfg(test)]
pub(in crate::engine) use run_commands;

/// A function that returns whether a command is of one of these rows.
macro_rules! has_variant {
    ($name:ident $(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            = $way:ident $function:ident
            $(with $($hooked:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)? $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*) => {
        /// Returns whether the command is one of Pixelflut's own.
        pub(in crate::engine) fn $name(command: &Command) -> bool {
            matches!(command, $($( Command::$variant { .. } )|+)|*)
        }
    };
}

verbs! { dispatch }
