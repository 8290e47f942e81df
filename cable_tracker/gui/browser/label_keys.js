// The keys of the labelling window: one table for what they do and for what the help says.

/** group: heading in the help; keys: as in the help; on: what KeyboardEvent says; does: [command, ...]. */
export const KEYS = [
  { group: "Frames", keys: ["Enter"], words: "accept what is drawn, and go on", on: ["Enter"], does: "accept" },
  { group: "Frames", keys: ["PageDown", "."], words: "next frame (Shift: 10)", on: ["PageDown", ".", ">"], does: "next" },
  { group: "Frames", keys: ["PageUp", ","], words: "frame before (Shift: 10)", on: ["PageUp", ",", "<"], does: "previous" },
  { group: "Frames", keys: ["Home", "End"], words: "first, last frame", on: ["Home", "End"], does: "end" },
  { group: "Frames", keys: ["J", "K"], words: "key frame before, after", on: ["j", "k"], does: "key" },
  { group: "Frames", keys: ["U"], words: "next frame without a label", on: ["u"], does: "unlabelled" },
  { group: "Cable", keys: ["←", "→"], words: "move by 1 px (Shift: 10)", on: ["ArrowLeft", "ArrowRight"], does: "move" },
  { group: "Cable", keys: ["↑", "↓"], words: "wider, narrower by 1 px (Shift: 10)", on: ["ArrowUp", "ArrowDown"], does: "move" },
  { group: "Cable", keys: ["Q", "E"], words: "turn by 0.5° (Shift: 5)", on: ["q", "e"], does: "turn" },
  { group: "Cable", keys: ["A", "D"], words: "skew by 0.5° (Shift: 5)", on: ["a", "d"], does: "skew" },
  { group: "Labels", keys: ["P"], words: "propose by the tracker", on: ["p"], does: "propose" },
  { group: "Labels", keys: ["C"], words: "copy to the next frame, and go there", on: ["c"], does: "copy" },
  { group: "Labels", keys: ["I"], words: "interpolate to the key frames beside (Shift: everywhere)", on: ["i"], does: "interpolate" },
  { group: "Labels", keys: ["N"], words: "no cable in view", on: ["n"], does: "none" },
  { group: "Labels", keys: ["Delete"], words: "take the label away", on: ["Delete", "Backspace"], does: "clear" },
  { group: "Labels", keys: ["Esc"], words: "dismiss the proposal", on: ["Escape"], does: "dismiss" },
  { group: "View", keys: ["+", "−", "0"], words: "zoom in, out, whole picture", on: ["+", "=", "-", "0"], does: "zoom" },
  { group: "View", keys: ["Alt ←→↑↓"], words: "move the zoomed picture", on: [], does: "" },
  { group: "View", keys: ["V"], words: "hide what is drawn, while held down", on: ["v"], does: "hide" },
  { group: "View", keys: ["H", "?"], words: "this help", on: ["h", "?"], does: "help" },
  { group: "File", keys: ["Ctrl Z", "Ctrl Y"], words: "undo, redo", on: [], does: "" },
  { group: "File", keys: ["Ctrl S"], words: "save (Shift: save as)", on: [], does: "" },
  { group: "File", keys: ["Ctrl O"], words: "open another label file", on: [], does: "" },
];

const WITH_CONTROL = { z: "undo", y: "redo", s: "save", o: "open" };
const BY_KEY = new Map(KEYS.flatMap(({ on, does }) => on.map((key) => [key, does])));

/** What a key means: {does, key, large}; null if nothing. */
export function meaningOf(event) {
  const key = event.key.length === 1 ? event.key.toLowerCase() : event.key;
  const meaning = (does) => ({ does, key, large: event.shiftKey });
  if (event.ctrlKey || event.metaKey) {
    const does = WITH_CONTROL[key];
    if (!does || event.altKey) return null;
    return meaning(event.shiftKey ? { undo: "redo", save: "save_as" }[does] ?? does : does);
  }
  if (event.altKey) return key.startsWith("Arrow") ? meaning("pan") : null;
  return BY_KEY.has(key) ? meaning(BY_KEY.get(key)) : null;
}
