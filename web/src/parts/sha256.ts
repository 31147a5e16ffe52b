// SHA-256 (FIPS 180-4), as a file comes in pieces: browsers offer theirs only over https, and only for what is whole.
const K = new Uint32Array(64);
const START = new Uint32Array(8);
{
  const part = (value: number) => (value % 1) * 2 ** 32;
  for (let n = 2, at = 0; at < 64; n++) {
    let isPrime = true;
    for (let by = 2; by * by <= n; by++) if (n % by === 0) isPrime = false;
    if (!isPrime) continue;
    if (at < 8) START[at] = part(n ** 0.5);
    K[at++] = part(Math.cbrt(n));
  }
}

export class Sha256 {
  private readonly state = START.slice();
  private readonly words = new Uint32Array(64);
  private readonly rest = new Uint8Array(64);
  private size = 0;

  add(bytes: Uint8Array): void {
    let at = 0;
    const held = this.size % 64;
    this.size += bytes.length;
    if (held) {
      const more = bytes.subarray(0, 64 - held);
      this.rest.set(more, held);
      if (held + more.length < 64) return;
      this.block(this.rest, 0);
      at = more.length;
    }
    for (; at + 64 <= bytes.length; at += 64) this.block(bytes, at);
    this.rest.set(bytes.subarray(at));
  }

  /** All of it, in hexadecimal digits. Nothing is added after. */
  hex(): string {
    const bits = this.size * 8;
    const end = new Uint8Array((this.size % 64 < 56 ? 64 : 128) - this.size % 64);
    end[0] = 0x80;
    new DataView(end.buffer).setUint32(end.length - 8, Math.floor(bits / 2 ** 32));
    new DataView(end.buffer).setUint32(end.length - 4, bits);
    this.add(end);
    return [...this.state].map((word) => word.toString(16).padStart(8, "0")).join("");
  }

  private block(bytes: Uint8Array, at: number): void {
    const { state, words: w } = this;
    for (let i = 0, from = at; i < 16; i++, from += 4) w[i] = bytes[from]! << 24 | bytes[from + 1]! << 16 | bytes[from + 2]! << 8 | bytes[from + 3]!;
    for (let i = 16; i < 64; i++) {
      const x = w[i - 15]!;
      const y = w[i - 2]!;
      w[i] = ((x >>> 7 | x << 25) ^ (x >>> 18 | x << 14) ^ x >>> 3) + w[i - 16]! + ((y >>> 17 | y << 15) ^ (y >>> 19 | y << 13) ^ y >>> 10) + w[i - 7]!;
    }
    let [a, b, c, d, e, f, g, h] = state as unknown as [number, number, number, number, number, number, number, number];
    for (let i = 0; i < 64; i++) {
      const one = h + ((e >>> 6 | e << 26) ^ (e >>> 11 | e << 21) ^ (e >>> 25 | e << 7)) + ((e & f) ^ (~e & g)) + K[i]! + w[i]! | 0;
      const two = ((a >>> 2 | a << 30) ^ (a >>> 13 | a << 19) ^ (a >>> 22 | a << 10)) + ((a & b) ^ (a & c) ^ (b & c)) | 0;
      h = g; g = f; f = e; e = d + one | 0; d = c; c = b; b = a; a = one + two | 0;
    }
    [a, b, c, d, e, f, g, h].forEach((value, i) => { state[i]! += value; });
  }
}
