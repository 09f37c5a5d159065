// Stored images and the run that updates monitors, as the hub reports them. They are always those of now, also while a
// recording is shown.
import { http } from './http';
import { inTime } from './socket';
import { store } from './store';
import type { MonitorUpdate, StartUpdate, StoredImage, UpdateRun, Updates } from './types';

const PATH = '/api/updates';
/** States of the monitor that the run is at. */
const ACTIVE: readonly MonitorUpdate['state'][] = ['checking', 'locking', 'updating', 'unlocking'];

/** The last report; null: the hub has not reported, or does not update monitors. */
export function updatesNow(): Updates | null {
  return store.getLive('updates') ?? null;
}

/** The run that goes on; null: none does. */
export function runNow(): UpdateRun | null {
  const run = updatesNow()?.run;
  return run?.state === 'running' ? run : null;
}

/** The place of the monitor that a run is at, from 0; -1: it is at none. */
export function placeOf(run: UpdateRun): number {
  return run.monitors.findIndex(({ state }) => ACTIVE.includes(state));
}

/** The monitor whose software is being updated now; null: none. */
export function underUpdate(): string | null {
  const run = runNow();
  return run?.monitors[placeOf(run)]?.id ?? null;
}

/** The hub's present state, where it has not published it. */
export function readUpdates(): Promise<Updates> {
  return http.get<Updates>(PATH);
}

export function storeImage(file: Blob): Promise<StoredImage> {
  return http.postFile<StoredImage>(`${PATH}/images`, file);
}

export function removeImage(digest: string): Promise<void> {
  return http.delete(`${PATH}/images/${encodeURIComponent(digest)}`);
}

export function startUpdate(wanted: StartUpdate): Promise<UpdateRun> {
  return http.post<UpdateRun>(inTime(PATH), wanted);
}

/** Ends the run before its next order. */
export function stopUpdate(): Promise<UpdateRun> {
  return http.post<UpdateRun>(`${PATH}/stop`);
}
