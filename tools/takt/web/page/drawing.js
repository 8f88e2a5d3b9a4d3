// Converts the drawing of the cell to elements of this page. The drawing contains names from the descriptor, which are not trusted. So only
// drawing elements and harmless attributes are copied: no scripts, styles, links or references.

import { drawn } from "./dom.js";

const kElements = new Set(["svg", "g", "title", "rect", "line", "path", "circle", "text", "tspan"]);
const kAttributes = new Set([
  "viewBox", "x", "y", "x1", "y1", "x2", "y2", "width", "height", "rx", "cx", "cy", "r", "d", "class", "font-size", "text-anchor",
  "data-module", "data-device", "data-connection", "data-fold",
]);

/// Returns the drawing as an element, or null if the text is not an SVG drawing.
export function drawingOf(text) {
  // Remove the styles before parsing, because the page's Content-Security-Policy forbids them and the browser would report each one.
  // drawing.css has the styles instead.
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
