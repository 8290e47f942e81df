// Hands each packet of a channel to everything on the page that shows a part of it.

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
