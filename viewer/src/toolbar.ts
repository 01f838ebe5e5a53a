// SPDX-License-Identifier: BSD-3-Clause
// The bar of buttons, the menus and the keys: everything a person can ask of the page.
import { VIEWS } from './cameras';
import { MODES } from './colouring';
import { h } from './dom';
import { Layer, LAYERS } from './view3d';

export interface Actions {
  setView(view: string): void;
  setMode(mode: string): void;
  setLayer(layer: Layer, on: boolean): void;
  frame(): void;
  measure(): void;
  theme(): void;
  link(): void;
  picture(): void;
  record(): void;
  help(): void;
  close(): void;
  playPause(): void;
  command(name: string): void;
}

const VIEW_TITLES: Record<string, string> = { free: 'Free camera', follow: 'Follow the robot', top: 'Plan', side: 'Elevation' };
const KEYS: [string, string, (a: Actions) => void][] = [
  ['f', 'follow the robot', (a) => a.setView('follow')],
  ['g', 'free camera', (a) => a.setView('free')],
  ['t', 'plan', (a) => a.setView('top')],
  ['e', 'elevation', (a) => a.setView('side')],
  ['a', 'show all', (a) => a.frame()],
  ['1', 'colour by label', (a) => a.setMode('label')],
  ['2', 'colour by sigma', (a) => a.setMode('sigma')],
  ['3', 'colour by age', (a) => a.setMode('age')],
  ['4', 'colour by height', (a) => a.setMode('height')],
  ['5', 'seen or predicted', (a) => a.setMode('seen')],
  ['m', 'measure between two points', (a) => a.measure()],
  ['d', 'light or dark', (a) => a.theme()],
  ['l', 'copy a link to this view', (a) => a.link()],
  ['p', 'save a picture', (a) => a.picture()],
  [' ', 'play or pause', (a) => a.playPause()],
  ['Escape', 'close, let go', (a) => a.close()],
  ['?', 'this help', (a) => a.help()],
];

export class Toolbar {
  private readonly buttons = new Map<string, HTMLButtonElement>();
  private readonly modes: HTMLSelectElement;
  private readonly boxes = new Map<Layer, HTMLInputElement>();
  private readonly name = h('span', { class: 'name' }, 'Terrace');
  private readonly controls = h('span', { class: 'group', hidden: '' });

  constructor(bar: HTMLElement, private readonly actions: Actions) {
    const views = h('span', { class: 'group' }, ...VIEWS.map((view) => this.button(view, VIEW_TITLES[view], () => actions.setView(view))));
    this.modes = h('select', { 'aria-label': 'Colour by' }, ...MODES.map((mode) => h('option', { value: mode }, `colour: ${mode}`)));
    this.modes.addEventListener('change', () => actions.setMode(this.modes.value));
    for (const [name, title] of [['pause', 'Pause the daemon'], ['resume', 'Let the daemon go on'], ['reset', 'Begin a new map'], ['snapshot', 'Have the whole map sent again'], ['save', 'Save the map on the robot']]) {
      this.controls.append(this.button(name, title, () => actions.command(name)));
    }
    bar.append(this.name, h('span', { class: 'space' }), this.controls, views, this.modes, this.layerMenu(),
      this.button('all', 'Show all (A)', () => actions.frame()), this.button('measure', 'Measure between two points (M)', () => actions.measure()),
      this.button('link', 'Copy a link to this view (L)', () => actions.link()), this.button('picture', 'Save a picture (P)', () => actions.picture()),
      this.button('record', 'Record what comes into a page of its own', () => actions.record()),
      this.button('dark', 'Light or dark (D)', () => actions.theme()), this.button('?', 'Keys', () => actions.help()));
    window.addEventListener('keydown', (event) => this.onKey(event));
  }

  show(state: { name: string; view: string; mode: string; layers: Map<Layer, boolean>; measuring: boolean; recording: boolean; canRecord: boolean; dark: boolean; control: boolean }): void {
    this.name.textContent = state.name;
    this.name.title = state.name;
    for (const view of VIEWS) this.press(view, view === state.view);
    this.press('measure', state.measuring);
    this.press('record', state.recording);
    this.press('dark', state.dark);
    this.modes.value = state.mode;
    this.controls.hidden = !state.control;
    this.buttons.get('record')!.hidden = !state.canRecord;
    for (const [layer, box] of this.boxes) box.checked = state.layers.get(layer) ?? true;
  }

  private press(name: string, on: boolean): void {
    this.buttons.get(name)!.setAttribute('aria-pressed', String(on));
  }

  private button(name: string, title: string, click: () => void): HTMLButtonElement {
    const button = h('button', { title, click, 'data-name': name }, name);
    this.buttons.set(name, button);
    return button;
  }

  private layerMenu(): HTMLElement {
    const list = h('div', { id: 'layers' });
    for (const layer of LAYERS) {
      const box = h('input', { type: 'checkbox', 'data-layer': layer });
      box.addEventListener('change', () => this.actions.setLayer(layer, box.checked));
      this.boxes.set(layer, box);
      list.append(h('label', {}, box, ` ${layer}`));
    }
    const panel = h('div', { class: 'panel', hidden: '' }, list);
    return h('span', { class: 'menu' }, h('button', { click: () => { panel.hidden = !panel.hidden; }, title: 'What is shown', 'data-name': 'layers' }, 'layers'), panel);
  }

  private onKey(event: KeyboardEvent): void {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.target instanceof HTMLSelectElement || (event.target instanceof HTMLButtonElement && event.key === ' ')) return;
    const found = KEYS.find(([key]) => key === event.key || key === event.key.toLowerCase());
    if (!found) return;
    event.preventDefault();
    found[2](this.actions);
  }
}

export function helpContent(close: () => void): HTMLElement[] {
  return [
    h('h2', {}, 'Keys ', h('button', { click: close }, 'close')),
    h('table', {}, ...KEYS.map(([key, what]) => h('tr', {}, h('td', {}, h('kbd', {}, key === ' ' ? 'space' : key)), h('td', {}, what)))),
    h('p', {}, 'Mouse: left turns, right moves, wheel zooms, a click tells about a region. Touch: one finger turns, two move and zoom.'),
  ];
}
