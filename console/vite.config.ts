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
    // What every page needs comes in two files, not in twenty.
    rolldownOptions: {
      output: {
        codeSplitting: {
          groups: [
            { name: 'lit', test: /node_modules[\\/](@?lit)/ },
            {
              name: 'shell',
              test: /src[\\/]((shell(?![\\/]guide\.ts)|hub|theme)[\\/]|i18n[\\/]index|units|parts[\\/](icons|why|words|part-style|lf-button|lf-hold|steady|held-keys|moved|lf-chip|lf-value|lf-timeline)\.)/,
            },
          ],
        },
      },
    },
  },
  server: { proxy: proxy() },
  preview: { proxy: proxy() },
  test: {
    projects: [
      { test: { name: 'unit', include: ['test/unit/**/*.test.ts'], environment: 'node', testTimeout: 30_000 } },
      {
        // Chromium against the real program (LAFET_BIN). They mostly wait: two files at a time.
        test: {
          name: 'browser',
          include: ['test/browser/**/*.test.ts'],
          environment: 'node',
          maxWorkers: 2,
          // A busy machine is slow; what is asserted is what a monitor says, and in which order.
          testTimeout: 180_000,
          hookTimeout: 180_000,
        },
      },
    ],
  },
});

function proxy() {
  const to = { target: hub, ws: true, changeOrigin: true, headers: { origin: hub } };
  return { '/api': to, '/health': to, '/metrics': to };
}
