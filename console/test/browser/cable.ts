// A cable that can be cut and frozen: forwards TCP to another port.

import type { AddressInfo } from 'node:net';
import { connect, createServer, type Server, type Socket } from 'node:net';

export class Cable {
  private readonly ends = new Set<Socket>();
  private server!: Server;
  private cutNow = false;
  private frozen = false;
  port = 0;

  static async to(port: number): Promise<Cable> {
    const cable = new Cable();
    cable.server = createServer((near) => cable.join(near, port));
    await new Promise<void>((done) => cable.server.listen(0, '127.0.0.1', done));
    cable.port = (cable.server.address() as AddressInfo).port;
    return cable;
  }

  /** Nothing passes, without an error: as when a cable is pulled. */
  freeze(): void {
    this.frozen = true;
    for (const end of this.ends) end.pause();
  }

  /** Every connection breaks, and no new one is accepted. */
  cut(): void {
    this.cutNow = true;
    for (const end of this.ends) end.destroy();
  }

  mend(): void {
    this.cutNow = false;
    this.frozen = false;
    for (const end of this.ends) end.resume();
  }

  close(): void {
    this.cut();
    this.server.close();
  }

  private join(near: Socket, port: number): void {
    if (this.cutNow) {
      near.destroy();
      return;
    }
    const far = connect(port, '127.0.0.1');
    for (const [from, to] of [
      [near, far],
      [far, near],
    ] as const) {
      this.ends.add(from);
      from.setNoDelay(true);
      from.pipe(to);
      if (this.frozen) from.pause();
      from.on('error', () => to.destroy());
      from.on('close', () => {
        this.ends.delete(from);
        to.destroy();
      });
    }
  }
}
