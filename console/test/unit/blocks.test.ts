import { expect, test } from 'vitest';
import { divided } from '../../src/parts/blocks';

test('every row is in one block, in order', () => {
  for (const [count, anchor] of [
    [0, 0],
    [1, 0],
    [25, 0],
    [26, 0],
    [1000, 0],
    [1000, 7],
    [1000, 999],
  ] as const) {
    const parts = divided(count, anchor);
    expect(parts.map(({ to }) => to).at(-1) ?? 0).toBe(count);
    parts.forEach(({ from, key }, n) => {
      expect(from).toBe(n ? parts[n - 1]!.to : 0);
      if (n) expect(key).toBe(parts[n - 1]!.key + 1);
    });
  }
});

test('what comes above or below leaves the rows in their blocks', () => {
  const keyOf = (parts: ReturnType<typeof divided>, row: number) => parts.find(({ to }) => row < to)!.key;
  const before = divided(100, 0);
  // Three more above, forty below: the anchor is now the fourth.
  const after = divided(143, 3);
  for (let row = 0; row < 100; row += 1) expect(keyOf(after, row + 3)).toBe(keyOf(before, row));
});
