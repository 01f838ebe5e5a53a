// SPDX-License-Identifier: BSD-3-Clause
import { defineConfig } from 'vite';
import { viteSingleFile } from 'vite-plugin-singlefile';

// One HTML file with everything inside: it is served, installed and mailed as it is.
export default defineConfig({
  plugins: [viteSingleFile()],
  build: { outDir: '../build/viewer', emptyOutDir: true, target: 'es2022', reportCompressedSize: false },
  server: { fs: { allow: ['..'] } },
});
