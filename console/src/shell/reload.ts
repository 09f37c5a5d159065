// When the page may be loaded again by itself: what is on its way, or was not confirmed, is known to this page only.
import { commands } from '../hub/commands';
import { isInsisting } from '../hub/urgent';
import { notes } from './toasts';

const AGAIN_MS = 500;

/** A Stop, Close, Lockout or Abort has no answer yet. */
function unsettled(): boolean {
  return commands.pending || isInsisting();
}

/** Whether nothing is lost: no order is on its way, and no note waits to be dismissed. */
export function mayReload(): boolean {
  return !unsettled() && !notes.stay;
}

let waits = false;

/** Loads the page again after this time, and as soon as no order is on its way; once, however often it is called. */
export function reloadWhenSettled(after_ms = 0): void {
  if (waits) return;
  waits = true;
  const look = () => {
    if (unsettled()) return void setTimeout(look, AGAIN_MS);
    waits = false;
    location.reload();
  };
  setTimeout(look, after_ms);
}
