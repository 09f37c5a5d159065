//! §U/9 What runs, as parameters of General.

use super::*;

impl Site {
    /// What is answered to GetParam; the values without the id.
    fn software(&mut self, param: Param) -> (Status, Vec<i32>) {
        let answers = self.ask(SubsystemId::GENERAL, Body::GetParam { id: param.id() });
        let [(from, status, data)] = answers.as_slice() else { panic!("{answers:?}") };
        assert_eq!(*from, SubsystemId::GENERAL);
        let values = data[2..].as_chunks().0.iter().copied().map(i32::from_le_bytes);
        (*status, values.collect())
    }

    /// Version, slot and hash are these.
    #[track_caller]
    fn runs(&mut self, version: i32, slot: i32, image: &Image) {
        let hash = Hash::of(&image.payload).0;
        let hash: Vec<_> = hash.as_chunks().0.iter().copied().map(i32::from_be_bytes).collect();
        let version = (Status::OK, vec![version, 0, 0, 0]);
        assert_eq!(self.software(Param::GeneralSoftwareVersion), version);
        assert_eq!(self.software(Param::GeneralSoftwareSlot), (Status::OK, vec![slot]));
        assert_eq!(self.software(Param::GeneralSoftwareHash), (Status::OK, hash));
    }
}

/// They are what runs, also while another image is received, on trial and after going back, and cannot be set.
#[test]
fn what_runs() {
    let (old, new) = (image(1, 512), image(2, 504));
    let mut site = Site::locked();
    site.runs(1, 1, &old);
    assert!(site.send(&new));
    site.runs(1, 1, &old);
    site.commit();
    site.runs(2, 2, &new);
    for param in [Param::GeneralSoftwareVersion, Param::GeneralSoftwareSlot] {
        let values = vec![3; usize::from(param.spec().min_len)];
        let body = Body::SetParam { id: param.id(), values: Ints::Values(&values) };
        assert_eq!(site.ask(SubsystemId::GENERAL, body)[0].1, Status::ACCESS_DENIED);
    }
    site.run_still(TRIAL_MS + 1000);
    site.runs(1, 1, &old);
}

/// A board without the update has no such parameters, whether they are read or set.
#[test]
fn absent() {
    let mut site = Site::with(Composition::FULL, None);
    for param in
        [Param::GeneralSoftwareVersion, Param::GeneralSoftwareSlot, Param::GeneralSoftwareHash]
    {
        assert_eq!(site.software(param), (Status::INVALID_ID, vec![]));
        let body = Body::SetParam { id: param.id(), values: Ints::Values(&[1]) };
        assert_eq!(site.ask(SubsystemId::GENERAL, body)[0].1, Status::INVALID_ID);
    }
}
