// What the hub has told since this page was first opened.
import { socket } from '../../hub/socket';
import type { EventSeen } from '../../hub/types';

const MOST = 500;

export const liveEvents: EventSeen[] = [];
export const liveChanged = new EventTarget();

socket.on('event', (event) => {
  liveEvents.unshift(event);
  liveEvents.length = Math.min(liveEvents.length, MOST);
  liveChanged.dispatchEvent(new Event('change'));
});
