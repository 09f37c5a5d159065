import { describe, expect, it, vi } from 'vitest';
import { store } from '../../src/hub/store';
import { quenchOf, whyNotAim } from '../../src/pages/operate/state';

describe('the sector of a program that runs', () => {
  it('is read from its request', () => {
    const request = 'StartQuench Control centre=1200,-300 nozzle=60 sector=600,120 step=2 distance=25';
    expect(quenchOf(request)).toEqual({
      centre_arcmin: [1200, -300],
      width_arcmin: 600,
      height_arcmin: 120,
      distance_m: 25,
    });
  });

  it('is not known of a stored program or of anything else', () => {
    expect(quenchOf('StartQuench Control program=3 centre=0,0 nozzle=60')).toBeNull();
    expect(quenchOf('StartSeek Detector -5400 5400 -600 600')).toBeNull();
    expect(quenchOf(null)).toBeNull();
  });
});

describe('aiming on the plan', () => {
  const hub = (site: unknown) =>
    vi
      .spyOn(store, 'get')
      .mockImplementation(((topic: string) => (topic === 'hub' ? { site } : undefined)) as typeof store.get);

  it('is not offered at a monitor without a place among others that have one', () => {
    const place = { at: [0, 0], heading: 0, height: 2 };
    hub({ monitors: { M1: place } });
    expect(whyNotAim('M3')).toBe('operate.no_place');
    expect(whyNotAim('M1')).not.toBe('operate.no_place');
    hub(null);
    expect(whyNotAim('M3')).toBe(whyNotAim('M1'));
    vi.restoreAllMocks();
  });
});
