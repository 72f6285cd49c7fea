/**
 * Messages of the socket: 16 bytes of head (kind, sequence, count, revision; u32, little endian),
 * then JSON, numbers of a drag, or the place of the pointer.
 */

export const JSON_KIND = 1;
export const NUMBERS_KIND = 2;
const POINTER_KIND = 3;
const HEAD = 16;

const encoder = new TextEncoder();
const decoder = new TextDecoder();

/**
 * A JSON message.
 * @param {object} message
 * @param {number} [sequence]
 * @returns {ArrayBuffer}
 */
export function encodeJson(message, sequence = 0) {
  const text = encoder.encode(JSON.stringify(message));
  const buffer = new ArrayBuffer(HEAD + text.length);
  head(buffer, JSON_KIND, sequence, text.length);
  new Uint8Array(buffer, HEAD).set(text);
  return buffer;
}

/**
 * The place of the pointer in the sketch.
 * @param {number} x
 * @param {number} y
 * @param {number} sequence
 * @returns {ArrayBuffer}
 */
export function encodePointer(x, y, sequence) {
  const buffer = new ArrayBuffer(HEAD + 16);
  head(buffer, POINTER_KIND, sequence, 2);
  const view = new DataView(buffer);
  view.setFloat64(HEAD, x, true);
  view.setFloat64(HEAD + 8, y, true);
  return buffer;
}

/**
 * What a message holds.
 * @param {ArrayBuffer} buffer
 * @returns {{kind: number, sequence: number, revision: number, json?: any, offsets?: Uint32Array, numbers?: Float64Array}}
 * @throws {RangeError} if it is shorter than its head says, or of an unknown kind
 */
export function decode(buffer) {
  const view = new DataView(buffer);
  const kind = view.getUint32(0, true);
  const sequence = view.getUint32(4, true);
  const count = view.getUint32(8, true);
  const revision = view.getUint32(12, true);
  if (kind === JSON_KIND) {
    const json = JSON.parse(decoder.decode(new Uint8Array(buffer, HEAD, count)));
    return { kind, sequence, revision, json };
  }
  if (kind === NUMBERS_KIND) {
    const offsets = new Uint32Array(buffer, HEAD, count);
    const after = HEAD + 4 * count;
    const numbers = new Float64Array(buffer, after + ((8 - (after % 8)) % 8), count);
    return { kind, sequence, revision, offsets, numbers };
  }
  throw new RangeError(`message of unknown kind ${kind}`);
}

/**
 * @param {ArrayBuffer} buffer
 * @param {number} kind
 * @param {number} sequence
 * @param {number} count
 */
function head(buffer, kind, sequence, count) {
  const view = new DataView(buffer);
  view.setUint32(0, kind, true);
  view.setUint32(4, sequence, true);
  view.setUint32(8, count, true);
  view.setUint32(12, 0, true);
}
