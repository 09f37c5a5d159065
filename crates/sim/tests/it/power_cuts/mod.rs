//! Power cuts in every word and every erase that a whole monitor writes, in every word and erase of
//! the start that follows, and random ones: nothing that was acknowledged as stored is lost, no
//! neighbour changes, the lockout stays, each start succeeds.

mod exhaustive;
mod held;
mod random;
mod rot;
