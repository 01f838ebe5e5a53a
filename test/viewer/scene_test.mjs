// SPDX-License-Identifier: BSD-3-Clause
// What is in the scene, against maps of known geometry.
import assert from 'node:assert/strict';
import { mkdtempSync, rmSync } from 'node:fs';
import { tmpdir } from 'node:os';
import { join } from 'node:path';
import { after, before, test } from 'node:test';
import { openBrowser, openPage, startView } from './browser.mjs';
import { exampleRegions, EXAMPLE_STAIRCASE, level, writeMap } from './example_map.mjs';

const [program] = process.argv.slice(2);
const folder = mkdtempSync(join(tmpdir(), 'terrace_scene_'));
let browser;
let view;

before(async () => {
  writeMap(join(folder, 'map.json'), exampleRegions(), [EXAMPLE_STAIRCASE]);
  browser = await openBrowser();
  view = await startView(program, ['--map', join(folder, 'map.json')]);
});

after(async () => {
  await browser.close();
  await view.stop();
  rmSync(folder, { recursive: true, force: true });
});

async function withPage(hash, use, url = view.url) {
  const { page, foreign, errors } = await openPage(browser.context, url + hash);
  await page.waitForFunction(() => window.terrace.model.regions.size > 0);
  await page.evaluate(() => window.terrace.view.draw());
  await use(page);
  assert.deepEqual(foreign, [], 'no request goes elsewhere');
  assert.deepEqual(errors, [], 'nothing goes wrong');
  await page.close();
}

/// Where a point of the world is on the page.
const placeOf = (page, point) => page.evaluate(([x, y, z]) => {
  const v = window.terrace.view.cameras.controls.target.clone().set(x, y, z);
  return window.terrace.view.project(v);
}, point);

async function pickAt(page, point) {
  const { x, y } = await placeOf(page, point);
  return page.evaluate(([px, py]) => {
    const hit = window.terrace.view.pick(px, py);
    return hit && { id: hit.region.id, point: hit.point.toArray() };
  }, [x, y]);
}

test('holds every region once, with its label and its place', () => withPage('', async (page) => {
  const regions = await page.evaluate(() => [...window.terrace.model.regions.values()].map((r) => ({
    id: r.id, label: r.label, corners: r.rings[0].length / 2, holes: r.rings.length - 1, predicted: r.predicted,
    first: r.toWorld(r.rings[0][0], r.rings[0][1]).toArray(),
  })));
  assert.deepEqual(regions.map((r) => r.id), [1, 2, 3, 4, 5, 6]);
  assert.deepEqual(regions.map((r) => r.label), [1, 6, 5, 3, 3, 4]);  // the numbers of region_v1_t
  assert.deepEqual(regions.map((r) => r.holes), [1, 0, 0, 0, 0, 0]);
  assert.deepEqual(regions.map((r) => r.predicted), [false, false, false, false, true, false]);
  exampleRegions().forEach((expected, i) => expected.outline[0].forEach((value, axis) => (
    assert.ok(Math.abs(regions[i].first[axis] - value) < 1e-5, `region ${i + 1} lies where the map says`))));
}));

test('picks the region under the pointer, nothing through a hole, and the nearer of two', () => withPage('#view=top', async (page) => {
  const floor = await pickAt(page, [0.5, 0.5, 0]);
  assert.equal(floor.id, 1);
  assert.ok(Math.hypot(floor.point[0] - 0.5, floor.point[1] - 0.5, floor.point[2]) < 0.01);
  assert.equal((await pickAt(page, [-0.75, -0.75, 0])).id, 2);
  assert.equal(await pickAt(page, [1.25, 1.25, 0]), null);
}));

test('draws a region in the colour of its label and a drop in vermilion', () => withPage('#view=top&switched=grid,staircases', async (page) => {
  const colourAt = async (point) => {
    const at = await placeOf(page, point);
    return page.evaluate(([x, y]) => {
      window.terrace.view.drawWhole();
      const canvas = document.getElementById('scene');
      const copy = document.createElement('canvas');
      [copy.width, copy.height] = [canvas.width, canvas.height];
      copy.getContext('2d').drawImage(canvas, 0, 0);
      return [...copy.getContext('2d').getImageData(Math.round(x), Math.round(y), 1, 1).data].slice(0, 3);
    }, [at.x, at.y]);
  };
  const near = (colour, expected) => colour.every((v, i) => Math.abs(v - expected[i]) <= 20);
  assert.ok(near(await colourAt([0.5, 0.5, 0]), [0, 158, 115]), 'the walkway is bluish green');
  assert.ok(near(await colourAt([-0.75, -0.75, 0.5]), [204, 121, 167]), 'the obstacle is reddish purple');
  assert.ok(near(await colourAt([0, -1.985, 0]), [213, 94, 0]), 'the band along the drop is vermilion');
}));

test('draws half as many pixels a side while a slow picture moves, and all of them at rest', () => withPage('#view=top', async (page) => {
  const widths = await page.evaluate(async () => {
    const { view } = window.terrace;
    const canvas = document.getElementById('scene');
    const nextTurn = () => new Promise((resolve) => { requestAnimationFrame(resolve); });
    view.detail.tick = () => false;  // no clock
    view.detail.level = 3;
    view.applyDetail();
    await nextTurn();
    const moving = canvas.width;
    view.drawWhole();
    return [moving, canvas.width, canvas.clientWidth];
  });
  assert.ok(Math.abs(widths[0] - widths[2] / 2) <= 1, `half of ${widths[2]}: ${widths[0]}`);
  assert.equal(widths[1], widths[2]);
}));

test('tells about the region that is clicked', () => withPage('#view=top', async (page) => {
  const { x, y } = await placeOf(page, [-0.75, -0.75, 0.5]);
  await page.mouse.click(x, y);
  const text = await page.textContent('#details');
  for (const words of ['Region 2', 'obstacle (90 % sure)', 'stands on the ground', '0.500']) assert.ok(text.includes(words), `${words} in: ${text}`);
  await page.keyboard.press('Escape');
  assert.equal(await page.isHidden('#details'), true);
}));

test('measures between two points', () => withPage('#view=top', async (page) => {
  await page.keyboard.press('m');
  for (const point of [[-1.5, 0.5, 0], [1.5, 0.5, 0]]) {
    const { x, y } = await placeOf(page, point);
    await page.mouse.click(x, y);
  }
  const [a, b] = await page.evaluate(() => window.terrace.measurePoints.map((p) => p.toArray()));
  assert.ok(Math.abs(Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]) - 3) < 0.03);
}));

test('numbers the steps of a staircase and says its dimensions', () => withPage('', async (page) => {
  const texts = await page.evaluate(() => window.terrace.view.staircases.texts);
  assert.deepEqual(texts, ['1', '2', '2 steps of 0.170 m, treads 0.300 m, 1.00 m wide']);
}));

/// A record as `terrace view` sends it (tools/view_record.h).
const apply = (page, kind, bytes) => page.evaluate(([k, content]) => {
  const { model, view } = window.terrace;
  model.apply({ kind: k, utime: 1, heardUtime: 0, content: new Uint8Array(content) });
  if (model.numBad > 0) throw new Error(model.lastProblem);
  view.update();
  view.draw();
}, [kind, [...bytes]]);

function bytesOf(parts) {
  return Buffer.concat(parts.map(([type, ...values]) => Buffer.from(new type(values).buffer)));
}

test('draws the cells of the octree and the points of a disparity image where they are', () => withPage('', async (page) => {
  // Edge of a leaf and lowest corner; two cells, the second one four leaves wide.
  await apply(page, 'V', bytesOf([[Float32Array, 0.02, 1, -1, 0.5], [Uint16Array, 0, 0, 0, 1, 10, 20, 30, 4]]));
  await apply(page, 'N', bytesOf([[Float32Array, 0.5, 0, 1, 0.002], [Int16Array, 500, -500, -250, 0, 0, 0]]));
  const near = (found, expected) => expected.forEach((value, i) => assert.ok(Math.abs(found[i] - value) < 1e-5, `${found} is ${expected}`));
  const { cells, edges, points, words } = await page.evaluate(() => {
    const { model, view } = window.terrace;
    window.terrace.setLayer('points', true);
    window.terrace.showPanels();
    return {
      cells: [...model.cells.positions], edges: [...model.cells.edges], points: [...model.points.positions],
      words: [view.voxels.numDrawn, document.getElementById('state').textContent],
    };
  });
  near(cells, [1.01, -0.99, 0.51, 1.24, -0.56, 1.14]);
  near(edges, [0.02, 0.08]);
  near(points, [1.5, -1, 0.5, 0.5, 0, 1]);
  assert.equal(words[0], 2);
  assert.match(words[1], /2 of 2 cells, 2 of 2 points/);
}));

test('draws a plan of footsteps with a sole for each step, and takes it away when there is none', () => withPage('', async (page) => {
  const plan = (n) => page.evaluate((count) => {
    const { model, view } = window.terrace;
    const steps = [...Array(count).keys()];
    model.plan = {
      utime: 1, map_id: 1, foot_radius: 0.03, n_steps: count, side: steps.map((i) => i % 2), pos: steps.map((i) => [0.2 * i, i % 2 ? -0.1 : 0.1, 0]),
      normal: steps.map(() => [0, 0, 1]), heading: steps.map(() => 0), gait: steps.map((i) => (i === 2 ? 1 : 0)),
    };
    view.update();
    view.draw();
    const meshes = view.footsteps.group.children.filter((child) => child.type === 'Mesh');
    return { meshes: meshes.map((mesh) => mesh.position.toArray().map((v) => Number(v.toFixed(3)))), texts: view.footsteps.group.children.length };
  }, n);
  const { meshes } = await plan(3);
  assert.deepEqual(meshes, [[0, 0.1, 0.006], [0.2, -0.1, 0.006], [0.4, 0.1, 0.006], [0.4, 0.1, 0.006]]);  // the last one has a rim, it climbs
  assert.equal((await plan(0)).texts, 0);
}));

test('lays the image on what the camera saw, and not on what something nearer hid', () => withPage('#view=top&switched=grid,staircases,texture,edges,outlines', async (page) => {
  // A camera 2 m over the box top of half a metre (region 2) looks straight down; its image is white.
  const colours = await page.evaluate(async () => {
    const { model, view } = window.terrace;
    const canvas = Object.assign(document.createElement('canvas'), { width: 64, height: 48 });
    const context = canvas.getContext('2d');
    context.fillStyle = 'white';
    context.fillRect(0, 0, 64, 48);
    const blob = await new Promise((resolve) => { canvas.toBlob(resolve, 'image/jpeg'); });
    model.camera = { width: 64, height: 48, fx: 30, fy: 30, cx: 31.5, cy: 23.5 };
    model.picture = { utime: 1, jpeg: new Uint8Array(await blob.arrayBuffer()) };
    view.update();
    for (let i = 0; i < 100 && !view.inset.texture; ++i) await new Promise((resolve) => { setTimeout(resolve, 50); });
    const v = view.cameras.controls.target.clone();
    view.inset.picturePose = { position: v.clone().set(-0.75, -0.75, 1), rotation: view.cameras.active.quaternion.clone().set(1, 0, 0, 0) };
    const at = (place) => {
      view.drawWhole();
      const scene = document.getElementById('scene');
      const copy = Object.assign(document.createElement('canvas'), { width: scene.width, height: scene.height });
      copy.getContext('2d').drawImage(scene, 0, 0);
      const { x, y } = view.project(v.clone().set(...place));
      return [...copy.getContext('2d').getImageData(Math.round(x), Math.round(y), 1, 1).data].slice(0, 3);
    };
    // The box top; the floor well beside it; the floor under it, once the top is not drawn from above.
    const [top, beside] = [at([-0.75, -0.75, 0.5]), at([0.2, -0.75, 0])];
    view.cameras.active.position.z = 0.3;  // between the floor and the top
    view.cameras.active.near = 0.001;
    view.cameras.active.updateProjectionMatrix();
    return { top, beside, under: at([-0.75, -0.75, 0]) };
  });
  const isWhitish = ([r, g, b]) => Math.min(r, g, b) > 150;
  assert.ok(isWhitish(colours.top), `the top is in the image: ${colours.top}`);
  assert.ok(isWhitish(colours.beside), `the floor beside it is in the image: ${colours.beside}`);
  assert.ok(!isWhitish(colours.under), `the floor under the top is not: ${colours.under}`);
}));

test('asks for what is shown and for nothing else', () => withPage('', async (page) => {
  const wants = (layers) => page.evaluate((switched) => {
    const asked = [];
    window.terrace.live = { setWants: (names) => asked.push(names), connected: true };
    for (const layer of switched) window.terrace.setLayer(layer, !window.terrace.view.shown.get(layer));
    window.terrace.live = null;
    return asked.at(-1).sort();
  }, layers);
  assert.deepEqual(await wants(['disparity']), ['cells', 'disparity', 'image']);
  assert.deepEqual(await wants(['voxels', 'points', 'image', 'disparity']), ['points']);
  assert.deepEqual(await wants(['texture', 'points']), ['image']);
}));

test('hides and shows layers', () => withPage('', async (page) => {
  await page.click('[data-name=layers]');
  await page.click('[data-layer=surfaces]');
  assert.equal(await page.evaluate(() => window.terrace.view.surfaces.group.children.some((c) => c.type === 'Mesh' && c.visible && c.geometry.index.count > 100)), false);
  assert.equal(await page.evaluate(() => window.terrace.view.shown.get('surfaces')), false);
}));

test('reproduces a view by its link', () => withPage('', async (page) => {
  await page.keyboard.press('4');
  await page.keyboard.press('d');
  const hash = await page.evaluate(() => {
    window.terrace.view.cameras.takePlace({ position: [3, -4, 5], target: [0.5, 0.25, 0], zoom: 1 });
    window.terrace.setLayer('grid', false);
    window.terrace.select(3);
    return window.terrace.hash();
  });
  await withPage(`#${hash}`, async (other) => {
    assert.equal(await other.evaluate(() => window.terrace.hash()), hash);
    assert.equal(await other.evaluate(() => document.documentElement.dataset.theme), 'dark');
    assert.equal(await other.evaluate(() => window.terrace.view.surfaces.mode), 'height');
  });
}));

test('draws 5,000 regions', async () => {
  const regions = [];
  for (let i = 0; i < 5000; ++i) {
    const [x, y] = [(i % 100) * 0.6, Math.floor(i / 100) * 0.6];
    regions.push(level(i + 1, i % 3 === 0 ? 'obstacle' : 'walkway', x, y, x + 0.5, y + 0.5, 0.1 * (i % 5)));
  }
  writeMap(join(folder, 'large.json'), regions);
  const large = await startView(program, ['--map', join(folder, 'large.json')]);
  await withPage('#view=top', async (page) => {
    assert.equal(await page.evaluate(() => window.terrace.model.regions.size), 5000);
    assert.equal(await page.evaluate(() => window.terrace.view.surfaces.numTriangles), 10000);
    assert.equal((await pickAt(page, [99 * 0.6 + 0.25, 49 * 0.6 + 0.25, 0.4])).id, 5000);
  }, large.url);
  await large.stop();
});
