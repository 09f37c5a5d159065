//! Any orders in any order, with losses of power: only images that were signed for this board and
//! committed are started, and never an older one.

use crate::bench::{Chip, Image, KEYS, WORD, factory, fields, image, payload, signed, start};
use crate::flash::{Cut, Torn};
use lafet_update::{BoardName, Hash, Header, Receiver, SigningKey, Version};

type App = Receiver<'static, Chip<4, 256>>;

/// Good images of versions 1 to 6, then what must never be started.
fn pool() -> Vec<Image> {
    let mut pool: Vec<Image> = (1..=6).map(|major| image(major, 8 * usize::from(major))).collect();
    let stranger = SigningKey::new(0, [99; 32]);
    pool.push(signed(&stranger, &fields(7), payload(7, 64)));
    let other = Header { board: BoardName::new("other").unwrap(), ..fields(8) };
    pool.push(signed(&KEYS[0], &other, payload(8, 64)));
    let mut patched = image(9, 64);
    patched.payload[8] ^= 0x40;
    pool.push(patched);
    let mut renamed = image(2, 64);
    renamed.raw[16] = 10;
    pool.push(renamed);
    pool
}

struct Player {
    dice: Chip<8, 256>,
    pool: Vec<Image>,
    confirmed: u16,
}

impl Player {
    fn roll(&self, sides: u64) -> u64 {
        self.dice.random() % sides
    }

    fn order(&mut self, app: &mut App, of: usize) {
        let image = &self.pool[of];
        let there = app.report().received;
        // Most are refused, which is right: what counts is what is started afterwards.
        let _ = match self.roll(17) {
            0 | 1 => app.begin(&image.raw, Hash::of(WORD), false).map(drop),
            2..=9 => {
                let rest = image.payload.get(there as usize..).unwrap_or_default();
                let part = &rest[..rest.len().min(8 * (1 + self.roll(4) as usize))];
                app.data(there, part).map(drop)
            }
            10 => app.data(self.roll(80) as u32, &image.payload[..8]).map(drop),
            11 | 12 => app.verify(),
            13 => app.poll(),
            14 => app.commit(Hash::of(WORD)),
            15 => app.abandon(Hash::of(WORD)),
            _ => {
                let trial = app.report().started;
                let word = if self.roll(2) == 0 { WORD } else { b"no" };
                app.confirm(word).map(|()| {
                    assert!(trial.trial && word == WORD);
                    self.confirmed = trial.version.0[0];
                })
            }
        };
    }

    /// A life of many starts; how many updates were confirmed.
    fn play(&mut self, starts: usize) -> u16 {
        let mut flash: Chip<4, 256> = factory(&self.pool[0], self.dice.random());
        for _ in 0..starts {
            flash = flash.power_on();
            if self.roll(4) == 0 {
                let torn = Torn::ALL[self.roll(6) as usize];
                flash.cut(Cut { step: self.roll(60), torn });
            }
            let mut app = match start(flash) {
                Ok(app) => app,
                Err(off) => {
                    assert!(off.is_off(), "a board always starts");
                    flash = *off;
                    continue;
                }
            };
            let started = app.report().started;
            let Version([major, ..]) = started.version;
            assert!(major <= 6, "version {major} is not to be trusted");
            if !app.memory().flash().is_off() {
                assert!(major >= self.confirmed, "never an older one");
            }
            let mut of = self.roll(self.pool.len() as u64) as usize;
            for _ in 0..self.roll(60) {
                if self.roll(24) == 0 {
                    of = self.roll(self.pool.len() as u64) as usize;
                }
                self.order(&mut app, of);
            }
            flash = app.into_memory().into_flash();
        }
        self.confirmed
    }
}

#[test]
fn any_orders() {
    let mut updates = 0;
    for seed in 0..40 {
        let mut player = Player { dice: Chip::new(1, seed), pool: pool(), confirmed: 0 };
        updates += player.play(60);
    }
    assert!(updates > 20, "some of the orders make updates: {updates}");
}
