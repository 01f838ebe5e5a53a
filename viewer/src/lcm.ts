// SPDX-License-Identifier: BSD-3-Clause
// Reads messages by the .lcm files themselves, so that page and daemon cannot differ: the layout is parsed, and the
// fingerprint in front of every message is compared with the one that lcm-gen computes (lcmgen.c, lcm_struct_hash).

interface Member {
  name: string;
  type: string;
  dims: string[];  // a number, or the name of the member that counts
}

export type LcmValue = number | boolean | string | Uint8Array | LcmValue[] | LcmStruct;
export interface LcmStruct {
  [member: string]: LcmValue;
}

const PRIMITIVE = /^(int8_t|int16_t|int32_t|int64_t|byte|float|double|string|boolean)$/;

function parse(text: string): { name: string; members: Member[] } {
  const plain = text.replace(/\/\/.*$/gm, '');
  const found = /struct\s+(\w+)\s*\{([\s\S]*)\}/.exec(plain);
  if (!found) throw new Error('no struct in an .lcm file');
  const members: Member[] = [];
  for (const statement of found[2].split(';')) {
    const line = statement.trim();
    if (line === '' || line.startsWith('const')) continue;
    const member = /^([\w.]+)\s+(\w+)((?:\s*\[\s*\w+\s*\])*)$/.exec(line);
    if (!member) throw new Error(`cannot read "${line}" in ${found[1]}`);
    const dims = [...member[3].matchAll(/\[\s*(\w+)\s*\]/g)].map((m) => m[1]);
    members.push({ name: member[2], type: member[1].replace(/^.*\./, ''), dims });
  }
  return { name: found[1], members };
}

function mix(hash: bigint, value: number): bigint {
  return BigInt.asIntN(64, (BigInt.asIntN(64, hash << 8n) ^ (hash >> 55n)) + BigInt(value));
}

function mixText(hash: bigint, text: string): bigint {
  let mixed = mix(hash, text.length);
  for (const letter of text) mixed = mix(mixed, letter.charCodeAt(0));
  return mixed;
}

export class LcmTypes {
  private readonly types = new Map<string, Member[]>();
  private readonly fingerprints = new Map<string, bigint>();

  constructor(files: string[]) {
    for (const file of files) {
      const { name, members } = parse(file);
      this.types.set(name, members);
    }
  }

  fingerprint(name: string): bigint {
    const known = this.fingerprints.get(name);
    if (known !== undefined) return known;
    let own = 0x12345678n;
    let nested = 0n;
    for (const member of this.membersOf(name)) {
      own = mixText(own, member.name);
      if (PRIMITIVE.test(member.type)) own = mixText(own, member.type);
      else nested += this.fingerprint(member.type);
      own = mix(own, member.dims.length);
      for (const dim of member.dims) own = mixText(mix(own, /^\d/.test(dim) ? 0 : 1), dim);
    }
    const sum = BigInt.asUintN(64, own + nested);
    const rotated = BigInt.asUintN(64, (sum << 1n) + (sum >> 63n));
    this.fingerprints.set(name, rotated);
    return rotated;
  }

  /// The message of that type; throws where the bytes are not exactly one.
  decode(name: string, bytes: Uint8Array): LcmStruct {
    const reader = new Reader(this.types, bytes);
    if (reader.u64() !== this.fingerprint(name)) throw new Error(`not a ${name} of this version`);
    const message = reader.struct(name);
    if (!reader.atEnd()) throw new Error(`a ${name} with something behind it`);
    return message;
  }

  private membersOf(name: string): Member[] {
    const members = this.types.get(name);
    if (!members) throw new Error(`no such type: ${name}`);
    return members;
  }
}

class Reader {
  private at = 0;
  private readonly view: DataView;

  constructor(private readonly types: Map<string, Member[]>, private readonly bytes: Uint8Array) {
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
  }

  atEnd(): boolean {
    return this.at === this.bytes.length;
  }

  u64(): bigint {
    this.at += 8;
    return this.view.getBigUint64(this.at - 8);
  }

  struct(name: string): LcmStruct {
    const result: LcmStruct = {};
    for (const member of this.types.get(name)!) {
      const sizes = member.dims.map((dim) => (/^\d/.test(dim) ? Number(dim) : (result[dim] as number)));
      if (sizes.some((size) => size < 0)) throw new Error(`${name}.${member.name}: a negative count`);
      result[member.name] = this.array(member.type, sizes);
    }
    return result;
  }

  private array(type: string, sizes: number[]): LcmValue {
    if (sizes.length === 0) return this.value(type);
    const [size, ...inner] = sizes;
    if (type === 'byte' && inner.length === 0) {
      this.at += size;
      return this.bytes.subarray(this.at - size, this.at);
    }
    // A count that the message cannot hold must not take the page's memory.
    if (size > this.bytes.length) throw new Error('a count beyond the end of the message');
    const values: LcmValue[] = new Array(size);
    for (let i = 0; i < size; ++i) values[i] = this.array(type, inner);
    return values;
  }

  private value(type: string): LcmValue {
    const at = this.at;
    switch (type) {
      case 'int8_t': this.at += 1; return this.view.getInt8(at);
      case 'byte': this.at += 1; return this.view.getUint8(at);
      case 'boolean': this.at += 1; return this.view.getInt8(at) !== 0;
      case 'int16_t': this.at += 2; return this.view.getInt16(at);
      case 'int32_t': this.at += 4; return this.view.getInt32(at);
      case 'int64_t': this.at += 8; return Number(this.view.getBigInt64(at));
      case 'float': this.at += 4; return this.view.getFloat32(at);
      case 'double': this.at += 8; return this.view.getFloat64(at);
      case 'string': {
        const length = this.view.getInt32(at);
        if (length < 1 || at + 4 + length > this.bytes.length) throw new Error('a string beyond the end of the message');
        this.at += 4 + length;
        return new TextDecoder().decode(this.bytes.subarray(at + 4, at + 3 + length));
      }
      default: return this.struct(type);
    }
  }
}
