// The console of a hub: the one built into the program; with CONSOLE_DIST=1, or if there is none, that
// in dist.
import { preview } from 'vite';

export interface Served {
  url: string;
  close(): Promise<void>;
}

export async function consoleOf(hub: string): Promise<Served> {
  const answer = await fetch(hub);
  const page = await answer.text();
  if (page.includes('lf-app') && !process.env.CONSOLE_DIST) return { url: hub, close: async () => {} };
  const headers = { 'content-security-policy': answer.headers.get('content-security-policy') ?? '' };
  const to = { target: hub, ws: true, changeOrigin: true, headers: { origin: hub } };
  const server = await preview({
    logLevel: 'silent',
    preview: { port: 0, host: '127.0.0.1', proxy: { '/api': to }, headers },
  });
  return { url: server.resolvedUrls!.local[0]!.replace(/\/$/, ''), close: () => server.close() };
}
