// A file server as plain as any: a folder, a prefix, no clean addresses, no index of folders but index.html.
import { createReadStream, existsSync, statSync } from 'node:fs';
import { createServer } from 'node:http';
import path from 'node:path';
import { fileURLToPath } from 'node:url';

export const DIST = fileURLToPath(new URL('../dist', import.meta.url));
const TYPES = {
  '.html': 'text/html; charset=utf-8',
  '.js': 'text/javascript; charset=utf-8',
  '.css': 'text/css; charset=utf-8',
  '.json': 'application/json',
  '.svg': 'image/svg+xml',
  '.png': 'image/png',
  '.wasm': 'application/wasm',
};

/** Serves `folder` below `prefix` on the loopback; resolves with its address and a function that ends it. */
export async function serve(folder = DIST, prefix = '/', port = 0) {
  const server = createServer((request, response) => {
    const file = fileOf(folder, prefix, request.url);
    if (!file) {
      response.writeHead(404, { 'content-type': TYPES['.html'] });
      const missing = path.join(folder, '404.html');
      if (existsSync(missing)) createReadStream(missing).pipe(response);
      else response.end('404');
      return;
    }
    response.writeHead(200, { 'content-type': TYPES[path.extname(file)] ?? 'application/octet-stream' });
    createReadStream(file).pipe(response);
  });
  await new Promise((ready) => server.listen(port, '127.0.0.1', ready));
  const stop = () => {
    server.closeAllConnections();
    return new Promise((ended) => server.close(ended));
  };
  return { url: `http://127.0.0.1:${server.address().port}${prefix}`, stop };
}

function fileOf(folder, prefix, url) {
  let name;
  try {
    name = decodeURIComponent(new URL(url, 'http://localhost').pathname);
  } catch {
    return null;
  }
  if (!name.startsWith(prefix)) return null;
  const inside = path.normalize(name.slice(prefix.length));
  if (inside.startsWith('..')) return null;
  const file = path.join(folder, inside, name.endsWith('/') ? 'index.html' : '');
  return existsSync(file) && statSync(file).isFile() ? file : null;
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { url } = await serve(DIST, '/', Number(process.env.PORT ?? 8490));
  console.log(url);
}
