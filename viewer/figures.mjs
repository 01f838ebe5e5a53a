// SPDX-License-Identifier: BSD-3-Clause
// figures.mjs TERRACE [TERRACED SENSORS.lcmlog SPEED]: measures the page and `terrace view`, and prints the figures of README.md. Without
// the rest only the page; with it, beside a daemon that maps what a robot saw.
import { spawn } from 'node:child_process';
import { mkdtempSync, readdirSync, readFileSync, rmSync, statSync } from 'node:fs';
import { connect } from 'node:net';
import { loadavg, tmpdir } from 'node:os';
import { join } from 'node:path';
import { setTimeout as sleep } from 'node:timers/promises';
import { openBrowser, openPage, startView } from '../test/viewer/browser.mjs';
import { level, writeMap } from '../test/viewer/example_map.mjs';

const URL = 'udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152';
const TICKS_PER_S = 100;  // of /proc/PID/stat on Linux
const [terrace, terraced, sensors, speed] = process.argv.slice(2);
const INPUTS = 'TERRACE_(IMAGES|CALIBRATION|IMU|BODY_PRIOR|TRUE_POSE)';
const folder = mkdtempSync(join(tmpdir(), 'terrace_figures_'));

const cpuS = (pid) => readFileSync(`/proc/${pid}/stat`, 'utf8').split(') ')[1].split(' ').slice(11, 13).reduce((sum, t) => sum + Number(t), 0) / TICKS_PER_S;
const rssMb = (pid) => Number(/VmRSS:\s+(\d+)/.exec(readFileSync(`/proc/${pid}/status`, 'utf8'))[1]) / 1024;

/// Of the browser's process and all that descend from it.
function cpuOfBrowserS(browser) {
  const parents = new Map();
  let root = 0;
  for (const name of readdirSync('/proc').filter((entry) => /^\d+$/.test(entry))) {
    try {
      const parent = Number(readFileSync(`/proc/${name}/stat`, 'utf8').split(') ')[1].split(' ')[1]);
      parents.set(Number(name), parent);
      const isBrowser = readFileSync(`/proc/${name}/cmdline`, 'utf8').includes(browser.folder);
      if (isBrowser && (root === 0 || parents.get(root) === Number(name))) root = Number(name);
    } catch {
      // It has ended meanwhile.
    }
  }
  const isOfBrowser = (pid) => pid === root || (parents.has(pid) && isOfBrowser(parents.get(pid)));
  return [...parents.keys()].filter(isOfBrowser).reduce((sum, pid) => sum + cpuS(pid), 0);
}

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
  const cpuBeforeS = cpuOfBrowserS(browser);
  const { fps, frames, drawn, there } = await page.evaluate(async () => {
    const app = window.terrace;
    const cells = new ArrayBuffer(16 + 8 * 200000);  // as tools/view_surroundings.h writes them
    new Float32Array(cells, 0, 4).set([0.05, 0, 0, 0]);
    const corners = new Uint16Array(cells, 16);
    for (let i = 0; i < 200000; ++i) corners.set([(i % 1000) * 1.2, Math.floor(i / 1000) * 3, 12 + 8 * Math.sin(i), 1], 4 * i);
    app.model.apply({ kind: 'V', utime: 0, heardUtime: 0, content: new Uint8Array(cells) });
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
    const frames = app.numFrames - before;
    return { frames, fps: frames / ((performance.now() - begin) / 1000), drawn: app.view.voxels.numDrawn, there: app.view.voxels.numThere };
  });
  console.log(`with ${drawn} of ${there} cells: ${fps.toFixed(1)} frames/s at 1280x800, software rendering; ` +
    `${((1000 * (cpuOfBrowserS(browser) - cpuBeforeS)) / frames).toFixed(0)} ms of processor a frame; load ${loadavg()[0].toFixed(0)}`);
  console.log(`requests to elsewhere: ${foreign.length}`);
  await page.close();
  await view.stop();
}

const ended = (child) => new Promise((resolve) => { child.on('exit', resolve); });

const play = () => ended(spawn('lcm-logplayer', ['-l', URL, `--speed=${speed}`, sensors], { stdio: 'ignore' }));

async function startDaemon() {
  const daemon = spawn(terraced, ['--set', `lcm.url=${URL}`], { stdio: ['ignore', 'ignore', 'pipe'] });
  let text = '';
  daemon.stderr.on('data', (data) => { text += data; });
  while (!text.includes('live on')) await sleep(50);
  return async () => {
    const gone = ended(daemon);
    daemon.kill('SIGTERM');
    await gone;
  };
}

/// What the bus carries meanwhile: all of it, or what a daemon says.
function record(inputs) {
  const file = join(folder, `bus_${inputs}.lcmlog`);
  const logger = spawn('lcm-logger', ['-q', '-f', `--lcm-url=${URL}`, ...(inputs ? [] : ['-v', '-c', INPUTS]), file], { stdio: 'ignore' });
  const gone = ended(logger);
  return async () => {
    logger.kill('SIGTERM');
    await gone;
    return statSync(file).size;
  };
}

/// @param switched  layers that are shown or hidden otherwise than at first
async function measureLive(browser, name, switched) {
  const view = await startView(terrace, ['--url', URL]);
  const stopDaemon = await startDaemon();
  const { page } = await openPage(browser.context, `${view.url}#switched=${switched}`);
  await page.waitForFunction(() => window.terrace.live.connected);
  const stopRecord = record(!switched.includes('image'));
  await sleep(1000);
  const before = cpuS(view.pid);
  const begin = performance.now();
  await play();
  const share = (100 * (cpuS(view.pid) - before)) / ((performance.now() - begin) / 1000);
  const bus = await stopRecord();
  const { latencies, bytes, regions, poses } = await page.evaluate(() => ({
    latencies: window.terrace.latencies(), bytes: window.terrace.live.numBytes, regions: window.terrace.model.regions.size, poses: window.terrace.model.path.length,
  }));
  const ms = (value) => (value === null ? '-' : `${value.toFixed(0)} ms`);
  console.log(`${name}: view process ${share.toFixed(1)} % of a core; image to screen: ${ms(latencies.imageToPoseMs)} its pose, ` +
    `${ms(latencies.imageToMapMs)} its map (medians); ${(bytes * 1e-6).toFixed(2)} MB to the browser, ${(bytes / bus).toFixed(2)} times ` +
    `the ${(bus * 1e-6).toFixed(2)} MB of the bus${switched.includes('image') ? ' without inputs' : ''}; ${regions} regions, ${poses} poses`);
  await page.close();
  await stopDaemon();
  await view.stop();
}

/// A browser that opens the stream, asks for everything and never reads.
async function measureSlow() {
  const view = await startView(terrace, ['--url', URL]);
  const stopDaemon = await startDaemon();
  const { port } = new globalThis.URL(view.url);
  const socket = connect({ port: Number(port), host: '127.0.0.1', highWaterMark: 1 });
  socket.write(`GET /stream HTTP/1.1\r\nHost: 127.0.0.1:${port}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n`);
  await new Promise((resolve) => { socket.once('readable', resolve); });
  const wish = Buffer.from('{"wants":["image","disparity","cells","points"]}');
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
  await stopDaemon();
  await view.stop();
}

const browser = await openBrowser();
await measurePage(browser);
if (terraced) {
  await measureLive(browser, 'map alone', 'image,voxels');
  await measureLive(browser, 'with the image', 'voxels');
  await measureLive(browser, 'with image, disparity, cells and points', 'disparity,points');
  await measureSlow();
}
await browser.close();
rmSync(folder, { recursive: true, force: true });
