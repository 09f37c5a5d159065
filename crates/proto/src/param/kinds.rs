//! Kinds of parameters: what several specifications have in common is stored once. Computed at
//! compile time.

use super::{ParamSpec, table};
use crate::id::{ParamId, SubsystemId};

/// Placeholder without a subsystem, id and default.
pub(super) const BLANK: ParamSpec = of(&table::ANY);

/// Number of different kinds among these specifications.
pub(super) const fn count(specs: &[ParamSpec]) -> usize {
    let mut rest = specs;
    let mut kinds = 0;
    while let [head @ .., last] = rest {
        // A kind is counted at its first specification.
        if first(last, head) == head.len() {
            kinds += 1;
        }
        rest = head;
    }
    kinds
}

/// The kinds, in the order in which they first appear.
pub(super) const fn all<const N: usize>(specs: &[ParamSpec]) -> [ParamSpec; N] {
    let mut kinds = [BLANK; N];
    let mut places: &mut [ParamSpec] = &mut kinds;
    let (mut seen, mut rest) = (0, specs);
    while let [spec, tail @ ..] = rest {
        if first(spec, specs) == seen {
            let [place, others @ ..] = places else { break };
            *place = of(spec);
            places = others;
        }
        (seen, rest) = (seen + 1, tail);
    }
    kinds
}

/// Index of a specification's kind in [`all`].
pub(super) const fn place(spec: &ParamSpec, specs: &[ParamSpec]) -> u8 {
    let before = specs.split_at(first(spec, specs)).0;
    count(before) as u8
}

/// Index of the first specification of the same kind; the length if there is none.
const fn first(spec: &ParamSpec, specs: &[ParamSpec]) -> usize {
    let mut rest = specs;
    let mut place = 0;
    while let [other, tail @ ..] = rest {
        if is_alike(spec, other) {
            break;
        }
        (place, rest) = (place + 1, tail);
    }
    place
}

const fn of(spec: &ParamSpec) -> ParamSpec {
    ParamSpec { subsystem: SubsystemId::GENERAL, id: ParamId(0), default: 0, ..*spec }
}

/// Whether two specifications differ only in subsystem, id and default.
const fn is_alike(one: &ParamSpec, other: &ParamSpec) -> bool {
    one.min_len == other.min_len
        && one.max_len == other.max_len
        && one.step_len == other.step_len
        && one.unit as u8 == other.unit as u8
        && one.min == other.min
        && one.max == other.max
        && one.elements.len() == other.elements.len()
        && one.access as u8 == other.access as u8
        && one.effect as u8 == other.effect as u8
        && one.storage as u8 == other.storage as u8
        && one.placement as u8 == other.placement as u8
        && one.required == other.required
}
