import { defineConfig } from 'vitest/config';

// Where `npm run dev` finds a hub: lafet demo --no-browser --port 8480
const hub = process.env.LAFET_HUB ?? 'http://127.0.0.1:8480';

export default defineConfig({
  build: {
    target: 'es2022',
    // The hub's Content-Security-Policy allows no inline script.
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
    chunkSizeWarningLimit: 800,
  },
  server: { proxy: proxy() },
  preview: { proxy: proxy() },
  test: {
    include: ['test/unit/**/*.test.ts'],
    environment: 'node',
  },
});

function proxy() {
  const to = { target: hub, ws: true, changeOrigin: true, headers: { origin: hub } };
  return { '/api': to, '/health': to };
}
