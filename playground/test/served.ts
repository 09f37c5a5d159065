// A plain file server below a sub-path, which knows few types: the module of the simulator comes as octets.
import { readFile } from 'node:fs/promises';
import { createServer, type Server } from 'node:http';
import { extname, join, normalize } from 'node:path';
import { fileURLToPath } from 'node:url';

const DIST = fileURLToPath(new URL('../dist', import.meta.url));
const TYPES: Record<string, string> = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript',
  '.css': 'text/css',
  '.svg': 'image/svg+xml',
};
export const SUB_PATH = '/some/where/playground/';

export interface Served {
  url: string;
  /** What has been asked for outside the sub-path. */
  outside: string[];
  end(): Promise<void>;
}

/** Serves dist; `replaced` gives other contents for paths that end like this. */
export async function served(replaced: Record<string, Uint8Array> = {}): Promise<Served> {
  const outside: string[] = [];
  const server: Server = createServer(async (request, response) => {
    const path = new URL(request.url ?? '/', 'http://any').pathname;
    if (!path.startsWith(SUB_PATH)) {
      outside.push(path);
      response.writeHead(404).end();
      return;
    }
    const file = normalize(path.slice(SUB_PATH.length)) || 'index.html';
    try {
      const other = Object.entries(replaced).find(([end]) => file.endsWith(end));
      const body = other ? other[1] : await readFile(join(DIST, file === '.' ? 'index.html' : file));
      response.writeHead(200, { 'content-type': TYPES[extname(file) || '.html'] ?? 'application/octet-stream' });
      response.end(body);
    } catch {
      response.writeHead(404).end();
    }
  });
  await new Promise<void>((done) => server.listen(0, '127.0.0.1', done));
  const { port } = server.address() as { port: number };
  return {
    url: `http://127.0.0.1:${port}${SUB_PATH}`,
    outside,
    end: () =>
      new Promise((done) => {
        server.closeAllConnections();
        server.close(() => done());
      }),
  };
}
