// The cameras of the site, and the pictures of one of them over a WebSocket of its own. docs/cameras.md has the layout of
// the messages.
import type { CameraView } from './api';
import { store } from './store';

const LAYOUT = 1;
const HEAD = 36;
const KEY = 1;
const CAPTURED = 2;
const DAMAGED = 4;

const RETRY_FIRST_MS = 500;
const RETRY_MOST_MS = 4000;
/** The hub is sent what was taken this often, ms: without that it sends no more. */
const SEEN_EACH_MS = 150;

/** What a decoder makes one picture of. */
export interface PictureUnit {
  key: boolean;
  /** Packets were lost since the last key frame. */
  damaged: boolean;
  number: number;
  /** When it is to be shown, since the first one, µs. */
  shown_us: number;
  /** When it reached the hub, ms since 1970. */
  at_ms: number;
  /** When it was taken by the camera's clock, ms since 1970; null: the camera does not say so. */
  captured_ms: number | null;
  width: number;
  height: number;
  /** With a key frame: as decoders name it. */
  codec: string;
  data: Uint8Array;
}

/** The cameras that look at a monitor. */
export function camerasOf(monitor: string): CameraView[] {
  const all = store.keys('cameras/').map((topic) => store.get(topic) as CameraView | undefined);
  return all.flatMap((camera) => (camera?.monitors.includes(monitor) ? [camera] : []));
}

/** The picture in a message; null: this page does not know its layout. */
export function pictureOf(message: ArrayBuffer): PictureUnit | null {
  if (message.byteLength <= HEAD) return null;
  const view = new DataView(message);
  const codec_length = view.getUint16(2);
  if (view.getUint8(0) !== LAYOUT || HEAD + codec_length >= message.byteLength) return null;
  const flags = view.getUint8(1);
  const captured_us = Number(view.getBigUint64(24));
  return {
    key: (flags & KEY) !== 0,
    damaged: (flags & DAMAGED) !== 0,
    number: view.getUint32(4),
    shown_us: Number(view.getBigInt64(8)),
    at_ms: Number(view.getBigUint64(16)),
    captured_ms: flags & CAPTURED ? captured_us / 1000 : null,
    width: view.getUint16(32),
    height: view.getUint16(34),
    codec: String.fromCharCode(...new Uint8Array(message, HEAD, codec_length)),
    data: new Uint8Array(message, HEAD + codec_length),
  };
}

/** What says that a picture was taken. */
export function seenOf(number: number): ArrayBuffer {
  const message = new ArrayBuffer(4);
  new DataView(message).setUint32(0, number);
  return message;
}

/** The connection to a camera: it is made again until it is closed. */
export class CameraStream {
  private ws: WebSocket | null = null;
  private timer = 0;
  private retry_ms = RETRY_FIRST_MS;
  private closed = false;
  private seen: number | null = null;
  private seenTimer = 0;

  constructor(
    private readonly camera: string,
    private readonly came: (unit: PictureUnit) => void,
  ) {
    this.open();
  }

  close(): void {
    this.closed = true;
    clearTimeout(this.timer);
    clearTimeout(this.seenTimer);
    this.ws?.close();
  }

  /** The decoder has taken the picture with this number. */
  hasTaken(number: number): void {
    this.seen = number;
    if (this.seenTimer) return;
    this.seenTimer = window.setTimeout(() => {
      this.seenTimer = 0;
      if (this.seen !== null && this.ws?.readyState === WebSocket.OPEN) this.ws.send(seenOf(this.seen));
      this.seen = null;
    }, SEEN_EACH_MS);
  }

  private open(): void {
    const at = `${location.origin.replace(/^http/, 'ws')}/api/cameras/${encodeURIComponent(this.camera)}/stream`;
    const ws = new WebSocket(at);
    ws.binaryType = 'arraybuffer';
    this.ws = ws;
    ws.onmessage = (event) => {
      const unit = event.data instanceof ArrayBuffer ? pictureOf(event.data) : null;
      if (!unit || this.closed) return;
      this.retry_ms = RETRY_FIRST_MS;
      this.came(unit);
    };
    ws.onclose = () => {
      if (this.closed) return;
      this.timer = window.setTimeout(() => this.open(), this.retry_ms);
      this.retry_ms = Math.min(this.retry_ms * 2, RETRY_MOST_MS);
    };
  }
}
