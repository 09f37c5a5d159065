// Pictures out of access units, by the browser's own decoder. It is given nothing before a key frame, and begins again with
// one after each of its errors.

/** What a decoder makes one picture of. */
export interface Unit {
  key: boolean;
  number: number;
  shown_us: number;
  at_ms: number;
  codec: string;
  data: Uint8Array;
}

/** A picture that is ready to be drawn. It has to be closed. */
export interface Decoded {
  frame: VideoFrame;
  number: number;
  at_ms: number;
}

/** Why nothing is decoded: the page came without TLS, the browser has no decoder, or none for this codec. */
export type NoDecoder = 'insecure' | 'browser' | 'codec';

/** Units that a decoder keeps at most; the hub sends 1.5 s ahead, and at the beginning what came since a key frame. */
const INSIDE_MAX = 600;

type Made = typeof VideoDecoder;

export class Decoding {
  private decoder: VideoDecoder | null = null;
  private codec = '';
  /** Units inside of the decoder, by the time that it gives back with each. */
  private readonly inside = new Map<number, { number: number; at_ms: number }>();
  /** Codecs that this browser does not decode. */
  private readonly refused = new Set<string>();
  none: NoDecoder | null = null;

  constructor(
    private readonly decoded: (picture: Decoded) => void,
    private readonly Decoder: Made | undefined = globalThis.VideoDecoder,
  ) {
    if (!Decoder) this.none = globalThis.isSecureContext === false ? 'insecure' : 'browser';
  }

  /** Units that wait for the decoder. */
  get queue(): number {
    return this.decoder?.decodeQueueSize ?? 0;
  }

  push(unit: Unit): void {
    if (!this.Decoder || (!unit.key && !this.decoder)) return;
    if (unit.key && !this.ready(unit.codec, this.Decoder)) return;
    this.inside.set(unit.shown_us, { number: unit.number, at_ms: unit.at_ms });
    for (const old of this.inside.keys()) {
      if (this.inside.size <= INSIDE_MAX) break;
      this.inside.delete(old);
    }
    try {
      const type = unit.key ? 'key' : 'delta';
      this.decoder?.decode(new EncodedVideoChunk({ type, timestamp: unit.shown_us, data: unit.data }));
    } catch {
      this.reset();
    }
  }

  close(): void {
    this.reset();
  }

  /** A decoder for this codec. */
  private ready(codec: string, Decoder: Made): boolean {
    if (this.decoder && this.codec === codec) return true;
    this.reset();
    if (this.refused.has(codec)) return false;
    const decoder: VideoDecoder = new Decoder({
      output: (frame) => this.output(decoder, frame),
      error: (error) => {
        if (this.decoder !== decoder) return;
        if (error.name === 'NotSupportedError') this.refuse(codec);
        this.reset();
      },
    });
    this.decoder = decoder;
    this.codec = codec;
    try {
      // Without a description the units are of Annex B, with their parameter sets.
      decoder.configure({ codec, optimizeForLatency: true });
    } catch {
      this.refuse(codec);
      this.reset();
      return false;
    }
    return true;
  }

  private refuse(codec: string): void {
    if (this.refused.size < 8) this.refused.add(codec);
    this.none = 'codec';
  }

  private output(of: VideoDecoder, frame: VideoFrame): void {
    const unit = this.inside.get(frame.timestamp);
    this.inside.delete(frame.timestamp);
    if (!unit || of !== this.decoder) {
      frame.close();
      return;
    }
    this.none = null;
    this.decoded({ frame, ...unit });
  }

  private reset(): void {
    const { decoder } = this;
    this.decoder = null;
    this.inside.clear();
    if (decoder && decoder.state !== 'closed') decoder.close();
  }
}
