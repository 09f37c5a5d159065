//! Macro for the structures of answers: type, bytes, and the layout for tools.

/// Declares a structure that is packed and little-endian.
///
/// The status word comes first, in brackets; a field has a name, a type and a unit.
macro_rules! structure {
    (
        $(#[$meta:meta])*
        $name:ident $([$word:ident: $flags:ident])? {
            $($(#[$doc:meta])* $field:ident $type:ident $unit:ident;)*
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub struct $name {
            $(
                /// Status word.
                pub $word: $flags,
            )?
            $(
                $(#[$doc])*
                #[doc = concat!(
                    "In [`", stringify!($unit), "`](crate::param::Unit::", stringify!($unit), ")."
                )]
                pub $field: $type,
            )*
        }

        impl $name {
            /// Its fields, with units and keys of texts.
            pub const LAYOUT: $crate::dictionary::layouts::Layout = {
                use $crate::dictionary::key;
                use $crate::dictionary::layouts::{Field, Kind, Layout};
                use $crate::param::Unit;
                Layout::plain(stringify!($name), &[
                    $(Field {
                        name: stringify!($word),
                        kind: Kind::Flags,
                        unit: Unit::Bits,
                        text: key!("field-", stringify!($word)),
                    },)?
                    $(Field {
                        name: stringify!($field),
                        kind: $crate::status::structure!(@kind $type),
                        unit: Unit::$unit,
                        text: key!("field-", stringify!($name), "-", stringify!($field)),
                    },)*
                ])
            };
            /// Bytes on the wire.
            pub const SIZE: usize = Self::LAYOUT.size();

            /// Reads the structure.
            #[inline]
            pub const fn from_bytes(bytes: [u8; Self::SIZE]) -> Self {
                let rest = bytes.as_slice();
                $(let ($word, rest) = $crate::status::structure::take(rest);)?
                $(let ($field, rest) = $crate::status::structure::take(rest);)*
                $crate::status::structure::end(rest);
                Self {
                    $($word: $flags::from_bits_retain(u32::from_le_bytes($word)),)?
                    $($field: $type::from_le_bytes($field),)*
                }
            }

            /// Writes the structure.
            #[inline]
            pub const fn to_bytes(self) -> [u8; Self::SIZE] {
                let mut bytes = [0; Self::SIZE];
                let rest: &mut [u8] = &mut bytes;
                $(let rest = $crate::status::structure::put(rest, self.$word.bits().to_le_bytes());)?
                $(let rest = $crate::status::structure::put(rest, self.$field.to_le_bytes());)*
                $crate::status::structure::end(rest);
                bytes
            }
        }
    };
    (@kind u8) => { Kind::U8 };
    (@kind u16) => { Kind::U16 };
    (@kind i16) => { Kind::I16 };
    (@kind i32) => { Kind::I32 };
}

pub(crate) use structure;

/// The first N bytes and the rest. `SIZE` is the sum of all fields, so there are enough.
#[inline(always)]
pub(crate) const fn take<const N: usize>(bytes: &[u8]) -> ([u8; N], &[u8]) {
    match bytes.split_first_chunk() {
        Some((first, rest)) => (*first, rest),
        None => ([0; N], &[]),
    }
}

/// Writes the first N bytes; returns the rest.
#[inline(always)]
pub(crate) const fn put<const N: usize>(bytes: &mut [u8], value: [u8; N]) -> &mut [u8] {
    match bytes.split_first_chunk_mut() {
        Some((first, rest)) => {
            *first = value;
            rest
        }
        None => &mut [],
    }
}

/// The end of the structure: no bytes may be left.
#[inline(always)]
pub(crate) const fn end(rest: &[u8]) {
    debug_assert!(rest.is_empty());
}
