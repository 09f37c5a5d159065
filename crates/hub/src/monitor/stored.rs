//! The stored programs and trajectories of a monitor, as they were read since anything may have changed them.

use std::collections::BTreeMap;

use lafet_proto::param::Param;
use lafet_proto::request::Body;
use lafet_proto::{Request, SubsystemId};

/// What is known of them.
#[derive(Debug, Default)]
pub struct Stored {
    /// How often something may have changed them.
    changes: u64,
    /// Values by name, and after how many changes they were read.
    read: BTreeMap<&'static str, (u64, Vec<i32>)>,
}

/// When a reading was started.
#[derive(Clone, Copy, Debug)]
pub struct Since(u64);

impl Stored {
    /// A reading begins.
    pub const fn since(&self) -> Since {
        Since(self.changes)
    }

    /// A value was read: it counts if nothing may have changed it since then.
    pub fn put(&mut self, Since(changes): Since, param: Param, values: &[i32]) {
        let newer = self.read.get(param.name()).is_some_and(|(at, _)| *at > changes);
        if is_program(param) && !newer {
            self.read.insert(param.name(), (changes, values.to_vec()));
        }
    }

    /// Whether one that was read is to be read again.
    pub fn is_behind(&self) -> bool {
        self.read.values().any(|(at, _)| *at != self.changes)
    }

    /// Something may have changed them: none is known until it was read again.
    pub const fn doubt(&mut self) {
        self.changes += 1;
    }

    /// The values of one; `None`: not known.
    pub fn of(&self, param: Param) -> Option<&[i32]> {
        let (changes, values) = self.read.get(param.name())?;
        (*changes == self.changes).then_some(values)
    }
}

/// Whether a request may change one of them.
pub fn may_change(request: &Request<'_>) -> bool {
    match request.body {
        // One that is in no table may be another maker's for the same.
        Body::SetParam { id, .. } => Param::find(request.to, id).is_none_or(is_program),
        Body::CleanFlash { .. } | Body::Restart => true,
        _ => false,
    }
}

fn is_program(param: Param) -> bool {
    let named = |of: &str| param.name().starts_with(of);
    param.spec().subsystem == SubsystemId::CONTROL && (named("Program") || named("Trajectory"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use lafet_proto::Ints;

    #[test]
    fn what_was_read_before_a_change_is_not_known() {
        let (program, other) = (Param::ControlProgram1, Param::ControlTrajectory0);
        let mut stored = Stored::default();
        assert_eq!(stored.of(program), None);
        let before = stored.since();
        stored.put(before, program, &[1, 2]);
        assert_eq!((stored.of(program), stored.of(other)), (Some(&[1, 2][..]), None));
        stored.doubt();
        assert_eq!(stored.of(program), None);
        // A reading that was started before has the former value, perhaps.
        stored.put(before, program, &[1, 2]);
        assert_eq!(stored.of(program), None);
        stored.put(stored.since(), program, &[3, 4]);
        assert_eq!((stored.of(program), stored.is_behind()), (Some(&[3, 4][..]), false));
        stored.put(before, program, &[1, 2]);
        assert_eq!(stored.of(program), Some(&[3, 4][..]), "an older reading that comes later");
        stored.doubt();
        assert!(stored.is_behind());
    }

    #[test]
    fn what_may_change_them() {
        let set = |param: Param| {
            let spec = param.spec();
            Request::new(spec.subsystem, Body::SetParam { id: spec.id, values: Ints::Values(&[1]) })
        };
        assert!(may_change(&set(Param::ControlProgram1)));
        assert!(!may_change(&set(Param::GeneralWaterTimeout)));
        assert!(may_change(&Request::new(SubsystemId::ALL, Body::Restart)));
        assert!(!may_change(&Request::new(SubsystemId::ALL, Body::GetStatus)));
    }
}
