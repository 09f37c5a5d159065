//! The pictures of a camera since its last key frame, and how far each viewer is.
//!
//! A viewer has no queue: it has a number, and takes the next picture when it has sent the one before. So a slow one
//! costs no memory and delays no other. One that is too far behind is sent nothing until the next key frame, from which
//! a decoder can go on; so what it shows is never old, only seldom.

use std::collections::VecDeque;
use std::sync::Mutex;
use std::time::Duration;

use bytes::Bytes;
use tokio::sync::watch;
use tokio::time::Instant;

use super::waited;
use crate::sync::lock;

/// What is kept, bytes and pictures: 10 s of 12 Mbit/s. Beyond that the oldest go, and who comes waits for a key frame.
const KEPT_MAX: usize = 16 * 1024 * 1024;
const PICTURES_MAX: usize = 1800;
/// A viewer is this far behind at most.
const BEHIND: Duration = Duration::from_millis(1500);

/// The pictures of a camera.
#[derive(Debug)]
pub struct Feed {
    kept: Mutex<Kept>,
    news: watch::Sender<u64>,
}

impl Default for Feed {
    fn default() -> Self {
        Self { kept: Mutex::default(), news: watch::Sender::new(0) }
    }
}

#[derive(Debug, Default)]
struct Kept {
    pictures: VecDeque<Bytes>,
    bytes: usize,
    /// The number of the first one.
    first: u64,
    /// The number of the key frame that is among them.
    key: Option<u64>,
    /// A key frame has come since the beginning or the last [`Feed::clear`].
    started: bool,
}

impl Kept {
    fn end(&self) -> u64 {
        self.first + u64::try_from(self.pictures.len()).unwrap_or(0)
    }

    fn get(&self, number: u64) -> Option<&Bytes> {
        self.pictures.get(usize::try_from(number.checked_sub(self.first)?).ok()?)
    }

    fn drop_all(&mut self) {
        self.first = self.end();
        self.pictures.clear();
        (self.bytes, self.key) = (0, None);
    }

    fn drop_first(&mut self) {
        if let Some(first) = self.pictures.pop_front() {
            self.bytes -= first.len();
            if self.key == Some(self.first) {
                self.key = None;
            }
            self.first += 1;
        }
    }
}

/// How far a viewer is.
#[derive(Debug, Default)]
pub struct Viewer {
    /// The picture that it is sent next; `None`: a key frame.
    next: Option<u64>,
    /// No picture before this one is sent any more.
    from: u64,
    /// Since when there is more than it has taken.
    behind: Option<Instant>,
    /// What it was sent and has not seen yet, and when it was sent.
    unseen: VecDeque<(u64, Instant)>,
    /// The last one that it was sent.
    sent: Option<u64>,
    /// It has to see all that it was sent before it is sent more.
    waits: bool,
    /// Times that it was sent on to a key frame.
    pub skipped: u64,
}

impl Feed {
    /// A picture has come. `make` writes its message, given its number: without the lock.
    pub fn push(&self, key: bool, make: impl FnOnce(u64) -> Bytes) {
        let number = {
            let kept = lock(&self.kept);
            if !key && !kept.started {
                return;
            }
            kept.end()
        };
        let message = make(number);
        let end = {
            let mut kept = lock(&self.kept);
            if key {
                kept.drop_all();
                (kept.key, kept.started) = (Some(number), true);
            }
            kept.bytes += message.len();
            kept.pictures.push_back(message);
            while kept.bytes > KEPT_MAX || kept.pictures.len() > PICTURES_MAX {
                kept.drop_first();
            }
            kept.end()
        };
        self.news.send_replace(end);
    }

    /// The stream has ended: the next one begins with a key frame.
    pub fn clear(&self) {
        let mut kept = lock(&self.kept);
        kept.drop_all();
        kept.started = false;
    }

    /// Receives that there is something new.
    pub fn news(&self) -> watch::Receiver<u64> {
        self.news.subscribe()
    }

    /// What a viewer is sent next; `None`: nothing before there is something new, or it has seen more.
    pub fn next(&self, viewer: &mut Viewer, now: Instant) -> Option<Bytes> {
        let kept = lock(&self.kept);
        let oldest = viewer.unseen.front().map(|(_, since)| *since);
        if viewer.next.is_some() && waited(oldest, now, BEHIND) {
            viewer.skip(kept.end());
            viewer.waits = true;
        }
        if viewer.waits {
            return None;
        }
        let number = match viewer.next {
            Some(number) if number >= kept.first => number,
            // What it was to be sent is gone.
            gone => {
                if gone.is_some() {
                    viewer.skip(kept.first);
                }
                kept.key.filter(|key| *key >= viewer.from)?
            }
        };
        let Some(message) = kept.get(number) else {
            viewer.behind = None;
            return None;
        };
        let last = number + 1 == kept.end();
        viewer.behind = if last { None } else { viewer.behind.or(Some(now)) };
        if waited(viewer.behind, now, BEHIND) {
            viewer.skip(kept.end());
            return None;
        }
        (viewer.next, viewer.sent) = (Some(number + 1), Some(number));
        viewer.unseen.push_back((number, now));
        if viewer.unseen.len() > PICTURES_MAX {
            viewer.unseen.pop_front();
        }
        Some(message.clone())
    }
}

impl Viewer {
    fn skip(&mut self, from: u64) {
        (self.next, self.from, self.behind) = (None, from, None);
        self.skipped += 1;
    }

    /// It has seen the picture with this number, of which it says the low half.
    pub fn has_seen(&mut self, low: u32) {
        let Some(sent) = self.sent else { return };
        // Of what it was sent, the latest with this half.
        let back = u64::from(super::message::low(sent).wrapping_sub(low));
        let Some(seen) = sent.checked_sub(back).filter(|_| back < 1 << 31) else { return };
        while self.unseen.front().is_some_and(|(number, _)| *number <= seen) {
            self.unseen.pop_front();
        }
        self.waits &= !self.unseen.is_empty();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn push(feed: &Feed, key: bool, len: usize) {
        feed.push(key, |number| Bytes::from(vec![u8::try_from(number % 256).unwrap(); len]));
    }

    fn all(feed: &Feed, viewer: &mut Viewer, now: Instant) -> Vec<u8> {
        std::iter::from_fn(|| feed.next(viewer, now)).map(|it| it[0]).collect()
    }

    fn after(start: Instant, ms: u64) -> Instant {
        start + Duration::from_millis(ms)
    }

    #[test]
    fn who_comes_begins_with_the_last_key_frame() {
        let (feed, now) = (Feed::default(), Instant::now());
        push(&feed, false, 1);
        let mut first = Viewer::default();
        assert_eq!(all(&feed, &mut first, now), [0; 0], "no decoder can begin with it");
        for key in [true, false, false, true, false] {
            push(&feed, key, 1);
        }
        let mut second = Viewer::default();
        assert_eq!(all(&feed, &mut first, now), [3, 4]);
        assert_eq!(all(&feed, &mut second, now), [3, 4]);
        push(&feed, false, 1);
        assert_eq!(all(&feed, &mut second, now), [5]);
        feed.clear();
        push(&feed, false, 1);
        assert_eq!(all(&feed, &mut second, now), [0; 0], "another stream begins with a key frame");
        push(&feed, true, 1);
        assert_eq!(all(&feed, &mut second, now), [6]);
    }

    /// What is kept has a bound, whatever the camera sends and however seldom its key frames are.
    #[test]
    fn what_is_kept_has_a_bound() {
        let (feed, now) = (Feed::default(), Instant::now());
        push(&feed, true, 1);
        let mut follows = Viewer::default();
        let mut taken = all(&feed, &mut follows, now).len();
        for _ in 0..PICTURES_MAX + 50 {
            push(&feed, false, 10);
            taken += all(&feed, &mut follows, now).len();
        }
        assert_eq!(lock(&feed.kept).pictures.len(), PICTURES_MAX);
        assert_eq!(taken, PICTURES_MAX + 51, "who has kept up misses nothing");
        assert_eq!(all(&feed, &mut Viewer::default(), now).len(), 0, "who comes waits for a key");
        for _ in 0..20 {
            push(&feed, false, 4 * 1024 * 1024);
        }
        let kept = lock(&feed.kept);
        assert!(kept.bytes <= KEPT_MAX && kept.pictures.len() == 4, "{}", kept.bytes);
    }

    #[test]
    fn a_slow_viewer_goes_on_with_a_key_frame_and_another_misses_nothing() {
        let (feed, start) = (Feed::default(), Instant::now());
        let (mut slow, mut quick) = (Viewer::default(), Viewer::default());
        let (mut of_slow, mut of_quick) = (Vec::new(), Vec::new());
        // 25 pictures a second, every 100th a key frame; the slow one takes five a second.
        for number in 0..300_u64 {
            let now = after(start, number * 40);
            push(&feed, number % 100 == 0, 1);
            of_quick.extend(all(&feed, &mut quick, now));
            quick.has_seen(u32::try_from(number).unwrap());
            if number % 5 == 0
                && let Some(message) = feed.next(&mut slow, now)
            {
                of_slow.push(message[0]);
                slow.has_seen(super::super::message::low(slow.sent.unwrap()));
            }
        }
        assert_eq!(of_quick.len(), 300);
        assert!(slow.skipped >= 2 && quick.skipped == 0, "{}", slow.skipped);
        // Each of its parts begins with a key frame and has no gap.
        let parts = of_slow.windows(2).filter(|it| it[1] != it[0].wrapping_add(1));
        assert!(parts.clone().count() >= 2 && parts.clone().all(|it| [100, 200].contains(&it[1])));
    }

    /// A network takes what a page does not see for a long time: what is under way is never old.
    #[test]
    fn who_does_not_say_what_it_has_seen_is_sent_no_more() {
        let (feed, start) = (Feed::default(), Instant::now());
        let mut viewer = Viewer::default();
        let mut sent = 0;
        for number in 0..500_u64 {
            push(&feed, number % 50 == 0, 1);
            sent += all(&feed, &mut viewer, after(start, number * 40)).len();
        }
        assert_eq!(sent, 38, "1.5 s of 25 pictures each");
        viewer.has_seen(u32::MAX);
        viewer.has_seen(u32::try_from(sent).unwrap() + 7);
        let now = after(start, 20_000);
        assert_eq!(all(&feed, &mut viewer, now).len(), 0, "what it was never sent counts nothing");
        viewer.has_seen(u32::try_from(sent - 1).unwrap());
        push(&feed, true, 1);
        assert_eq!(all(&feed, &mut viewer, now).len(), 1);
    }
}
