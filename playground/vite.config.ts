import { defineConfig } from 'vitest/config';

export default defineConfig({
  // From any folder of any file server.
  base: './',
  build: {
    target: 'es2022',
    // The page's Content-Security-Policy allows no inline script.
    modulePreload: { polyfill: false },
    assetsInlineLimit: 0,
  },
  worker: { format: 'es' },
  test: {
    projects: [
      { test: { name: 'unit', include: ['test/unit/**/*.test.ts'], environment: 'node', testTimeout: 60_000 } },
      {
        // Chromium against dist, served as a plain file server does.
        test: {
          name: 'browser',
          include: ['test/browser/**/*.test.ts'],
          environment: 'node',
          fileParallelism: false,
          testTimeout: 120_000,
          hookTimeout: 120_000,
        },
      },
      { test: { name: 'measure', include: ['test/measure/**/*.test.ts'], environment: 'node', testTimeout: 300_000 } },
    ],
  },
});
