// SPDX-License-Identifier: BSD-3-Clause
// What the tests of the page share: a headless Chromium, and `terrace view` as its own process.
import { spawn } from 'node:child_process';
import { existsSync, mkdtempSync, rmSync } from 'node:fs';
import { createRequire } from 'node:module';
import { tmpdir } from 'node:os';
import { join } from 'node:path';

const FLAGS = ['--headless', '--no-sandbox', '--disable-quic', '--no-first-run', '--disable-background-networking', '--disable-component-update',
  '--disable-sync', '--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--ignore-gpu-blocklist'];
const CHROMIUM = ['/usr/bin/chromium', '/usr/bin/chromium-browser'].find((path) => existsSync(path));

/// Why the tests cannot run here; empty when they can.
export function whatIsMissing() {
  if (!CHROMIUM) return 'there is no chromium';
  try {
    playwright();
  } catch {
    return 'playwright-core is not installed: scripts/viewer does that';
  }
  return '';
}

function playwright() {
  return createRequire(new URL('../../viewer/package.json', import.meta.url))('playwright-core');
}

export async function openBrowser() {
  const folder = mkdtempSync(join(tmpdir(), 'terrace_chromium_'));
  const context = await playwright().chromium.launchPersistentContext(folder, {
    executablePath: CHROMIUM, args: FLAGS, viewport: { width: 1280, height: 800 }, colorScheme: 'light',
  });
  return {
    context,
    folder,
    close: async () => {
      await context.close();
      rmSync(folder, { recursive: true, force: true });
    },
  };
}

/// A page that notes every request that leaves for elsewhere, and every error.
export async function openPage(context, url) {
  const page = await context.newPage();
  const foreign = [];
  const errors = [];
  page.on('request', (request) => {
    if (!/^(http:\/\/127\.0\.0\.1:|file:|data:|blob:)/.test(request.url())) foreign.push(request.url());
  });
  page.on('pageerror', (error) => errors.push(error.message));
  page.on('console', (message) => { if (message.type() === 'error') errors.push(message.text()); });
  await page.goto(url);
  await page.waitForFunction(() => window.terrace !== undefined);
  return { page, foreign, errors };
}

/// Starts `terrace view`; gives its address when it listens. Port 0: any that is free.
export async function startView(program, options, port = '0') {
  const child = spawn(program, ['view', '--port', port, ...options], { stdio: ['ignore', 'pipe', 'pipe'] });
  let text = '';
  child.stdout.on('data', (data) => { text += data; });
  child.stderr.on('data', (data) => { text += data; });
  const ended = new Promise((resolve) => { child.on('exit', resolve); });
  for (let i = 0; i < 600 && child.exitCode === null; ++i) {
    const found = /view: (http:\S+)/.exec(text);
    if (found) return { url: found[1], pid: child.pid, stop: async () => { child.kill('SIGTERM'); return ended; } };
    await new Promise((resolve) => { setTimeout(resolve, 50); });
  }
  throw new Error(`terrace view did not start: ${text}`);
}
