import { expect, test } from 'vitest';
import type { Site } from '../../src/hub/types';
import { shownPlaces } from '../../src/parts/plan/model';
import { standAlone } from '../../src/parts/stand-alone';

const site = {
  monitors: { M1: { at: [0, 0], heading: 0, height: 2 }, M2: { at: [30, 0], heading: 90, height: 2 } },
  tanks: [{ name: 'T-1', at: [15, 10], diameter: 8, height: 6 }],
  walls: [],
  keep_outs: [],
} as unknown as Site;
const ids = ['M1', 'M2', 'M3', 'M4'];

test('a monitor without a place is beside the plan, not at an invented place on it', () => {
  const shown = standAlone(site, ids);
  expect(Object.keys(shown.monitors)).toEqual(['M1', 'M2']);
  expect(shown.unplaced).toEqual(['M3', 'M4']);
  expect(shown.schematic).toBeUndefined();
  expect(shownPlaces(shown, null, [], []), 'the plan is as large as without it').toEqual(
    shownPlaces(standAlone(site, ['M1', 'M2']), null, [], []),
  );
  expect(standAlone(site, ids, 'M1').monitors, 'the chosen one has its place').toEqual(site.monitors);
});

test('one that the operator works on is alone on the plan, among nothing that has a place', () => {
  const { monitors, tanks, schematic, unplaced } = standAlone(site, ids, 'M3');
  expect(Object.keys(monitors)).toEqual(['M3']);
  expect(tanks).toEqual([]);
  expect(schematic).toBe(true);
  expect(unplaced).toEqual(['M4']);
});

test('without any place the plan is a schematic of all monitors', () => {
  for (const none of [null, { ...site, monitors: {}, tanks: [] } as Site]) {
    const { monitors, schematic, unplaced } = standAlone(none, ['M1', 'M2'], 'M1');
    expect(Object.keys(monitors)).toEqual(['M1', 'M2']);
    expect([schematic, unplaced]).toEqual([true, undefined]);
  }
  const tanks = standAlone({ ...site, monitors: {} } as Site, ['M1']);
  expect([tanks.schematic, tanks.unplaced, tanks.monitors]).toEqual([undefined, ['M1'], {}]);
});
