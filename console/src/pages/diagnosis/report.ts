// A file for service: all current data of a monitor.
import { HubError } from '../../hub/errors';
import { http } from '../../hub/http';
import { store } from '../../hub/store';
import { lang, t } from '../../i18n';
import { toast } from '../../shell/toasts';
import { saveFile, stamp } from '../alarms/common';
import { samplesOf } from './samples';

/** The data, or why they could not be read: a report without one part is better than none. */
async function part(path: string): Promise<unknown> {
  try {
    return await http.get(path);
  } catch (cause) {
    const error = HubError.of(cause);
    return { error: { code: error.code, text: error.text(lang()) } };
  }
}

export async function reportOf(monitor: string): Promise<Record<string, unknown>> {
  const base = `/api/monitors/${encodeURIComponent(monitor)}`;
  const query = new URLSearchParams({ monitor, limit: '500' });
  const [now, params, crash, history, health] = await Promise.all([
    part(base),
    part(`${base}/params`),
    part(`${base}/crash`),
    part(`/api/alarms/history?${query}`),
    part('/health'),
  ]);
  return {
    what: 'lafet service report',
    version: 1,
    made_at: new Date(store.now()).toISOString(),
    made_by: store.hello?.user ?? null,
    hub: store.hello?.hub ?? null,
    health,
    monitor: now,
    heard: !store.stale(monitor),
    params,
    crash,
    alarms: store.alarms(monitor),
    alarm_history: history,
    link_samples: samplesOf(monitor),
    page: { language: lang(), agent: navigator.userAgent },
  };
}

export async function saveReport(monitor: string): Promise<void> {
  const report = await reportOf(monitor);
  const name = `lafet-report-${monitor}-${stamp(store.now())}.json`;
  saveFile(name, 'application/json', JSON.stringify(report, null, 2));
  toast({ kind: 'ok', text: t('diagnosis.report_saved', { name }) });
}
