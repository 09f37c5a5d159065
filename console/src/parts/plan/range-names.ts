// Placement of the distances of the rings: on the ring, near the barrel's direction, covering nothing else.
import type { Place } from '../geometry';
import { type Box, box, hidden } from './names';

export interface RangeName {
  range: number;
  text: string;
  /** Written even where it covers something. */
  strong: boolean;
}

const HIGH_PX = 16;
/** For 11 px letters, with a margin. */
const LETTER_PX = 6.8;
/** From the barrel outwards, alternately to the right and to the left; not on the line of the barrel. */
const TURNS = [24, 32, 40, 50, 60, 75, 90, 110, 130, 150, 170].flatMap((turn) => [turn, -turn]);

/** Those that fit. `on` is the place of a ring at a number of degrees from the barrel. */
export function rangePlaces(
  wanted: readonly RangeName[],
  on: (range: number, turn: number) => Place,
  screen: Place,
  taken: readonly Box[],
): (RangeName & { at: Place })[] {
  const placed: (RangeName & { at: Place })[] = [];
  const boxes = [...taken];
  for (const name of wanted) {
    const tried = TURNS.map((turn) => {
      const at = on(name.range, turn);
      return { at, cost: hidden(rangeBox(name, at), boxes, screen) };
    });
    const best = tried.find(({ cost }) => cost === 0) ?? tried.reduce((a, b) => (b.cost < a.cost ? b : a));
    if (best.cost > 0 && !name.strong) continue;
    placed.push({ ...name, at: best.at });
    boxes.push(rangeBox(name, best.at));
  }
  return placed;
}

export function rangeBox({ text, strong }: RangeName, at: Place): Box {
  return box(at, text.length * LETTER_PX * (strong ? 1.08 : 1) + 8, HIGH_PX);
}
