// SPDX-License-Identifier: BSD-3-Clause
// What reaches the page, over a WebSocket, in a recording or inside the page itself: records. The writer is
// tools/view_record.h: kind (1 byte), 3 bytes of nothing, when it happened and when it was heard (int64, microseconds,
// little endian), the content. In a recording each has its length (uint32) before it.

export type Kind = 'H' | 'T' | 'P' | 'S' | 'R' | 'C' | 'I' | 'F' | 'V' | 'D' | 'N' | 'G' | 'U' | 'W';

export interface StreamRecord {
  kind: Kind;
  utime: number;
  heardUtime: number;
  content: Uint8Array;
}

const HEADER_BYTES = 20;
const MAGIC = 'TERRACE1';

export function parseRecord(bytes: Uint8Array): StreamRecord {
  if (bytes.length < HEADER_BYTES) throw new Error('a record without a whole header');
  const view = new DataView(bytes.buffer, bytes.byteOffset);
  return {
    kind: String.fromCharCode(bytes[0]) as Kind,
    utime: Number(view.getBigInt64(4, true)),
    heardUtime: Number(view.getBigInt64(12, true)),
    content: bytes.subarray(HEADER_BYTES),
  };
}

/// Every whole record; a recording that was cut off ends with the last whole one.
export function parseRecording(bytes: Uint8Array): StreamRecord[] {
  if (new TextDecoder().decode(bytes.subarray(0, MAGIC.length)) !== MAGIC) throw new Error('this is no recording of Terrace');
  const view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  const records: StreamRecord[] = [];
  for (let at = MAGIC.length; at + 4 <= bytes.length;) {
    const size = view.getUint32(at, true);
    if (at + 4 + size > bytes.length) break;
    records.push(parseRecord(bytes.subarray(at + 4, at + 4 + size)));
    at += 4 + size;
  }
  return records;
}

/// The whole of a recording from records as they came.
export function recordingOf(messages: Uint8Array[]): Uint8Array {
  const size = messages.reduce((sum, m) => sum + 4 + m.length, MAGIC.length);
  const bytes = new Uint8Array(size);
  const view = new DataView(bytes.buffer);
  bytes.set(new TextEncoder().encode(MAGIC));
  let at = MAGIC.length;
  for (const message of messages) {
    view.setUint32(at, message.length, true);
    bytes.set(message, at + 4);
    at += 4 + message.length;
  }
  return bytes;
}

export function jsonOf<T>(record: StreamRecord): T {
  return JSON.parse(new TextDecoder().decode(record.content)) as T;
}

export function fromBase64(text: string): Uint8Array {
  const binary = atob(text.trim());
  const bytes = new Uint8Array(binary.length);
  for (let i = 0; i < binary.length; ++i) bytes[i] = binary.charCodeAt(i);
  return bytes;
}

export function toBase64(bytes: Uint8Array): string {
  let binary = '';
  const step = 0x8000;
  for (let at = 0; at < bytes.length; at += step) binary += String.fromCharCode(...bytes.subarray(at, at + step));
  return btoa(binary);
}
