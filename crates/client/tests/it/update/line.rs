//! An update over a serial line that is slow and spoils bytes.

use super::*;

const BAUD: u64 = 19_200;
/// A byte with its start and stop bit.
const BITS: u64 = 10;
/// One byte of so many is changed.
const SPOILED: u64 = 2_000;

/// The line: how long it has been in use, and how many bytes were changed.
struct Line {
    dice: Dice,
    used: Duration,
    spoiled: u32,
}

type SharedLine = Arc<Mutex<Line>>;

impl Line {
    /// What arrives of these bytes, and how long that takes.
    fn over(&mut self, bytes: &mut [u8]) -> Duration {
        for byte in &mut *bytes {
            if self.dice.roll().is_multiple_of(SPOILED) {
                self.spoiled += 1;
                *byte ^= 1 << (self.dice.roll() % 8);
            }
        }
        let time = Duration::from_micros(bytes.len() as u64 * BITS * 1_000_000 / BAUD);
        self.used += time;
        time
    }
}

/// Serves the model at the end of such a line.
async fn serve_over(line: SharedLine, mut stream: DuplexStream, model: Shared) {
    let mut decoder: Decoder = Decoder::new();
    let mut buffer = [0; 2048];
    while let Ok(len @ 1..) = stream.read(&mut buffer).await {
        let time = line.lock().unwrap().over(&mut buffer[..len]);
        sleep(time).await;
        let mut replies = Vec::new();
        for byte in &buffer[..len] {
            if let Some(asked) = decoder.push(*byte) {
                replies.extend(model.lock().unwrap().answer(asked.payload));
            }
        }
        let time = line.lock().unwrap().over(&mut replies);
        sleep(time).await;
        if stream.write_all(&replies).await.is_err() {
            return;
        }
    }
}

/// At 19200 baud, with a byte of 2000 spoiled, it comes to its end, and the data leave the others on the line four
/// fifths of its time.
#[tokio::test(start_paused = true)]
async fn slow_and_noisy() {
    let image = image(NEW, 2, 20_000);
    let mut spoiled = 0;
    for seed in 1..6 {
        let line = Line { dice: Dice(seed), used: Duration::ZERO, spoiled: 0 };
        let (line, model) = (Arc::new(Mutex::new(line)), Arc::new(Mutex::new(Model::new())));
        let (ours, theirs) = pair();
        tokio::spawn(serve_over(line.clone(), theirs, model.clone()));
        let monitor = Monitor::new(Client::over("test", ours, Config::default()));
        let (mut first, mut last) = (None, None);
        let seen = || (Instant::now(), line.lock().unwrap().used);
        let told = |stage| match stage {
            Stage::Sending { done: 0, .. } => first = first.or(Some(seen())),
            Stage::Verifying => last = last.or(Some(seen())),
            _ => {}
        };
        let updated = monitor.update(std::slice::from_ref(&image), &WORD, Pace::SHARED, told).await;
        assert_eq!(updated.unwrap(), Updated { from: OLD, to: NEW }, "seed {seed}");
        {
            let model = model.lock().unwrap();
            assert!(model.bytes == image.payload(), "seed {seed}");
            assert_eq!((model.slot, model.trial, model.commits), (2, false, 1), "seed {seed}");
        }
        let ((begin, used_before), (end, used)) = first.zip(last).unwrap();
        let (time, used) = (end - begin, used - used_before);
        // The orders of an exchange and its answer, and what is asked to go on after a loss.
        assert!(used * 100 <= time * 21, "seed {seed}: {used:?} of {time:?}");
        spoiled += line.lock().unwrap().spoiled;
    }
    assert!(spoiled > 20, "{spoiled}");
}
