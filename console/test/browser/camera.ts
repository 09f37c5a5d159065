// A camera: RTSP over TCP, one key frame again and again, ten times a second.
import { type AddressInfo, createServer, type Server, type Socket } from 'node:net';

/** Parameter sets and a key frame of 64 × 48 red pixels, by x264. */
const UNITS = [
  '6742c00adc47b011000003000100000300320f122780',
  '68ce0f2c80',
  '65888404bc4628000a8bc7000128d8e0002fad2727275d75d75d75d780',
].map((unit) => Buffer.from(unit, 'hex'));
const EACH_MS = 100;
const CLOCK_HZ = 90_000;

export class Camera {
  private readonly ends = new Set<Socket>();
  /** Those that have asked to play. */
  private readonly playing = new Set<Socket>();
  private server!: Server;
  private timer?: NodeJS.Timeout;
  private sequence = 0;
  private time = 0;
  /** It is connected and sends nothing. */
  stalled = false;
  url = '';

  static async start(): Promise<Camera> {
    const camera = new Camera();
    camera.server = createServer((end) => camera.join(end));
    await new Promise<void>((done) => camera.server.listen(0, '127.0.0.1', done));
    camera.url = `rtsp://127.0.0.1:${(camera.server.address() as AddressInfo).port}/live`;
    camera.timer = setInterval(() => camera.send(), EACH_MS);
    return camera;
  }

  close(): void {
    clearInterval(this.timer);
    for (const end of this.ends) end.destroy();
    this.server.close();
  }

  private join(end: Socket): void {
    this.ends.add(end);
    end.on('error', () => end.destroy());
    end.on('close', () => {
      this.ends.delete(end);
      this.playing.delete(end);
    });
    let asked = '';
    end.on('data', (bytes) => {
      asked += bytes.toString('latin1');
      for (let at = asked.indexOf('\r\n\r\n'); at >= 0; at = asked.indexOf('\r\n\r\n')) {
        this.answer(end, asked.slice(0, at));
        asked = asked.slice(at + 4);
      }
    });
  }

  private answer(end: Socket, request: string): void {
    const [method] = request.split(' ');
    const lines = ['RTSP/1.0 200 OK', `CSeq: ${/^CSeq: *(\d+)/im.exec(request)?.[1]}`, 'Session: 1;timeout=60'];
    let body = '';
    if (method === 'DESCRIBE') {
      const sets = [UNITS[0]!, UNITS[1]!].map((unit) => unit.toString('base64')).join(',');
      body =
        'v=0\r\no=- 1 1 IN IP4 127.0.0.1\r\ns=camera\r\nt=0 0\r\nm=video 0 RTP/AVP 96\r\na=rtpmap:96 H264/90000\r\n' +
        `a=fmtp:96 packetization-mode=1;sprop-parameter-sets=${sets}\r\na=control:1\r\n`;
      lines.push('Content-Type: application/sdp', `Content-Base: ${this.url}/`);
    }
    if (method === 'SETUP') lines.push('Transport: RTP/AVP/TCP;unicast;interleaved=0-1');
    lines.push(`Content-Length: ${body.length}`);
    end.write(`${lines.join('\r\n')}\r\n\r\n${body}`);
    if (method === 'PLAY') this.playing.add(end);
  }

  /** A packet of RTP for each unit. */
  private send(): void {
    if (this.stalled) return;
    this.time += (CLOCK_HZ * EACH_MS) / 1000;
    UNITS.forEach((unit, n) => {
      const last = n === UNITS.length - 1;
      const head = Buffer.alloc(16);
      head.write('$', 0, 'latin1');
      head.writeUInt16BE(12 + unit.length, 2);
      head.writeUInt8(0x80, 4);
      head.writeUInt8(last ? 96 | 0x80 : 96, 5);
      head.writeUInt16BE(this.sequence & 0xffff, 6);
      head.writeUInt32BE(this.time, 8);
      head.writeUInt32BE(1, 12);
      this.sequence += 1;
      for (const end of this.playing) end.write(Buffer.concat([head, unit]));
    });
  }
}
