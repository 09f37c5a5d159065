// A separate connection of the tests to a monitor: its outputs as it reports them, without hub and
// page. Frames as in docs/bus.md: FF C0 | dst src records crc | C0, escaped by DB.
import { connect, type Socket } from 'node:net';

export interface Output {
  flags: string[];
  /** Of drives: arc-minutes, of the nozzle mm. */
  position?: number;
}

export interface Names {
  subsystems: { name: string; id: number; flags: string | null }[];
  flags: Record<string, { name: string; bit: number; shift: number; width: number }[]>;
  requests: { name: string; id: number }[];
  button_states: { name: string; value: number }[];
}

const [END, ESCAPE, ESCAPED_END, ESCAPED_ESCAPE, SYNC] = [0xc0, 0xdb, 0xdc, 0xdd, 0xff];
const OWN_ADDRESS = 200;
const ALL = 0x5d;
const ANSWER_MS = 5000;
const DRIVES = new Set(['Vertical', 'Horizontal', 'Nozzle', 'Deployer']);

export class Wire {
  private socket: Socket | null = null;
  private readonly bytes: number[] = [];
  private escaped = false;
  private heard: (records: number[]) => void = () => {};
  private last: Promise<unknown> = Promise.resolve();

  constructor(
    private readonly port: number,
    private readonly address: number,
    private readonly names: Names,
  ) {}

  /** The state of every subsystem, by GetStatus All. One request after another. */
  outputs(): Promise<Record<string, Output>> {
    const next = this.last.then(() => this.ask());
    this.last = next.catch(() => {});
    return next;
  }

  close(): void {
    this.socket?.destroy();
  }

  private async ask(): Promise<Record<string, Output>> {
    const status = this.names.requests.find(({ name }) => name === 'GetStatus')!.id;
    for (let tries = 0; tries < 3; tries += 1) {
      const answer = new Promise<number[] | null>((resolve) => {
        const timer = setTimeout(() => resolve(null), ANSWER_MS);
        this.heard = (records) => {
          clearTimeout(timer);
          resolve(records);
        };
      });
      this.link().write(Buffer.from(framed([this.address, OWN_ADDRESS, status, ALL, 0, 0])));
      const records = await answer;
      if (records) return this.decoded(records);
    }
    throw new Error(`monitor ${this.address} does not answer`);
  }

  private link(): Socket {
    if (this.socket && !this.socket.destroyed) return this.socket;
    const socket = connect(this.port, '127.0.0.1');
    socket.setNoDelay(true);
    socket.on('data', (data) => data.forEach((byte) => this.take(byte)));
    socket.on('error', () => socket.destroy());
    return (this.socket = socket);
  }

  private take(byte: number): void {
    if (byte === END) {
      const frame = this.bytes.splice(0);
      if (frame.length >= 4 && crc(frame.slice(0, -2)) === frame.at(-2)! + frame.at(-1)! * 256) {
        if (frame[0] === OWN_ADDRESS) this.heard(frame.slice(2, -2));
      }
    } else if (this.escaped) {
      this.bytes.push(byte === ESCAPED_END ? END : ESCAPE);
      this.escaped = false;
    } else if (byte === ESCAPE) this.escaped = true;
    else this.bytes.push(byte);
  }

  private decoded(records: number[]): Record<string, Output> {
    const outputs: Record<string, Output> = {};
    for (let at = 0; at + 4 <= records.length; at += 4 + records[at + 3]!) {
      const sub = this.names.subsystems.find(({ id }) => id === records[at + 1]);
      const data = Buffer.from(records.slice(at + 4, at + 4 + records[at + 3]!));
      if (!sub || records[at + 2] !== 0 || data.length < 4) continue;
      const output: Output = { flags: this.flagsOf(sub.flags, data.readUInt32LE(0)) };
      if (DRIVES.has(sub.name)) output.position = data.readInt16LE(4);
      outputs[sub.name] = output;
    }
    return outputs;
  }

  private flagsOf(table: string | null, bits: number): string[] {
    return (this.names.flags[table ?? ''] ?? []).flatMap(({ name, shift, width }) => {
      const value = (bits >>> shift) & (2 ** width - 1);
      if (value === 0) return [];
      return [
        width === 1 ? name : `${name}=${this.names.button_states.find((it) => it.value === value)?.name ?? value}`,
      ];
    });
  }
}

function framed(plain: number[]): number[] {
  const sum = crc(plain);
  const inside = [...plain, sum & 0xff, sum >> 8].flatMap((byte) =>
    byte === END ? [ESCAPE, ESCAPED_END] : byte === ESCAPE ? [ESCAPE, ESCAPED_ESCAPE] : [byte],
  );
  return [SYNC, END, ...inside, END];
}

function crc(bytes: readonly number[]): number {
  let sum = 0xffff;
  for (const byte of bytes) {
    sum ^= byte;
    for (let bit = 0; bit < 8; bit += 1) sum = sum & 1 ? (sum >> 1) ^ 0xa001 : sum >> 1;
  }
  return sum;
}
