//! Enumerations whose values have names.

/// Declares an enumeration of choices with the words that users write for them: `ALL`, `name`, `FromStr`, `Display`.
macro_rules! names {
    (
        $(#[$meta:meta])*
        pub enum $name:ident { $( $(#[$about:meta])* $variant:ident = $word:literal, )* }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub enum $name { $( $(#[$about])* $variant, )* }

        impl $name {
            /// Every value, in the order in which they are listed to users.
            pub const ALL: &'static [Self] = &[$( Self::$variant, )*];
            /// The words for them, in the same order.
            pub const NAMES: &'static [&'static str] = &[$( $word, )*];

            /// The word by which users choose it.
            pub const fn name(self) -> &'static str {
                match self { $( Self::$variant => $word, )* }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }

        impl std::str::FromStr for $name {
            type Err = String;

            fn from_str(s: &str) -> Result<Self, String> {
                match s {
                    $( $word => Ok(Self::$variant), )*
                    _ => Err(format!("give one of {}", Self::NAMES.join(", "))),
                }
            }
        }
    };
}
pub(crate) use names;
