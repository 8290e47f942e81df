// Packets of a channel: taken apart (see web/frame_channel.py), and handed to everything on the page that shows a
// part of one.

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

const feeds = new Map();

function feedOf(channel) {
  if (!feeds.has(channel)) feeds.set(channel, { listeners: new Set(), last: null });
  return feeds.get(channel);
}

/** Tell all listeners of a channel. */
export function publish(channel, description) {
  const feed = feedOf(channel);
  feed.last = description;
  for (const listener of feed.listeners) listener(description);
}

/** Listen to a channel, beginning with the last packet if there was one; returns how to end it. */
export function subscribe(channel, listener) {
  const feed = feedOf(channel);
  feed.listeners.add(listener);
  if (feed.last) listener(feed.last);
  return () => feed.listeners.delete(listener);
}
