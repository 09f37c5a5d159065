//! Whole updates that were heard on the line and are sent again.

use super::*;

/// Everything that goes over the line in an update with this word, in its order.
fn heard(image: &Image, word: &[u8; WORD_LEN]) -> Vec<Vec<u8>> {
    let digest = Hash::of(word).0;
    let begin = Order::Begin { header: &image.raw, digest: &digest };
    let parts = image.payload.chunks(PART_MAX).enumerate().map(|(index, part)| {
        let offset = (index * PART_MAX) as u32;
        Order::Data { offset, part }
    });
    let rest = [Order::Verify, Order::Commit { digest: &digest }, Order::Confirm { word }];
    let last = Order::Abandon { digest: &digest };
    let all = std::iter::once(begin).chain(parts).chain(rest).chain([last]);
    let mut buffer = [0; 256];
    all.map(|order| order.encode(&mut buffer).unwrap().to_vec()).collect()
}

impl Site {
    /// Sends orders one after another, with time for each; the status and the report after each.
    fn play(&mut self, orders: &[Vec<u8>]) -> Vec<(Status, Report)> {
        let mut all = Vec::new();
        for order in orders {
            let (_, status, _) = self.raw(SubsystemId::GENERAL, order);
            self.run_still(2000);
            all.push((status, self.report()));
        }
        all
    }

    /// An update by these orders up to its trial, and what confirms and ends it.
    #[track_caller]
    fn try_out<'o>(&mut self, orders: &'o [Vec<u8>], version: u16) -> &'o [Vec<u8>] {
        let (to_trial, rest) = orders.split_at(orders.len() - 2);
        let last = self.play(to_trial).pop().unwrap().1;
        assert_eq!((last.trial, last.version[0]), (true, version));
        self.run_still(PROVEN_MS);
        rest
    }
}

/// Updates to versions 2 and 3 were heard, every order of them, with the words that have confirmed them. Sent again in
/// their order, to the version that came of them and to a later one on trial, they start nothing, write nothing, confirm
/// nothing and end nothing.
#[test]
fn what_was_heard_before() {
    let words: [&[u8; WORD_LEN]; 3] =
        [b"sixteen letters.", b"sixteen others..", b"and of the third"];
    let versions = [2, 3, 4];
    let updates: Vec<_> =
        versions.iter().zip(words).map(|(major, word)| heard(&image(*major, 512), word)).collect();
    let mut site = Site::locked();
    for (index, version) in versions.into_iter().enumerate() {
        let rest = site.try_out(&updates[index], version);
        let (starts, steps) = (site.starts, site.app().memory().flash().steps);
        for old in &updates[..index] {
            for (_, report) in site.play(old) {
                assert_eq!((report.trial, report.version[0]), (true, version));
            }
        }
        let confirmed = site.play(&rest[..1]).pop().unwrap().1;
        assert_eq!((confirmed.trial, confirmed.version[0]), (false, version));
        assert_eq!(site.starts, starts, "nothing has ended the trial");
        let after_trial = site.app().memory().flash().steps;
        for old in &updates[..=index] {
            let answers = site.play(old);
            assert_eq!(answers[0].1.reason, Refusal::NotNewer.code());
            for (status, report) in answers {
                let kept = (report.phase, report.trial, report.version[0]);
                assert_eq!(kept, (Phase::IDLE, false, version), "{status}");
            }
        }
        assert_eq!(site.starts, starts);
        assert_eq!(site.app().memory().flash().steps, after_trial, "nothing is written");
        assert!(after_trial > steps, "the confirmation was");
    }
    assert!(site.is_locked());
}
