//! Flags of blocks, most of which are not raised.

/// How many flags are looked at together.
const TOGETHER: usize = 8;

/// The places of the flags that are raised, ascending.
#[inline(always)]
pub(crate) fn raised(flags: &[bool]) -> Raised<'_> {
    let (groups, left) = bytemuck::cast_slice(flags).as_chunks();
    Raised { groups, left, first: 0, bytes: 0, next: 0 }
}

/// See [`raised`].
pub(crate) struct Raised<'a> {
    groups: &'a [[u8; TOGETHER]],
    /// Those behind the last group.
    left: &'a [u8],
    /// The first flag of the present group, and those of its flags that are still to come: a byte each, the first one lowest.
    first: usize,
    bytes: u64,
    /// The next group.
    next: usize,
}

impl Iterator for Raised<'_> {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        while self.bytes == 0 {
            let mut group = [0; TOGETHER];
            match self.groups.get(self.next) {
                Some(whole) => group = *whole,
                None if self.next == self.groups.len() => {
                    group[..self.left.len()].copy_from_slice(self.left);
                }
                None => return None,
            }
            self.first = self.next * TOGETHER;
            self.bytes = u64::from_le_bytes(group);
            self.next += 1;
        }
        let at = self.bytes.trailing_zeros() as usize / TOGETHER;
        self.bytes &= self.bytes - 1;
        Some(self.first + at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_that_are_raised_are_found_in_order() {
        for count in 0..40 {
            for pattern in 0..7 {
                let flags: Vec<_> = (0..count).map(|i| (i * i + i / 3) % 7 < pattern).collect();
                let expected: Vec<_> = (0..count).filter(|&i| flags[i]).collect();
                assert_eq!(raised(&flags).collect::<Vec<_>>(), expected, "{flags:?}");
            }
        }
    }
}
