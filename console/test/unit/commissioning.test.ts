import { describe, expect, it } from 'vitest';
import {
  begun,
  buttonState,
  type Done,
  finish,
  gate,
  keepWork,
  nextOf,
  type Progress,
  readProgress,
  redo,
  STEPS,
  type StepId,
  type StopTest,
  stepsOf,
  stopTest,
  verdict,
  wayOf,
  whyNotLimits,
} from '../../src/pages/commissioning/model';
import { escaped, reportHtml, reportJson, settings } from '../../src/pages/commissioning/report';

const passed: Done = { state: 'passed', at_ms: 5, by: 'anna', facts: [] };
const failed: Done = { ...passed, state: 'failed', reason: 'no <water>' };
const upTo = (last: StepId, done = passed): Progress =>
  STEPS.slice(0, STEPS.indexOf(last) + 1).reduce((p, id) => finish(p, id, done), begun(1));

describe('the checklist', () => {
  it('has the steps of what the monitor has', () => {
    expect(stepsOf(['General', 'Horizontal', 'Vertical'])).toEqual([
      'prepare',
      'stop',
      'directions',
      'zero',
      'limits',
      'tune',
      'sensors',
      'lockout',
    ]);
    expect(stepsOf(['Nozzle', 'Valve2', 'ExtButtons', 'Detector', 'Climatics'])).toEqual([...STEPS]);
  });

  it('refuses to skip', () => {
    const steps = [...STEPS];
    expect(gate(begun(1), steps, 'prepare')).toBe(null);
    expect(gate(begun(1), steps, 'valves')).toBe('prepare');
    expect(gate(upTo('prepare'), steps, 'directions')).toBe('stop');
    expect(gate(upTo('directions'), steps, 'zero')).toBe(null);
  });

  it('goes on after a failure that has a reason, but never past STOP and the directions', () => {
    const steps = [...STEPS];
    const valves = finish(upTo('tune'), 'valves', failed);
    expect(gate(valves, steps, 'sensors')).toBe(null);
    expect(nextOf(valves, steps)).toBe('sensors');
    for (const id of ['prepare', 'stop', 'directions'] as const) {
      const progress = finish(upTo(id), id, failed);
      expect(gate(progress, steps, 'zero')).toBe(id);
      expect(nextOf(progress, steps)).toBe(id);
    }
  });

  it('is passed only when every step is', () => {
    const steps = [...STEPS];
    expect(verdict(upTo('lockout'), steps)).toBe('passed');
    expect(verdict(upTo('climatics'), steps)).toBe('open');
    expect(verdict(finish(upTo('lockout'), 'buttons', failed), steps)).toBe('failed');
    expect(nextOf(upTo('lockout'), steps)).toBe(null);
  });

  it('repeats what depends on a step', () => {
    const all = keepWork(upTo('lockout'), 'limits', { Horizontal: 1 });
    const again = redo(all, 'zero');
    expect(again.steps.zero).toBe(undefined);
    expect(again.steps.limits).toBe(undefined);
    expect(again.work.limits).toBe(undefined);
    expect(again.steps.nozzle).toBe(passed);
  });

  it('is read from the browser, and not if it is corrupt', () => {
    const stored = (text: string | null) => readProgress('M1', { getItem: () => text });
    expect(stored(JSON.stringify(upTo('stop')))).toEqual(upTo('stop'));
    for (const text of [null, '', '{', '{"begun_ms":1}', '[]']) expect(stored(text)).toBe(null);
  });
});

describe('the test of STOP', () => {
  const run = (...seen: Parameters<typeof stopTest>[1][]): StopTest =>
    seen.reduce<StopTest>(stopTest, { phase: 'idle' });
  const status = (moving: boolean, at_ms: number) => ({ kind: 'status', moving, at_ms }) as const;
  const stop = (at_ms: number) => ({ kind: 'stop', at_ms }) as const;

  it('passes when the monitor is at rest after STOP', () => {
    const test = run(status(true, 100), stop(150), status(true, 140), status(true, 200), status(false, 300));
    expect(test).toMatchObject({ phase: 'passed', took_ms: 150 });
  });

  it('takes nothing that the monitor said before STOP for its effect', () => {
    expect(run(status(true, 100), stop(150), status(false, 120)).phase).toBe('stopping');
  });

  it('does not pass by a release, nor by STOP at rest', () => {
    expect(run(status(true, 100), status(false, 200), stop(250))).toEqual({ phase: 'idle', why: 'let_go' });
    expect(run(stop(50), status(false, 100)).phase).toBe('idle');
  });

  it('fails when it moves on', () => {
    expect(run(status(true, 100), stop(150), status(true, 2200))).toEqual({ phase: 'failed', why: 'moves_on' });
  });
});

describe('what is seen', () => {
  it('detects directions', () => {
    expect(wayOf('Horizontal', 'max', 0, 90)).toBe('right');
    expect(wayOf('Horizontal', 'min', 0, 90)).toBe('wrong');
    expect(wayOf('Vertical', 'min', 0, -59)).toBe('little');
    expect(wayOf('Nozzle', 'min', 60, 57)).toBe('right');
  });

  it('detects buttons', () => {
    const flags = ['LeftButtonState=Pressed', 'OpenButtonState=Open', 'UpButtonState=Short'];
    expect(buttonState(flags, 'Left')).toBe('Pressed');
    expect(buttonState(flags, 'Open')).toBe('Open');
    expect(buttonState(flags, 'Up')).toBe('Short');
    expect(buttonState(flags, 'Close')).toBe('Released');
  });
});

describe('the report', () => {
  const about = {
    id: 'M1',
    name: { en: 'West', ru: 'Запад' },
    address: 1,
    endpoint: 'sim:',
    hub: 'lafet 1',
    simulation: true,
    at_ms: 9,
  };
  const params = {
    at_ms: 1,
    reading: false,
    progress: null,
    values: { Horizontal: { MaxLimit: { values: [10800] }, Speed: { error: { en: 'x', ru: 'x' } } } },
  };

  it('has steps, reasons and settings, and nothing of it is markup', () => {
    const html = reportHtml(about, finish(upTo('lockout'), 'valves', failed), [...STEPS], params);
    expect(html).toContain('no &lt;water&gt;');
    expect(html).not.toContain('<water>');
    expect(html).toContain('<td>Horizontal.MaxLimit</td><td class="n">10800</td>');
    expect(escaped('<a href="x">&')).toBe('&lt;a href=&quot;x&quot;&gt;&amp;');
    expect(settings(params)).toEqual([{ title: 'Horizontal.MaxLimit', values: [10800] }]);
  });

  it('is JSON as well', () => {
    const report = JSON.parse(reportJson(about, upTo('stop'), [...STEPS], params)) as Record<string, unknown>;
    expect(report.verdict).toBe('open');
    expect(report.people).toEqual(['anna']);
    expect((report.steps as { step: string; state: string }[])[2]).toMatchObject({ step: 'directions', state: 'open' });
    expect(report.settings).toEqual({ 'Horizontal.MaxLimit': [10800] });
  });
});

describe('taken limits', () => {
  it('are checked together with the unchanged ones', () => {
    const now = { min: -900, max: 5400 };
    expect(whyNotLimits('Vertical', { max: 4800 }, now)).toBe('');
    expect(whyNotLimits('Vertical', { max: -1200 }, now)).toBe('order');
    expect(whyNotLimits('Vertical', { max: -800 }, now)).toBe('narrow');
    expect(whyNotLimits('Vertical', { min: 0, max: 3000 }, null)).toBe('');
    expect(whyNotLimits('Nozzle', { min: 10, max: 14 }, null)).toBe('narrow');
  });
});
