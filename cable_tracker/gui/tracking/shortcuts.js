// Keys that work wherever no field wants them.
//
// What an element of the page with `data-command` does happens at once. Everything else goes to the server.
// When that is to open a dialog, keys do nothing until it is there: they are meant for it.

const TYPING = "input:not([type=checkbox]):not([type=range]), textarea, select, [contenteditable], dialog, [role=dialog]";
const LONGEST_OPENING = 2000;

export default {
  template: `<span hidden></span>`,
  emits: ["command"],
  props: { keys: Object, dialogs: Array },
  mounted() {
    this.openingUntil = 0;
    this.listen = (event) => {
      if (event.ctrlKey || event.altKey || event.metaKey) return;
      if (event.target instanceof Element && event.target.closest(TYPING)) return;
      const action = this.keys[event.shiftKey ? `Shift+${event.key}` : event.key] ?? this.keys[event.key];
      if (!action) return;
      // A button in focus is pressed by the space bar; that would act twice.
      event.preventDefault();
      if (performance.now() < this.openingUntil) return;
      if (this.dialogs.includes(action)) this.openingUntil = performance.now() + LONGEST_OPENING;
      const element = document.querySelector(`[data-command=${action}]`);
      if (element instanceof HTMLButtonElement) element.click();
      else if (element) element.focus();
      else this.$emit("command", { name: action });
    };
    // A dialog that is there takes the focus, and may be closed again before that time is over.
    this.opened = (event) => event.target.closest?.("dialog, [role=dialog]") && (this.openingUntil = 0);
    window.addEventListener("focusin", this.opened);
    window.addEventListener("keydown", this.listen);
    this.stop = (event) => {
      if (event.key === " " && event.target instanceof HTMLButtonElement && this.keys[" "] && !event.target.closest("[role=dialog]"))
        event.preventDefault();
    };
    window.addEventListener("keyup", this.stop);
  },
  beforeUnmount() {
    window.removeEventListener("keydown", this.listen);
    window.removeEventListener("keyup", this.stop);
    window.removeEventListener("focusin", this.opened);
  },
};
