//! The end of a run, however it comes: the monitor that is held is stopped and given back, and what is left is said.

use lafet_texts::{Text as _, Words, acceptance as text};

use super::{Held, Monitors, Run};
use crate::order::Order;
use crate::wire::{Failed, Person, Wire};

/// Tries, and the pause between them, ms.
const TRIES: usize = 10;
const PAUSE_MS: u64 = 500;

/// What came of an order at the end.
#[derive(Debug)]
enum Done {
    Yes,
    /// It is refused: by `code`, with these words.
    Refused(String, Words),
    Lost(Words),
}

impl<W: Wire, P: Person> Run<'_, W, P> {
    /// Ends all that was started.
    pub(super) async fn undo(&mut self) {
        if let Some(ended) = &self.out.ended {
            self.person.hear(&ended.words());
        }
        self.wire.ends();
        self.leave_trial().await;
        let Some(Held { id, stowed, locked, .. }) = self.held.take() else { return };
        // Who has it by now may be at a fire: only its holder is this run's to stop.
        let monitor = id.as_str();
        if let Done::Refused(code, why) = self.insist(monitor, &Order::Take, 1).await
            && code == "held"
        {
            return self.leave_word(text::LeftTaken { monitor, why }.words());
        }
        // What is locked out is at rest, and refuses a Stop.
        let stopped = match locked && self.is_locked_out(monitor).await {
            true => Done::Yes,
            false => self.insist(monitor, &Order::Stop, TRIES).await,
        };
        // A hub that is not reached gives it back by itself.
        _ = self.insist(monitor, &Order::Release, 2).await;
        if let Done::Refused(_, why) | Done::Lost(why) = stopped {
            self.leave_word(text::LeftMonitor { monitor, why }.words());
        }
        if stowed {
            self.leave_word(text::LeftDeployed { monitor }.words());
        }
    }

    async fn is_locked_out(&mut self, id: &str) -> bool {
        let Ok(answer) = self.wire.get("/api/monitors").await else { return false };
        let Ok(monitors) = serde_json::from_value::<Monitors>(answer) else { return false };
        monitors.get(id).is_some_and(|it| it.is_heard() && it.is_locked_out())
    }

    pub(super) fn leave_word(&mut self, words: Words) {
        self.person.hear(&words);
        self.out.left.push(words);
    }

    /// Sends until it is accepted or refused, or the person gives it up.
    async fn insist(&mut self, monitor: &str, order: &Order, tries: usize) -> Done {
        let mut why = Words::default();
        for number in 0..tries {
            match self.wire.post(&order.posting(monitor)).await {
                Ok(_) => return Done::Yes,
                Err(Failed::Refused { code, text }) if code != "slow_down" => {
                    return Done::Refused(code, text);
                }
                Err(failed) => why = failed.words(),
            }
            if number == 0 && *order == Order::Stop {
                // Who is beside it may have to stop it, and hears of it at once.
                self.person.hear(&text::NotReached { monitor, why: &why }.words());
            }
            if self.wire.settle(PAUSE_MS).await.is_err() {
                break;
            }
        }
        Done::Lost(why)
    }
}
