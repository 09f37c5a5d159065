import { describe, expect, it, vi } from 'vitest';
import { setSession } from '../../src/hub/me';
import { whyNot } from '../../src/hub/session';
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

describe('control that another window has', () => {
  it('is said to be of the user of this page, if only that one has the name', () => {
    const topics: Record<string, unknown> = {
      'monitors/M1/link': { state: 'up' },
      'monitors/M1/status': { at_ms: 1, stale: false, subsystems: {} },
      'monitors/M1/authority': { state: 'held', holder: { user: 'anna', seat: 's2' } },
    };
    vi.spyOn(store, 'get').mockImplementation(((topic: string) => topics[topic]) as typeof store.get);
    vi.spyOn(store, 'stale').mockReturnValue(false);
    vi.spyOn(store, 'linked', 'get').mockReturnValue(true);
    const at = (user: string, kind: string) => {
      store.hello = { user, role: 'operator', seat: 's1' } as never;
      setSession({ user, kind } as never);
      return whyNot('M1');
    };
    expect(at('anna', 'session')).toBe('why.held_self');
    expect(at('boris', 'session')).toBe('why.held');
    expect(at('anna', 'local'), 'all without a login have one name').toBe('why.held');
    store.hello = null;
    setSession(null);
    vi.restoreAllMocks();
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
