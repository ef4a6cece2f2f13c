//! An order of numbers in which the first few are spread over the whole range.

/// Returns the numbers below `count` in an order in which the first few are spread over the whole range.
pub fn scattered(count: usize) -> impl Iterator<Item = usize> {
    let bits = count.next_power_of_two().trailing_zeros();
    let reversed = move |number: usize| number.reverse_bits().checked_shr(usize::BITS - bits).unwrap_or(0);
    (0..1 << bits).map(reversed).filter(move |number| *number < count)
}
