//! Values as bytes, little-endian, every bit kept: what a state is saved as, and what ranks send one another.

/// A value that can be written as bytes and read back bit for bit.
pub(super) trait Stored: Sized {
    fn write(&self, out: &mut Vec<u8>);

    /// None where the bytes end too soon or mean nothing.
    fn read(input: &mut Reader<'_>) -> Option<Self>;

    fn bytes(&self) -> Vec<u8> {
        let mut out = Vec::new();
        self.write(&mut out);
        out
    }
}

/// Bytes that are still to be read.
#[derive(Debug)]
pub(super) struct Reader<'a>(pub(super) &'a [u8]);

impl<'a> Reader<'a> {
    pub(super) fn take(&mut self, count: usize) -> Option<&'a [u8]> {
        let (head, rest) = self.0.split_at_checked(count)?;
        self.0 = rest;
        Some(head)
    }

    /// The value that all the bytes make.
    pub(super) fn whole<T: Stored>(mut self) -> Option<T> {
        T::read(&mut self).filter(|_| self.0.is_empty())
    }
}

macro_rules! stored_numbers {
    ($($number:ty),*) => {$(
        impl Stored for $number {
            fn write(&self, out: &mut Vec<u8>) {
                out.extend(self.to_le_bytes());
            }
            fn read(input: &mut Reader<'_>) -> Option<Self> {
                Some(<$number>::from_le_bytes(input.take(size_of::<$number>())?.try_into().ok()?))
            }
        }
    )*};
}
stored_numbers!(u8, u32, u64, u128, f64);

impl Stored for bool {
    fn write(&self, out: &mut Vec<u8>) {
        u8::from(*self).write(out);
    }
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        [false, true].get(usize::from(u8::read(input)?)).copied()
    }
}

impl Stored for usize {
    fn write(&self, out: &mut Vec<u8>) {
        (*self as u64).write(out);
    }
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        u64::read(input)?.try_into().ok()
    }
}

impl Stored for String {
    fn write(&self, out: &mut Vec<u8>) {
        self.len().write(out);
        out.extend(self.as_bytes());
    }
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        let length = usize::read(input)?;
        String::from_utf8(input.take(length)?.to_vec()).ok()
    }
}

impl<T: Stored> Stored for Vec<T> {
    fn write(&self, out: &mut Vec<u8>) {
        self.len().write(out);
        self.iter().for_each(|value| value.write(out));
    }
    /// A wrong length ends where the bytes end: nothing is reserved for it.
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        (0..usize::read(input)?).map(|_| T::read(input)).collect()
    }
}

impl<T: Stored, const K: usize> Stored for [T; K] {
    fn write(&self, out: &mut Vec<u8>) {
        self.iter().for_each(|value| value.write(out));
    }
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        let values: Vec<T> = (0..K).map(|_| T::read(input)).collect::<Option<_>>()?;
        values.try_into().ok()
    }
}

impl<T: Stored> Stored for Option<T> {
    fn write(&self, out: &mut Vec<u8>) {
        u8::from(self.is_some()).write(out);
        self.iter().for_each(|value| value.write(out));
    }
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        match u8::read(input)? {
            0 => Some(None),
            1 => T::read(input).map(Some),
            _ => None,
        }
    }
}

impl<A: Stored, B: Stored> Stored for (A, B) {
    fn write(&self, out: &mut Vec<u8>) {
        self.0.write(out);
        self.1.write(out);
    }
    fn read(input: &mut Reader<'_>) -> Option<Self> {
        Some((A::read(input)?, B::read(input)?))
    }
}

/// A struct is stored as its fields, in the order given; `[N]` after the name stands for a const parameter.
macro_rules! stored {
    ($name:ident $([$n:ident])? { $($field:ident),* $(,)? }) => {
        impl $(<const $n: usize>)? $crate::simulation::store::Stored for $name $(<$n>)? {
            fn write(&self, out: &mut Vec<u8>) {
                $( $crate::simulation::store::Stored::write(&self.$field, out); )*
            }
            fn read(input: &mut $crate::simulation::store::Reader<'_>) -> Option<Self> {
                $( let $field = $crate::simulation::store::Stored::read(input)?; )*
                Some($name { $($field),* })
            }
        }
    };
}
pub(super) use stored;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bit_comes_back_and_half_a_value_is_none() {
        type Value = (Vec<[f64; 2]>, (Option<String>, u128));
        let value: Value =
            (vec![[-0.0, f64::MIN_POSITIVE / 8.0], [f64::NAN, 1e300]], (Some(String::from("ẋ")), u128::MAX - 1));
        let bytes = value.bytes();
        let back: Option<Value> = Reader(&bytes).whole();
        assert_eq!(back.map(|value| value.bytes()), Some(bytes.clone()));
        for end in 0..bytes.len() {
            assert!(Reader(&bytes[..end]).whole::<Value>().is_none(), "{end} bytes");
        }
        let endless = u64::MAX.bytes();
        assert!(Reader(&endless).whole::<Vec<u64>>().is_none());
    }
}
