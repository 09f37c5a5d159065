import { beforeAll, describe, expect, it } from 'vitest';
import { pictureOf, seenOf } from '../../src/hub/cameras';
import { type Decoded, Decoding, type Unit } from '../../src/parts/picture/decoding';

/** A message as docs/cameras.md has it. */
function message(flags: number, codec: string, data: number[]): ArrayBuffer {
  const bytes = new Uint8Array(36 + codec.length + data.length);
  const view = new DataView(bytes.buffer);
  view.setUint8(0, 1);
  view.setUint8(1, flags);
  view.setUint16(2, codec.length);
  view.setUint32(4, 0xffff_fffe);
  view.setBigInt64(8, -40_000n);
  view.setBigUint64(16, 1_763_712_000_123n);
  view.setBigUint64(24, 1_763_712_000_100_500n);
  view.setUint16(32, 1920);
  view.setUint16(34, 1080);
  bytes.set(
    [...codec].map((c) => c.charCodeAt(0)),
    36,
  );
  bytes.set(data, 36 + codec.length);
  return bytes.buffer;
}

describe('a message of a camera', () => {
  it('is read as documented', () => {
    expect(pictureOf(message(3, 'avc1.64001f', [0, 0, 0, 1, 0x67]))).toEqual({
      key: true,
      damaged: false,
      number: 0xffff_fffe,
      shown_us: -40_000,
      at_ms: 1_763_712_000_123,
      captured_ms: 1_763_712_000_100.5,
      width: 1920,
      height: 1080,
      codec: 'avc1.64001f',
      data: new Uint8Array([0, 0, 0, 1, 0x67]),
    });
    const delta = pictureOf(message(4, '', [7]));
    expect(delta).toMatchObject({ key: false, damaged: true, captured_ms: null, codec: '' });
  });

  it('is left out if it is another one, or cut', () => {
    const other = message(0, '', [7]);
    new DataView(other).setUint8(0, 2);
    expect(pictureOf(other)).toBeNull();
    const whole = message(1, 'avc1.64001f', [7]);
    for (let end = 0; end < whole.byteLength; end++) expect(pictureOf(whole.slice(0, end))).toBeNull();
    new DataView(whole).setUint16(2, 0xffff);
    expect(pictureOf(whole)).toBeNull();
  });

  it('is answered with its number', () => {
    expect([...new Uint8Array(seenOf(0x0102_0304))]).toEqual([1, 2, 3, 4]);
  });
});

class FakeDecoder {
  static made: FakeDecoder[] = [];
  static unsupported = '';
  state: CodecState = 'unconfigured';
  decoded: number[] = [];
  constructor(readonly to: VideoDecoderInit) {
    FakeDecoder.made.push(this);
  }
  configure({ codec }: VideoDecoderConfig): void {
    this.state = 'configured';
    if (codec === FakeDecoder.unsupported) this.fail('NotSupportedError');
  }
  decode({ timestamp }: EncodedVideoChunk): void {
    if (this.state !== 'configured') throw new Error('closed');
    this.decoded.push(timestamp);
  }
  show(timestamp: number): { closed: boolean } {
    const frame = { timestamp, closed: false, close: () => (frame.closed = true) };
    this.to.output(frame as never);
    return frame;
  }
  fail(name: string): void {
    this.state = 'closed';
    this.to.error({ name } as DOMException);
  }
  close(): void {
    this.state = 'closed';
  }
}

const unit = (number: number, key = false, codec = 'avc1.64001f'): Unit => ({
  key,
  number,
  shown_us: number * 40_000,
  at_ms: 1000 + number,
  codec: key ? codec : '',
  data: new Uint8Array([7]),
});

describe('decoding', () => {
  beforeAll(() => {
    Object.assign(globalThis, {
      EncodedVideoChunk: class {
        timestamp: number;
        constructor(init: { timestamp: number }) {
          this.timestamp = init.timestamp;
        }
      },
    });
  });

  function started() {
    FakeDecoder.made = [];
    FakeDecoder.unsupported = '';
    const shown: Decoded[] = [];
    const decoding = new Decoding((picture) => shown.push(picture), FakeDecoder as never);
    return { shown, decoding, decoder: () => FakeDecoder.made.at(-1)! };
  }

  it('begins with a key frame, and gives each picture its number', () => {
    const { shown, decoding, decoder } = started();
    decoding.push(unit(1));
    expect(FakeDecoder.made).toHaveLength(0);
    for (const it of [unit(2, true), unit(5), unit(3)]) decoding.push(it);
    for (const number of [2, 3, 5]) decoder().show(number * 40_000);
    expect(shown.map(({ number, at_ms }) => [number, at_ms])).toEqual([
      [2, 1002],
      [3, 1003],
      [5, 1005],
    ]);
    const unknown = decoder().show(99);
    expect(unknown.closed).toBe(true);
    expect(shown).toHaveLength(3);
  });

  it('begins again with a key frame after an error', () => {
    const { shown, decoding, decoder } = started();
    decoding.push(unit(1, true));
    const first = decoder();
    first.fail('EncodingError');
    decoding.push(unit(2));
    expect(FakeDecoder.made).toHaveLength(1);
    decoding.push(unit(3, true));
    expect(FakeDecoder.made).toHaveLength(2);
    expect(first.show(40_000).closed).toBe(true);
    expect(shown).toHaveLength(0);
    expect(decoding.none).toBeNull();
  });

  it('says that there is no decoder, and tries no codec twice', () => {
    const { decoding, decoder } = started();
    FakeDecoder.unsupported = 'hvc1.1.6.L93.B0';
    decoding.push(unit(1, true, FakeDecoder.unsupported));
    expect(decoding.none).toBe('codec');
    decoding.push(unit(2, true, FakeDecoder.unsupported));
    expect(FakeDecoder.made).toHaveLength(1);
    decoding.push(unit(3, true));
    decoder().show(3 * 40_000);
    expect(decoding.none).toBeNull();
    expect(new Decoding(() => {}, undefined).none).toBe('browser');
  });

  it('keeps a bounded number of units', () => {
    const { decoding } = started();
    decoding.push(unit(0, true));
    for (let number = 1; number < 2000; number++) decoding.push(unit(number));
    expect((decoding as unknown as { inside: Map<number, unknown> }).inside.size).toBe(600);
  });
});
