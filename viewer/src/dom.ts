// SPDX-License-Identifier: BSD-3-Clause
// Short ways to make elements. Text is only ever set as text: names from the bus cannot become markup.

type Child = Node | string;

export function h<K extends keyof HTMLElementTagNameMap>(tag: K, attributes: Record<string, string | (() => void)> = {}, ...children: Child[]): HTMLElementTagNameMap[K] {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (typeof value === 'function') element.addEventListener(name, value);
    else element.setAttribute(name, value);
  }
  element.append(...children);
  return element;
}

export function byId<T extends HTMLElement>(id: string): T {
  return document.getElementById(id) as T;
}

export function table(rows: [string, string][]): HTMLTableElement {
  return h('table', {}, ...rows.map(([name, value]) => h('tr', {}, h('td', {}, name), h('td', {}, value))));
}

export function chip(colour: string, edge = false): HTMLElement {
  return h('span', { class: edge ? 'chip edge' : 'chip', style: `background: ${colour}` });
}

export function download(name: string, content: Blob): void {
  const link = h('a', { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

let toastEnd = 0;
export function say(text: string): void {
  const toast = byId('toast');
  toast.textContent = text;
  toast.hidden = false;
  window.clearTimeout(toastEnd);
  toastEnd = window.setTimeout(() => { toast.hidden = true; }, 4000);
}
