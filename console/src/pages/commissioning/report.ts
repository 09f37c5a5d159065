// The report of commissioning: a page of its own (no script, prints on paper), or JSON.
import type { Params, Text } from '../../hub/types';
import { dateTime, lang, t, tt } from '../../i18n';
import { type Fact, type Progress, type StepId, verdict } from './model';

export interface About {
  id: string;
  name: Text;
  address: number;
  endpoint: string;
  hub: string;
  simulation: boolean;
  at_ms: number;
}

/** Parameters that commissioning is about. */
const SETTINGS: Record<string, string[]> = {
  General: ['Address', 'Chain', 'MoveTimeout'],
  Horizontal: ['ZeroPoint', 'MinLimit', 'MaxLimit', 'Speed', 'MaxCurrent'],
  Vertical: ['ZeroPoint', 'MinLimit', 'MaxLimit', 'Speed', 'MaxCurrent'],
  Nozzle: ['ZeroPoint', 'MinLimit', 'MaxLimit', 'Speed', 'MaxCurrent'],
  Valve1: ['TravelTime'],
  Valve2: ['TravelTime'],
  Detector: ['JustifyHorizontal', 'JustifyVertical', 'Threshold'],
};

export function settings(params: Params | undefined): { title: string; values: number[] }[] {
  return Object.entries(SETTINGS).flatMap(([subsystem, names]) =>
    names.flatMap((name) => {
      const values = params?.values[subsystem]?.[name]?.values;
      return values ? [{ title: `${subsystem}.${name}`, values }] : [];
    }),
  );
}

export function factText(fact: Fact): string {
  return t(fact.key, fact.args);
}

export function people(progress: Progress): string[] {
  return [...new Set(Object.values(progress.steps).map((done) => done.by))];
}

export function reportJson(
  about: About,
  progress: Progress,
  steps: readonly StepId[],
  params: Params | undefined,
): string {
  const report = {
    report: 'lafet commissioning',
    version: 1,
    ...about,
    begun_ms: progress.begun_ms,
    verdict: verdict(progress, steps),
    people: people(progress),
    steps: steps.map((id) => {
      const done = progress.steps[id];
      return {
        step: id,
        title: t(`commissioning.step.${id}`),
        state: done?.state ?? 'open',
        at_ms: done?.at_ms ?? null,
        by: done?.by ?? null,
        reason: done?.reason ?? null,
        found: (done?.facts ?? []).map((fact) => ({ ...fact, text: factText(fact) })),
      };
    }),
    settings: Object.fromEntries(settings(params).map(({ title, values }) => [title, values])),
  };
  return `${JSON.stringify(report, null, 2)}\n`;
}

export function reportHtml(
  about: About,
  progress: Progress,
  steps: readonly StepId[],
  params: Params | undefined,
): string {
  const outcome = verdict(progress, steps);
  const facts: [string, string][] = [
    [t('commissioning.report.monitor'), `${about.id} · ${tt(about.name)}`],
    [t('commissioning.report.address'), String(about.address)],
    [t('commissioning.report.link'), about.endpoint],
    [t('commissioning.report.when'), `${dateTime(progress.begun_ms)} … ${dateTime(about.at_ms)}`],
    [t('commissioning.report.who'), people(progress).join(', ') || '—'],
    [t('commissioning.report.hub'), about.hub],
  ];
  return `<!doctype html>
<html lang="${lang()}">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>${escaped(t('commissioning.report.title'))}: ${escaped(about.id)}</title>
<style>
body { font: 14px/1.5 system-ui, 'Segoe UI', Roboto, Arial, sans-serif; color: #151c23; margin: 40px auto; max-width: 820px; padding: 0 24px; }
h1 { font-size: 24px; margin: 0 0 4px; }
h2 { font-size: 16px; margin: 28px 0 8px; }
.verdict { display: inline-block; margin: 12px 0 16px; padding: 6px 14px; border: 2px solid; font-weight: 700; letter-spacing: .04em; }
.failed, .open { color: #b81d13; }
.passed { color: #0a5cad; }
table { border-collapse: collapse; width: 100%; }
th, td { text-align: left; vertical-align: top; padding: 7px 10px; border-bottom: 1px solid #c6cdd3; }
th { font-size: 12px; color: #4d5a66; }
td.n { font-variant-numeric: tabular-nums; }
ul { margin: 0; padding-left: 18px; }
.note { padding: 8px 12px; background: #f7e5c6; }
.sign { display: grid; grid-template-columns: 1fr 1fr; gap: 40px; margin-top: 56px; }
.sign div { border-top: 1px solid #151c23; padding-top: 6px; color: #4d5a66; }
tr { break-inside: avoid; }
@media print { body { margin: 0; } }
</style>
</head>
<body>
<h1>${escaped(t('commissioning.report.title'))}</h1>
<div class="verdict ${outcome}">${escaped(t(`commissioning.report.${outcome}`))}</div>
${about.simulation ? `<p class="note">${escaped(t('commissioning.report.simulation'))}</p>` : ''}
<table>${facts.map(([name, value]) => `<tr><th>${escaped(name)}</th><td>${escaped(value)}</td></tr>`).join('')}</table>
<h2>${escaped(t('commissioning.steps'))}</h2>
<table>
<tr><th>${escaped(t('commissioning.report.step'))}</th><th>${escaped(t('commissioning.report.outcome'))}</th><th>${escaped(t('commissioning.report.found'))}</th></tr>
${steps.map((id) => stepRow(progress, id)).join('\n')}
</table>
<h2>${escaped(t('commissioning.report.settings'))}</h2>
<table>
${settings(params)
  .map(({ title, values }) => `<tr><td>${escaped(title)}</td><td class="n">${values.join(', ')}</td></tr>`)
  .join('\n')}
</table>
<div class="sign"><div>${escaped(t('commissioning.report.who'))}</div><div>${escaped(t('commissioning.report.signature'))}</div></div>
</body>
</html>
`;
}

function stepRow(progress: Progress, id: StepId): string {
  const done = progress.steps[id];
  const state = done ? t(`commissioning.state.${done.state}`) : t('commissioning.report.not_done');
  const when = done ? `<br>${escaped(dateTime(done.at_ms))}, ${escaped(done.by)}` : '';
  const lines = [...(done?.reason ? [done.reason] : []), ...(done?.facts ?? []).map(factText)];
  const found = lines.length ? `<ul>${lines.map((text) => `<li>${escaped(text)}</li>`).join('')}</ul>` : '';
  const kind = done?.state ?? 'open';
  return `<tr><td>${escaped(t(`commissioning.step.${id}`))}</td><td class="${kind}"><b>${escaped(state)}</b>${when}</td><td>${found}</td></tr>`;
}

export function escaped(text: string): string {
  const meant: Record<string, string> = { '&': '&amp;', '<': '&lt;', '>': '&gt;', '"': '&quot;' };
  return text.replace(/[&<>"]/g, (c) => meant[c]!);
}
