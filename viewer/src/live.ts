// SPDX-License-Identifier: BSD-3-Clause
// A connection to `terrace view` that comes back by itself.
import { parseRecord, StreamRecord } from './records';

const RETRY_FIRST_MS = 250;
const RETRY_MAX_MS = 4000;

export class Live {
  numBytes = 0;
  connected = false;
  private socket: WebSocket | null = null;
  private retryMs = RETRY_FIRST_MS;
  private wants: string[] = [];

  constructor(
    private readonly onRecord: (record: StreamRecord, bytes: Uint8Array) => void,
    private readonly onConnection: (connected: boolean) => void,
  ) {
    this.connect();
  }

  /// What the server is asked for: commands, the whole map again.
  ask(request: object): void {
    if (this.socket?.readyState === WebSocket.OPEN) this.socket.send(JSON.stringify(request));
  }

  /// What is sent only to whom it is shown, so that nobody pays for more: image, disparity, cells, points.
  setWants(wants: string[]): void {
    if (wants.join() === this.wants.join()) return;
    this.wants = wants;
    this.ask({ wants });
  }

  private connect(): void {
    const address = new URL('stream', location.href);
    address.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
    address.hash = '';
    const socket = new WebSocket(address);
    socket.binaryType = 'arraybuffer';
    this.socket = socket;
    socket.onopen = () => {
      this.retryMs = RETRY_FIRST_MS;
      this.connected = true;
      this.onConnection(true);
      this.ask({ wants: this.wants });
    };
    socket.onmessage = (event) => {
      const bytes = new Uint8Array(event.data as ArrayBuffer);
      this.numBytes += bytes.length;
      this.onRecord(parseRecord(bytes), bytes);
    };
    socket.onclose = () => {
      this.connected = false;
      this.onConnection(false);
      setTimeout(() => this.connect(), this.retryMs);
      this.retryMs = Math.min(RETRY_MAX_MS, 2 * this.retryMs);
    };
  }
}
