// SPDX-License-Identifier: BSD-3-Clause
// figures.mjs TERRACE [OUTPUTS.lcmlog SPEED SENSORS.lcmlog SPEED]: measures the page and `terrace view`, and prints the figures of
// README.md. Without logs only the page; with them, what a daemon published and what it saw are played side by side.
import { spawn } from 'node:child_process';
import { mkdtempSync, readFileSync, rmSync, statSync } from 'node:fs';
import { connect } from 'node:net';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { openBrowser, openPage, startView } from '../test/viewer/browser.mjs';
import { level, writeMap } from '../test/viewer/example_map.mjs';

const URL = 'udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152';
const TICKS_PER_S = 100;  // of /proc/PID/stat on Linux
const [terrace, outputs, outputSpeed, sensors, sensorSpeed] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'terrace_figures_'));

const cpuS = (pid) => readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ').slice(11, 13).reduce((sum, t) => sum + Number(t), 0) / TICKS_PER_S;
const rssMb = (pid) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

async function measurePage(browser) {
  const size = statSync(new globalThis.URL('../build/viewer/index.html', import.meta.url)).size;
  console.log(`page with everything: ${(size * 1e-6).toFixed(2)} MB`);
  const regions = [];
  for (let i = 0; i < 5000; ++i) {
    const [x, y] = [(i % 100) * 0.6, Math.floor(i / 100) * 0.6];
    const corners = [];
    for (let k = 0; k < 12; ++k) corners.push([x + 0.25 * (1 + Math.cos(k * Math.PI / 6)), y + 0.25 * (1 + Math.sin(k * Math.PI / 6)), 0.1 * (i % 5)]);
    const region = level(i + 1, i % 3 === 0 ? 'obstacle' : 'walkway', x, y, x + 0.5, y + 0.5, 0.1 * (i % 5));
    region.outline = corners;
    region.edges = [corners.map((_, k) => ({ kind: k % 4 === 0 ? 'drop' : 'limit', step_m: null, sigma_m: null }))];
    regions.push(region);
  }
  writeMap(join(folder, 'large.json'), regions);
  const view = await startView(terrace, ['--map', join(folder, 'large.json')]);
  const start = performance.now();
  const { page, foreign } = await openPage(browser.context, view.url);
  await page.waitForFunction(() => window.terrace.model.regions.size === 5000 && window.terrace.numFrames > 0);
  console.log(`5,000 regions of 12 corners: on the screen ${((performance.now() - start) / 1000).toFixed(2)} s after the page was asked for`);
  const { fps, drawn, there } = await page.evaluate(async () => {
    const app = window.terrace;
    const positions = new Float32Array(1 + 3 * 200000);
    positions[0] = 0.05;
    for (let i = 0; i < 200000; ++i) positions.set([(i % 1000) * 0.06, Math.floor(i / 1000) * 0.15, 0.6 + 0.4 * Math.sin(i)], 1 + 3 * i);
    app.model.apply({ kind: 'V', utime: 0, heardUtime: 0, content: new Uint8Array(positions.buffer) });
    app.view.update();
    const begin = performance.now();
    const before = app.numFrames;
    await new Promise((resolve) => {
      const turn = () => {
        const target = app.view.cameras.controls.target;
        app.view.cameras.active.position.x += 0.01;
        app.view.cameras.active.lookAt(target);
        app.view.invalidate();
        if (performance.now() - begin < 5000) requestAnimationFrame(turn);
        else resolve();
      };
      turn();
    });
    return { fps: (app.numFrames - before) / ((performance.now() - begin) / 1000), drawn: app.view.voxels.numDrawn, there: app.view.voxels.numThere };
  });
  console.log(`with ${drawn} of ${there} cells: ${fps.toFixed(1)} frames/s at 1280x800, software rendering`);
  console.log(`requests to elsewhere: ${foreign.length}`);
  await page.close();
  await view.stop();
}

/// Both logs side by side, as a robot and its daemon would speak.
async function play() {
  const players = [[outputs, outputSpeed], [sensors, sensorSpeed]].map(([log, speed]) => spawn('lcm-logplayer', ['-l', URL, `--speed=${speed}`, log], { stdio: 'ignore' }));
  await Promise.all(players.map((child) => new Promise((resolve) => { child.on('exit', resolve); })));
}

async function measureLive(browser, images) {
  const view = await startView(terrace, ['--url', URL]);
  const { page } = await openPage(browser.context, `${view.url}#switched=${images ? '' : 'image'}`);
  await page.waitForFunction(() => window.terrace.live.connected);
  await sleep(1000);
  const before = cpuS(view.pid);
  const begin = performance.now();
  await play();
  const elapsedS = (performance.now() - begin) / 1000;
  const share = (100 * (cpuS(view.pid) - before)) / elapsedS;
  await sleep(2000);  // until everything is on the screen
  const figures = await page.evaluate(() => ({ latency: window.terrace.latencyMs(), bytes: window.terrace.live.numBytes, regions: window.terrace.model.regions.size, path: window.terrace.model.path.length }));
  console.log(`images ${images ? 'on' : 'off'}: view process ${share.toFixed(1)} % of a core; bus to screen ${figures.latency?.toFixed(0)} ms median; ` +
    `${(figures.bytes * 1e-6).toFixed(2)} MB to the browser; ${figures.regions} regions, ${figures.path} poses`);
  await page.close();
  await view.stop();
}

/// A browser that opens the stream, asks for images and never reads.
async function measureSlow() {
  const view = await startView(terrace, ['--url', URL]);
  const { port } = new globalThis.URL(view.url);
  const socket = connect({ port: Number(port), host: '127.0.0.1', highWaterMark: 1 });
  socket.write(`GET /stream HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n`);
  await new Promise((resolve) => { socket.once('readable', resolve); });
  const wish = Buffer.from('{"images":true}');
  socket.write(Buffer.concat([Buffer.from([0x81, 0x80 | wish.length, 0, 0, 0, 0]), wish]));
  socket.pause();
  await sleep(500);
  const before = rssMb(view.pid);
  let most = before;
  const watch = setInterval(() => { most = Math.max(most, rssMb(view.pid)); }, 200);
  for (const begin = performance.now(); performance.now() - begin < 60000;) await play();
  clearInterval(watch);
  console.log(`a browser that stops reading for a minute: ${before.toFixed(1)} MB before, ${most.toFixed(1)} MB at most`);
  socket.destroy();
  await view.stop();
}

const browser = await openBrowser();
await measurePage(browser);
if (outputs) {
  console.log(`what the bus carried: ${(statSync(outputs).size * 1e-6).toFixed(2)} MB without the images`);
  await measureLive(browser, false);
  await measureLive(browser, true);
  await measureSlow();
}
await browser.close();
rmSync(folder, { recursive: true, force: true });
