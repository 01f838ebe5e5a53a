// SPDX-License-Identifier: BSD-3-Clause
// The page: a model, the scene that draws it, and what a person does with both.
import { Vector3 } from 'three';
import { View, VIEWS } from './cameras';
import { legendOf, Mode, MODES } from './colouring';
import { detailsOf } from './details';
import { byId, chip, download, h, say } from './dom';
import { fromHash, toHash } from './link';
import { Latencies, Latency } from './latency';
import { Live } from './live';
import { Model } from './model';
import { EDGE_COLOURS, TRUTH_COLOUR } from './palette';
import { Player } from './player';
import { parseRecord, parseRecording, recordingOf, StreamRecord, toBase64 } from './records';
import { StatePanel } from './state_panel';
import { Timeline } from './timeline';
import { Actions, helpContent, Toolbar } from './toolbar';
import { isShownAtFirst, Layer, LAYERS, View3d, wantsOf } from './view3d';

const PANEL_EVERY_MS = 250;
const AGE_EVERY_MS = 1000;
const CLICK_PX = 5;

function numberOf(count: number, what: string): string {
  return `${count} ${what}${count === 1 ? '' : 's'}`;
}

export class App implements Actions {
  readonly model = new Model();
  readonly view: View3d;
  live: Live | null = null;
  player: Player | null = null;
  numFrames = 0;
  selected: number | null = null;
  measurePoints: Vector3[] | null = null;
  private readonly toolbar: Toolbar;
  private readonly panel: StatePanel;
  private timeline: Timeline | null = null;
  private readonly latency = new Latency();
  private recording: Uint8Array[] | null = null;
  private dark = matchMedia('(prefers-color-scheme: dark)').matches;
  private modelStale = true;
  private panelDue = 0;
  private ageDue = 0;
  private lastFrameMs = performance.now();

  constructor() {
    this.view = new View3d(byId('scene'), byId('inset'), this.model);
    this.panel = new StatePanel(byId('state'), (utime) => this.goTo(utime));
    this.toolbar = new Toolbar(byId('bar'), this);
    byId('help').append(...helpContent(() => this.help()));
    this.view.onDrawn = () => this.onDrawn();
    this.listenToPointer();
    this.applyTheme();
  }

  startLive(): void {
    this.live = new Live((record, bytes) => this.take(record, bytes), () => { this.modelStale = true; });
    this.begin();
  }

  startRecording(bytes: Uint8Array): void {
    this.player = new Player(parseRecording(bytes), this.model);
    this.player.seek(this.player.endUtime);
    this.timeline = new Timeline(byId('timeline'), this.player, () => { this.modelStale = true; });
    this.begin();
  }

  private begin(): void {
    const state = fromHash(location.hash);
    if (state.dark !== undefined) this.dark = state.dark;
    this.applyTheme();
    if (state.seconds !== undefined && state.seconds !== null) this.player?.seek(this.player.startUtime + 1e6 * state.seconds);
    for (const layer of LAYERS) this.setLayer(layer, isShownAtFirst(layer) !== (state.switched ?? []).includes(layer));
    if (this.player && !state.view) this.view.cameras.view = 'free';
    this.view.update();
    if (state.mode) this.setMode(state.mode);
    if (state.view) this.setView(state.view);
    if (state.place) {
      this.view.cameras.takePlace(state.place);
      this.view.keepPlace();
    }
    if (state.region !== undefined) this.select(state.region);
    requestAnimationFrame((now) => this.tick(now));
  }

  private take(record: StreamRecord, bytes: Uint8Array): void {
    const wasInStep = this.model.inStep;
    this.model.apply(record);
    this.latency.heard(record);
    this.recording?.push(bytes.slice());
    this.modelStale = true;
    if (record.kind === 'T' && wasInStep && !this.model.inStep) this.live?.ask({ snapshot: true });
  }

  private tick(now: number): void {
    const elapsedS = Math.min(0.5, (now - this.lastFrameMs) / 1000);
    this.lastFrameMs = now;
    if (this.player?.advance(elapsedS)) this.modelStale = true;
    if (this.modelStale) {
      this.modelStale = false;
      this.view.update();
      this.timeline?.show();
    }
    if (this.view.surfaces.mode === 'age' && now > this.ageDue) {
      this.ageDue = now + AGE_EVERY_MS;
      this.view.colourBy('age');
    }
    if (now > this.panelDue) {
      this.panelDue = now + PANEL_EVERY_MS;
      this.showPanels();
    }
    this.view.turn(now);
    requestAnimationFrame((next) => this.tick(next));
  }

  private onDrawn(): void {
    this.numFrames += 1;
    this.latency.onScreen((performance.timeOrigin + performance.now()) * 1000);
  }

  latencies(): Latencies {
    return this.latency.medians();
  }

  private showPanels(): void {
    const { model, view } = this;
    const beside = [['voxels', view.voxels, 'cells'], ['points', view.points, 'points']] as const;
    const clouds = beside.filter(([layer, cloud]) => view.shown.get(layer) && cloud.numThere > 0)
      .map(([, cloud, name]) => `, ${cloud.numDrawn} of ${cloud.numThere} ${name}`).join('');
    const counts = `${numberOf(model.regions.size, 'region')}, ${numberOf(model.staircases.size, 'staircase')}${clouds}`;
    this.panel.update(model, { live: this.live !== null, connected: this.live?.connected ?? false, latencies: this.latencies() }, counts);
    const hasPicture = view.inset.texture !== null;
    byId('inset').hidden = !hasPicture || !(view.shown.get('image') || view.shown.get('disparity'));
    if (model.camera) byId('inset').style.aspectRatio = `${model.camera.width} / ${model.camera.height}`;
    byId('inset-caption').textContent = view.inset.caption(model.camera);
    const edges = [['drop', EDGE_COLOURS[1]], ['rise', EDGE_COLOURS[2]], ['joins', EDGE_COLOURS[3]], ['limit of view', EDGE_COLOURS[0]]];
    byId('legend').replaceChildren(
      ...legendOf(view.surfaces.mode, view.surfaces.scale, model.regions.values()).map((e) => h('div', {}, chip(`rgb(${e.colour.map(Math.round).join()})`), e.text)),
      h('div', {}, 'hatched: predicted, not seen'), ...edges.map(([text, colour]) => h('div', {}, chip(colour, true), text)),
      ...(model.truth.length > 0 && view.shown.get('truth') ? [h('div', {}, chip(TRUTH_COLOUR, true), 'truth')] : []));
    this.showDetails();
    this.showToolbar();
  }

  private showToolbar(): void {
    const hello = this.model.hello;
    this.toolbar.show({
      name: hello ? `Terrace: ${hello.name}` : 'Terrace', view: this.view.cameras.view, mode: this.view.surfaces.mode, layers: this.view.shown,
      measuring: this.measurePoints !== null, recording: this.recording !== null, canRecord: this.live !== null, dark: this.dark, control: this.live !== null && (hello?.control ?? false),
    });
  }

  private showDetails(): void {
    const region = this.selected === null ? undefined : this.model.regions.get(this.selected);
    const panel = byId('details');
    panel.hidden = this.selected === null;
    if (region) panel.replaceChildren(...detailsOf(region, this.model, () => this.select(null)));
    else panel.replaceChildren(h('p', {}, `Region ${this.selected} is not in the map.`));
  }

  select(id: number | null): void {
    this.selected = id;
    this.view.select(id);
    this.showDetails();
  }

  private listenToPointer(): void {
    const canvas = byId<HTMLCanvasElement>('scene');
    let down = { x: 0, y: 0 };
    canvas.addEventListener('pointerdown', (e) => { down = { x: e.clientX, y: e.clientY }; });
    canvas.addEventListener('pointerup', (e) => {
      if (e.button === 0 && Math.hypot(e.clientX - down.x, e.clientY - down.y) < CLICK_PX) this.click(e.clientX, e.clientY);
    });
  }

  private click(x: number, y: number): void {
    const hit = this.view.pick(x, y);
    if (this.measurePoints === null) {
      this.select(hit?.region.id ?? null);
      return;
    }
    if (!hit) return;
    this.measurePoints = this.measurePoints.length === 2 ? [hit.point] : [...this.measurePoints, hit.point];
    const [a, b] = this.measurePoints;
    const text = b ? `${a.distanceTo(b).toFixed(3)} m, up ${(b.z - a.z).toFixed(3)} m, level ${Math.hypot(b.x - a.x, b.y - a.y).toFixed(3)} m` : 'and the other point';
    this.view.showMeasure(this.measurePoints, text);
  }

  goTo(utime: number): void {
    if (!this.player) return;
    this.player.playing = false;
    this.player.seek(utime);
    this.modelStale = true;
  }

  // ---- what the toolbar asks for

  setView(view: string): void {
    if (!VIEWS.includes(view as View)) return;
    const { centre, sizeM } = this.view.extent();
    this.view.cameras.choose(view as View, sizeM, centre);
    this.view.invalidate();
    this.showToolbar();
  }

  setMode(mode: string): void {
    if (!MODES.includes(mode as Mode)) return;
    this.view.colourBy(mode as Mode);
    this.panelDue = 0;
  }

  setLayer(layer: Layer, on: boolean): void {
    this.view.setLayer(layer, on);
    this.live?.setWants(wantsOf(this.view.shown));
    this.panelDue = 0;
  }

  frame(): void {
    if (this.view.cameras.view !== 'free') this.setView('free');
    this.view.frameAll();
  }

  measure(): void {
    this.measurePoints = this.measurePoints === null ? [] : null;
    this.view.showMeasure([], '');
    this.showToolbar();
  }

  theme(): void {
    this.dark = !this.dark;
    this.applyTheme();
  }

  link(): void {
    location.hash = this.hash();
    void navigator.clipboard?.writeText(location.href).then(() => say('The link is copied.'), () => say('The link is in the address bar.'));
  }

  hash(): string {
    const seconds = this.player ? (this.player.utime - this.player.startUtime) * 1e-6 : null;
    const switched = LAYERS.filter((layer) => this.view.shown.get(layer) !== isShownAtFirst(layer));
    return toHash({ view: this.view.cameras.view, place: this.view.cameras.place(), mode: this.view.surfaces.mode, switched, dark: this.dark, region: this.selected, seconds });
  }

  picture(): void {
    this.view.drawWhole();
    byId<HTMLCanvasElement>('scene').toBlob((blob) => { if (blob) download('terrace.png', blob); });
  }

  /// First press: from now on everything is kept; second: saved as a page that plays it.
  record(): void {
    if (!this.live) return;
    if (this.recording === null) {
      this.recording = [];
      this.live.ask({ snapshot: true });
      this.showToolbar();
      return;
    }
    const records = this.recording;
    this.recording = null;
    void this.recordedPage(records).then((page) => download('terrace.html', new Blob([page], { type: 'text/html' })));
    this.showToolbar();
  }

  async recordedPage(records: Uint8Array[]): Promise<string> {
    const page = await (await fetch(location.pathname)).text();
    // What came before the first whole map cannot be drawn without it.
    const start = Math.max(0, records.findIndex((bytes) => parseRecord(bytes).kind === 'H'));
    const data = toBase64(recordingOf(records.slice(start)));
    // The last one: this script has the mark, too.
    const mark = '<!--terrace-recording-->';
    const at = page.lastIndexOf(mark);
    return `${page.slice(0, at)}<script id="terrace-recording" type="text/plain">${data}</script>${page.slice(at + mark.length)}`;
  }

  help(): void {
    byId('help').hidden = !byId('help').hidden;
  }

  close(): void {
    byId('help').hidden = true;
    if (this.measurePoints !== null) this.measure();
    this.select(null);
  }

  playPause(): void {
    this.timeline?.toggle();
  }

  command(name: string): void {
    this.live?.ask({ command: name });
  }

  private applyTheme(): void {
    document.documentElement.dataset.theme = this.dark ? 'dark' : 'light';
    this.view.setTheme(this.dark ? '#151a21' : '#eef1f4', this.dark ? '#3c4756' : '#b4bdc8');
    this.showToolbar();
  }
}

