// The picture of the cell that the gateway sent, as elements of this page. It holds names that others chose, so it is copied
// piece by piece: only what draws, and of that only what places it. No script, style, link or reference comes over.

import { drawn } from "./dom.js";

const kElements = new Set(["svg", "g", "title", "rect", "line", "path", "circle", "text", "tspan"]);
const kAttributes = new Set([
  "viewBox", "x", "y", "x1", "y1", "x2", "y2", "width", "height", "rx", "cx", "cy", "r", "d", "class", "font-size", "text-anchor",
  "data-module", "data-device", "data-connection",
]);

/// Null where the text is no picture.
export function drawingOf(text) {
  // The drawing's own colours go first: the policy of the page forbids them, and the browser would complain. drawing.css has them.
  const plain = text.replace(/<style>[^<]*<\/style>/, "");
  const parsed = new DOMParser().parseFromString(plain, "image/svg+xml").documentElement;
  return parsed.localName === "svg" ? copied(parsed) : null;
}

function copied(from) {
  const to = drawn(from.localName);
  for (const { name, value } of from.attributes) if (kAttributes.has(name)) to.setAttribute(name, value);
  for (const child of from.childNodes) {
    if (child.nodeType === Node.TEXT_NODE) to.append(child.data);
    else if (child.nodeType === Node.ELEMENT_NODE && kElements.has(child.localName)) to.append(copied(child));
  }
  return to;
}
