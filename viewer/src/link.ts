// SPDX-License-Identifier: BSD-3-Clause
// The view as a link: whoever opens it sees the same.
import { Place, View, VIEWS } from './cameras';
import { Mode, MODES } from './colouring';

export interface ViewState {
  view: View;
  place: Place;
  mode: Mode;
  switched: string[];  // layers that are shown or hidden otherwise than at first
  dark: boolean;
  region: number | null;
  seconds: number | null;  // on the time line, from its start
}

export function toHash(state: ViewState): string {
  const numbers = [...state.place.position, ...state.place.target, state.place.zoom];
  const parts: Record<string, string> = {
    view: state.view, at: numbers.join(','), mode: state.mode, switched: state.switched.join(','), theme: state.dark ? 'dark' : 'light',
  };
  if (state.region !== null) parts.region = String(state.region);
  if (state.seconds !== null) parts.t = state.seconds.toFixed(3);
  return new URLSearchParams(parts).toString();
}

/// What of it can be read; a link that was cut still gives the rest.
export function fromHash(hash: string): Partial<ViewState> {
  const parts = new URLSearchParams(hash.replace(/^#/, ''));
  const state: Partial<ViewState> = {};
  const view = parts.get('view') as View;
  if (VIEWS.includes(view)) state.view = view;
  const mode = parts.get('mode') as Mode;
  if (MODES.includes(mode)) state.mode = mode;
  const numbers = (parts.get('at') ?? '').split(',').map(Number);
  if (numbers.length === 7 && numbers.every(Number.isFinite) && numbers[6] > 0) {
    const [px, py, pz, tx, ty, tz, zoom] = numbers;
    state.place = { position: [px, py, pz], target: [tx, ty, tz], zoom };
  }
  if (parts.has('switched')) state.switched = parts.get('switched')!.split(',').filter((name) => name !== '');
  if (parts.has('theme')) state.dark = parts.get('theme') === 'dark';
  for (const [key, name] of [['region', 'region'], ['t', 'seconds']] as const) {
    const value = Number(parts.get(key));
    if (parts.has(key) && Number.isFinite(value)) state[name] = value;
  }
  return state;
}
