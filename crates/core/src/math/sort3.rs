//! Sorting of three values: the general sorts would be compiled anew for each type.

/// Sorts three values; equal ones keep their order. `is_less(a, b)` is a strict weak order.
#[inline]
pub fn sort3<T>(values: &mut [T; 3], is_less: impl Fn(&T, &T) -> bool) {
    if is_less(&values[1], &values[0]) {
        values.swap(0, 1);
    }
    if is_less(&values[2], &values[1]) {
        values.swap(1, 2);
        if is_less(&values[1], &values[0]) {
            values.swap(0, 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::sort3;

    #[test]
    fn three_values_are_sorted_as_by_the_stable_sort() {
        for code in 0..27 {
            // Equal numbers are told apart by their places.
            let mut values = [(code % 3, 0), (code / 3 % 3, 1), (code / 9, 2)];
            let mut expected = values;
            expected.sort_by_key(|v| v.0);
            sort3(&mut values, |a, b| a.0 < b.0);
            assert_eq!(values, expected, "{code}");
        }
    }
}
