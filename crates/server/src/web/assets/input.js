// Keys and mouse: names of keys as in EVENT lines, from the places of keys on the keyboard.

const NAMES = {
  Quote: "apostrophe", BracketLeft: "leftbracket", BracketRight: "rightbracket", ContextMenu: "menu",
  ShiftLeft: "leftshift", ShiftRight: "rightshift", ControlLeft: "leftctrl", ControlRight: "rightctrl",
  AltLeft: "leftalt", AltRight: "rightalt", MetaLeft: "leftsuper", MetaRight: "rightsuper",
  NumpadDecimal: "numpaddot", NumpadDivide: "numpadslash", NumpadMultiply: "numpadasterisk",
  NumpadSubtract: "numpadminus", NumpadAdd: "numpadplus",
};

/** Returns the name of a key, or undefined if the browser does not say which one it was. */
export function keyName(event) {
  if (NAMES[event.code]) return NAMES[event.code];
  const code = event.code.replace(/^(Key|Digit|Arrow)/, "");
  return code ? code.toLowerCase() : undefined;
}

/** Returns the typed character's code in hex, or undefined for a key without one. */
export function typed(event) {
  const control = { Enter: "d", Tab: "9", Backspace: "8" }[event.key];
  if (control) return control;
  if (event.ctrlKey || event.altKey || event.metaKey || [...event.key].length !== 1) return undefined;
  return event.key.codePointAt(0).toString(16);
}

/** Returns the held buttons as a sum of 1 (left), 2 (middle) and 4 (right). */
export function buttons(event) {
  const held = event.buttons;
  return (held & 1) | (held & 4 ? 2 : 0) | (held & 2 ? 4 : 0);
}
