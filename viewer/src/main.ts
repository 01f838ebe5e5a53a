// SPDX-License-Identifier: BSD-3-Clause
// Where the records come from: inside this page, from a file that `terrace view` serves, or live.
import { App } from './app';
import { byId, say } from './dom';
import { fromBase64 } from './records';
import './style.css';

declare global {
  interface Window {
    terrace: App;
  }
}

async function start(): Promise<void> {
  const app = new App();
  window.terrace = app;
  const inside = byId('terrace-recording');
  if (inside) {
    app.startRecording(fromBase64(inside.textContent ?? ''));
    return;
  }
  const answer = await fetch('recording');
  if (answer.status === 200) app.startRecording(new Uint8Array(await answer.arrayBuffer()));
  else app.startLive();
}

start().catch((error: unknown) => say(error instanceof Error ? error.message : String(error)));
