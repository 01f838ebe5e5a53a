// SPDX-License-Identifier: BSD-3-Clause
// A page beside a running daemon: what it shows is what the daemon saves; connections drop and come back; who only looks
// commands nothing.
import assert from 'node:assert/strict';
import { execFileSync, spawn } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync } from 'node:fs';
import { connect } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { setTimeout as sleep } from 'node:timers/promises';
import { openBrowser, openPage, startView } from './browser.mjs';

const NUM_FRAMES = 12;
const URL = 'udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152';
const [terrace, terraced, tinyLog] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'terrace_live_'));
const output = join(folder, 'output');
let browser;
let daemon;
let view;

before(async () => {
  execFileSync(tinyLog, [join(folder, 'tiny.lcmlog'), String(NUM_FRAMES)]);
  browser = await openBrowser();
  view = await startView(terrace, ['--url', URL, '--control']);
  daemon = spawn(terraced, ['--output', output, '--set', `lcm.url=${URL}`], { stdio: ['ignore', 'ignore', 'pipe'] });
  let text = '';
  daemon.stderr.on('data', (data) => { text += data; });
  while (!text.includes('live on')) {
    assert.equal(daemon.exitCode, null, text);
    await sleep(50);
  }
});

after(async () => {
  await browser.close();
  await view.stop();
  const ended = new Promise((resolve) => { daemon.on('exit', resolve); });
  daemon.kill('SIGTERM');
  await ended;
  rmSync(folder, { recursive: true, force: true });
});

const regionsOf = (page) => page.evaluate(() => (
  [...window.terrace.model.regions.values()].map((r) => [r.id, r.message.revision, r.label]).sort((a, b) => a[0] - b[0])));

const until = (page, what) => page.waitForFunction(what, null, { timeout: 60000 });

test('shows the map that the daemon saves, the way and the state in words', async () => {
  const { page, foreign, errors } = await openPage(browser.context, `${view.url}#switched=disparity,points`);
  await until(page, () => window.terrace.live.connected);
  await sleep(300);  // until the daemon has heard what is asked for
  execFileSync('lcm-logplayer', ['-l', URL, '--speed=0.5', join(folder, 'tiny.lcmlog')], { stdio: 'ignore' });
  await until(page, () => window.terrace.model.regions.size > 0 && window.terrace.model.statuses.length > 1);
  await sleep(1000);  // the last frames' map
  await page.click('[data-name=save]');
  await until(page, () => window.terrace.model.replies.length > 0);
  const saved = readdirSync(output).find((name) => name.startsWith('map_'));
  const map = JSON.parse(readFileSync(join(output, saved), 'utf8'));
  const shown = await regionsOf(page);
  assert.deepEqual(shown.map(([id, revision]) => [id, revision]), map.regions.map((r) => [r.id, r.revision]));
  assert.ok(await page.evaluate(() => window.terrace.model.path.length) > 1);
  assert.match(await page.textContent('#state'), /The daemon is .*frames/s);
  assert.match(await page.textContent('#state'), /disparity \d/);
  assert.match(await page.textContent('#state'), /calibrationrectified \d+×\d+, f \d+\.\d px/);
  // What the daemon sends on request only.
  await until(page, () => window.terrace.model.cells !== null && window.terrace.model.points !== null && window.terrace.model.disparity !== null);
  await until(page, () => window.terrace.view.inset.texture !== null);
  await page.waitForFunction(() => /disparity, \d/.test(document.getElementById('inset-caption').textContent));
  const { corners, drawn } = await page.evaluate(() => {
    const { camera } = window.terrace.view.path;
    return { corners: camera.geometry.getAttribute('position').count, drawn: camera.visible };
  });
  assert.deepEqual([corners, drawn], [20, true], 'the camera is drawn, though the page was there before its first pose');
  assert.ok(await page.evaluate(() => window.terrace.latencies().imageToPoseMs) > 0);
  assert.deepEqual([foreign, errors], [[], []]);
  await page.close();
});

test('comes back with the same map when the connection was dropped', async () => {
  const { page } = await openPage(browser.context, view.url);
  await until(page, () => window.terrace.model.regions.size > 0);
  const before = await regionsOf(page);
  const { port } = new globalThis.URL(view.url);
  await view.stop();
  await until(page, () => window.terrace.live.connected === false);
  assert.deepEqual(await regionsOf(page), before, 'what was known stays on the screen');
  await page.waitForFunction(() => document.getElementById('state').textContent.includes('No connection'));
  view = await startView(terrace, ['--url', URL], port);
  await until(page, () => window.terrace.live.connected && window.terrace.model.hello.control === false);
  await until(page, () => window.terrace.model.inStep);
  assert.deepEqual(await regionsOf(page), before);
  await page.close();
});

test('passes no commands on unless it was started with --control', async () => {
  const { page } = await openPage(browser.context, view.url);
  await until(page, () => window.terrace.live.connected && window.terrace.model.regions.size > 0);
  const before = await regionsOf(page);
  assert.equal(await page.isHidden('[data-name=reset]'), true);
  await page.evaluate(() => window.terrace.command('reset'));
  await until(page, () => window.terrace.model.replies.some((r) => r.result === 1 && r.message.includes('--control')));
  await sleep(300);
  assert.deepEqual(await regionsOf(page), before);
  await page.close();
});

test('serves nobody under a foreign name or from a foreign page', async () => {
  const { port } = new globalThis.URL(view.url);
  const answer = (headers) => new Promise((resolve, reject) => {
    const socket = connect(Number(port), '127.0.0.1', () => socket.write(`GET / HTTP/1.1\r\n${headers}Connection: close\r\n\r\n`));
    let text = '';
    socket.on('data', (data) => { text += data; });
    socket.on('end', () => resolve(text.split('\r\n')[0]));
    socket.on('error', reject);
  });
  assert.match(await answer(`Host: 127.0.0.1:${port}\r\n`), / 200 /);
  assert.match(await answer(`Host: robot.example:${port}\r\n`), / 403 /);
  assert.match(await answer(`Host: 127.0.0.1:${port}\r\nOrigin: http://robot.example\r\n`), / 403 /);
});
