// The run that updates monitors, in the strip of every page.
import { placeOf, runNow, underUpdate } from '../hub/updates';
import { num, t } from '../i18n';

/** What the strip says of it on a page of this monitor, or of the site; empty: no run goes on. */
export function updatingWords(monitor: string | null): string {
  const run = runNow();
  if (!run) return '';
  const at = underUpdate();
  if (at === null) return t('banner.updating_between');
  if (at === monitor) return t('banner.updating_this', { monitor: at });
  return t('banner.updating', { monitor: at, n: num(placeOf(run) + 1), all: num(run.monitors.length) });
}
