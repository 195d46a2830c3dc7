// The command line: a log of what was typed and answered, and the history of lines.

/** Lines and characters that the log keeps. */
const MAX_LINES = 1000;
const MAX_LINE = 2000;

export class Console {
  constructor(log, form, field, onLine) {
    Object.assign(this, { log, form, field, history: [], at: 0, draft: "", part: "", decoder: new TextDecoder() });
    form.addEventListener("submit", (event) => {
      event.preventDefault();
      const line = field.value;
      if (!line.trim()) return;
      if (this.history.at(-1) !== line) this.history.push(line);
      [this.at, field.value] = [this.history.length, ""];
      this.print(`> ${line}`, "typed");
      onLine(line);
    });
    field.addEventListener("keydown", (event) => this.recall(event));
  }

  /** Goes through the history by the arrows. */
  recall(event) {
    const step = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (!step) return;
    event.preventDefault();
    if (this.at === this.history.length) this.draft = this.field.value;
    this.at = Math.min(Math.max(this.at + step, 0), this.history.length);
    this.field.value = this.history[this.at] ?? this.draft;
  }

  /** Appends a line, and scrolls to it unless the user looks at earlier ones. */
  print(text, kind) {
    const isAtEnd = this.log.scrollHeight - this.log.scrollTop - this.log.clientHeight < 24;
    const line = document.createElement("div");
    if (kind) line.className = kind;
    line.textContent = text.length > MAX_LINE ? `${text.slice(0, MAX_LINE)} ... ${text.length} characters` : text;
    this.log.append(line);
    while (this.log.childElementCount > MAX_LINES) this.log.firstElementChild.remove();
    if (isAtEnd) this.log.scrollTop = this.log.scrollHeight;
  }

  /** Prints bytes of replies, whose lines may be cut anywhere. */
  reply(bytes) {
    const lines = (this.part + this.decoder.decode(bytes, { stream: true })).split("\n");
    this.part = lines.pop().slice(0, MAX_LINE * 2);
    for (const line of lines) this.print(line, line.startsWith("ERR ") ? "error" : "");
  }

  /** Forgets a reply that was cut off. */
  reset() {
    [this.part, this.decoder] = ["", new TextDecoder()];
  }
}
