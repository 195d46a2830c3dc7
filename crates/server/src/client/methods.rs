//! The methods of [`Client`](super::Client) for verbs, made from the verb table: a verb that is added
//! has its method at once, unless it is written by hand.

/// Makes the methods of `Client`, and the function `made_methods` that lists their verbs.
macro_rules! client_methods {
    (nested $nested:tt; $($group:ident $encoding:ident $target:ident $rows:tt)*) => {
        $( client_methods! { $target $rows } )*

        /// Returns the verbs whose methods are made.
        #[cfg(test)]
        pub(super) fn made_methods() -> Vec<&'static str> {
            #[allow(unused_mut, reason = "all may be written by hand")]
            let mut made = Vec::new();
            $( client_methods! { @list made $target $rows } )*
            made
        }
    };
    (@list $made:ident Projection $rows:tt) => {};
    (@list $made:ident $target:ident {$(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            = $way:ident $function:ident
            $(with $($hooked:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)?
        $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*}) => {
        $($( unless_written! { $function { $made.push(stringify!($verb)); } } )+)*
    };
    // One method takes all projections.
    (Projection $rows:tt) => {};
    ($target:ident {$(
        $verb:ident
        $( $variant:ident
            $({ $($f:ident $([$w:literal])? : $t:ty $(= $k:ty)?),* $(,)? })?
            $(( $($g:ident $([$x:literal])? : $u:ty $(= $l:ty)?),* ))?
            = $way:ident $function:ident
            $(with $($hooked:ident = $hook:ident),+)?
        )|+
        $(-> $reply:ident)?
        $(in $reach:ident)?
        : $forms:tt eg $example:literal;
    )*}) => {
        $( client_methods! {
            $target $verb [$($reply)?]
            $( $function $variant $({ $($f: $t),* })? $(( $($g: $u),* ))? )|+
        } )*
    };
    ($target:ident $verb:ident $reply:tt $(
        $function:ident $variant:ident
        $({ $($f:ident : $t:ty),* })? $(( $($g:ident : $u:ty),* ))?
    )|+) => {
        $( unless_written! { $function {
            impl Client {
                client_methods! {
                    $reply $function (concat!("Sends `", stringify!($verb), "`, with its arguments in order."))
                    [$($($f: $t,)*)? $($($g: $u,)*)?]
                    ($target::$variant $({ $($f: $f.into()),* })? $(( $($g.into()),* ))?)
                }
            }
        } } )+
    };
    ([] $function:ident ($doc:expr) [$($f:ident : $t:ty,)*] ($made:expr)) => {
        #[doc = $doc]
        pub fn $function(&self, $($f: impl Into<$t>),*) {
            self.send(Command::from($made));
        }
    };
    ([$reply:ident] $function:ident ($doc:expr) [$($f:ident : $t:ty,)*] ($made:expr)) => {
        #[doc = $doc]
        ///
        /// # Errors
        /// If the command is refused, or the render thread has ended.
        pub fn $function(&self, $($f: impl Into<$t>),*) -> Result<Vec<u8>, Fault> {
            self.ask(Command::from($made))
        }
    };
}
pub(super) use client_methods;
