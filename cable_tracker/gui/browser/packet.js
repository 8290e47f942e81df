// The browser's half of packet.py.

/** Take a packet apart: the description, with each section under `parts` by its name. */
export function unpack(buffer) {
  const length = new DataView(buffer).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(buffer, 4, length));
  const description = JSON.parse(text);
  const start = 4 + length;
  description.parts = {};
  for (const { name, kind, shape, offset, size } of description.sections) {
    description.parts[name] =
      kind === "float32"
        ? { rows: shape[0], columns: shape[1] ?? 1, values: new Float32Array(buffer, start + offset, size / 4) }
        : new Blob([new Uint8Array(buffer, start + offset, size)], { type: "image/jpeg" });
  }
  return description;
}
