// SPDX-License-Identifier: BSD-3-Clause
// Results, logs and reports: what the time line plays, against what the replay wrote.
import assert from 'node:assert/strict';
import { execFileSync } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, statSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { openBrowser, openPage, startView } from './browser.mjs';

const NUM_FRAMES = 12;
const MAX_PAGE_BYTES = 1.5e6;
const [terrace, terraced, tinyLog] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'terrace_recording_'));
const sequence = join(folder, 'tiny.lcmlog');
const result = join(folder, 'result');
let browser;
let map;

before(async () => {
  execFileSync(tinyLog, [sequence, String(NUM_FRAMES)]);
  execFileSync(terraced, ['replay', sequence, '--output', result], { stdio: 'ignore' });
  map = JSON.parse(readFileSync(join(result, 'terrain_map.json'), 'utf8'));
  browser = await openBrowser();
});

after(async () => {
  await browser.close();
  rmSync(folder, { recursive: true, force: true });
});

const stateOf = (page) => page.evaluate(() => ({
  regions: [...window.terrace.model.regions.values()].map((r) => [r.id, r.message.revision]).sort((a, b) => a[0] - b[0]),
  path: window.terrace.model.path.length,
  last: window.terrace.model.cameraPose().position.toArray(),
}));

function lastOfTrajectory() {
  const lines = readFileSync(join(result, 'trajectory.tum'), 'utf8').trim().split('\n');
  return lines.at(-1).split(' ').slice(1, 4).map(Number);
}

async function checkEnd(page) {
  const state = await stateOf(page);
  assert.deepEqual(state.regions, map.regions.map((r) => [r.id, r.revision]));
  assert.equal(state.path, NUM_FRAMES);
  lastOfTrajectory().forEach((value, axis) => assert.ok(Math.abs(state.last[axis] - value) < 1e-6, 'the camera stands where the trajectory ends'));
}

test('shows a result as the replay left it, and any moment before', async () => {
  const view = await startView(terrace, ['--result', result]);
  const { page, foreign, errors } = await openPage(browser.context, view.url);
  await page.waitForFunction(() => window.terrace.player !== null);
  await checkEnd(page);
  const halfway = await page.evaluate(() => {
    const { player } = window.terrace;
    player.seek(0.5 * (player.startUtime + player.endUtime));
    return window.terrace.model.path.map((p) => p.utime).every((utime) => utime <= player.utime) && window.terrace.model.path.length;
  });
  assert.ok(halfway > 1 && halfway < NUM_FRAMES);
  await page.selectOption('#timeline select', '10');
  await page.click('[data-name=play]');
  await page.waitForFunction(() => !window.terrace.player.playing);
  await checkEnd(page);
  assert.deepEqual([foreign, errors], [[], []]);
  await page.close();
  assert.equal(await view.stop(), 0);
});

test('is one small file, and a report needs no server', async () => {
  const out = join(folder, 'report.html');
  execFileSync(terrace, ['report', result, sequence, out, '--images', '3'], { stdio: 'ignore' });
  const { page, foreign, errors } = await openPage(browser.context, `file://${out}`);
  await page.waitForFunction(() => window.terrace.player !== null);
  await checkEnd(page);
  assert.equal(await page.locator('#figures img').count(), 3);
  await page.waitForFunction(() => window.terrace.view.inset.texture !== null);
  assert.deepEqual([foreign, errors], [[], []]);
  await page.close();
  const html = new URL('../../build/viewer/index.html', import.meta.url);
  assert.ok(statSync(html).size <= MAX_PAGE_BYTES);
});

test('shows the truth over the result in the page of an evaluation', async () => {
  const world = join(folder, 'world');
  const walked = join(folder, 'walked');
  execFileSync(terrace, ['synthesize', 'flat', world, '--frames', '10', '--samples', '1', '--seed', '3'], { stdio: 'ignore' });
  execFileSync(terraced, ['replay', world, '--output', walked], { stdio: 'ignore' });
  execFileSync(terrace, ['evaluate', walked, world], { stdio: 'ignore' });
  assert.match(readFileSync(join(walked, 'report.html'), 'utf8'), /href="view.html"/);
  const { page, foreign, errors } = await openPage(browser.context, `file://${join(walked, 'view.html')}`);
  await page.waitForFunction(() => window.terrace.player !== null && window.terrace.model.truth.length > 0);
  const { truth, last, camera, figures } = await page.evaluate(() => ({
    truth: window.terrace.model.truth.map((r) => [r.label, r.origin.z]), last: [...window.terrace.model.trueWay.slice(-3)],
    camera: window.terrace.model.cameraPose().position.toArray(), figures: document.getElementById('state').textContent,
  }));
  const WALKWAY = 1;
  const feet = JSON.parse(readFileSync(join(walked, 'terrain_map.json'), 'utf8')).regions.filter((r) => r.label === 'walkway');
  const floorM = feet.sort((a, b) => b.area_m2 - a.area_m2)[0].outline[0][2];
  assert.ok(truth.some(([label, z]) => label === WALKWAY && Math.abs(z - floorM) < 0.02), 'the true floor lies where the found one is');
  assert.ok(Math.hypot(...last.map((v, i) => v - camera[i])) < 0.02, 'the true way ends where the camera is');
  assert.match(figures, /way from the truth.*true surfaces found/);
  assert.deepEqual([foreign, errors], [[], []]);
  await page.close();
});

test('says what a log without a map lacks', () => {
  assert.throws(() => execFileSync(terrace, ['view', '--log', sequence], { stdio: 'pipe' }), (error) => (
    error.status === 1 && /holds no map/.test(String(error.stderr))));
});
