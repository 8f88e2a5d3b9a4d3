// Creates elements of the page. Data from the cell becomes text, never HTML markup.

const kSvg = "http://www.w3.org/2000/svg";

/// Creates an HTML element. `attributes` may have the members text, on: {event: function} and dataset: {}. Every other member is an
/// attribute of that name; if its value is false or null, it is left out.
export function element(name, attributes = {}, ...children) {
  const made = document.createElement(name);
  fill(made, attributes, children);
  return made;
}

export function drawn(name, attributes = {}, ...children) {
  const made = document.createElementNS(kSvg, name);
  fill(made, attributes, children);
  return made;
}

function fill(made, attributes, children) {
  for (const [name, value] of Object.entries(attributes)) {
    if (value === false || value === null || value === undefined) continue;
    if (name === "text") made.textContent = value;
    else if (name === "on") for (const [event, act] of Object.entries(value)) made.addEventListener(event, act);
    else if (name === "dataset") Object.assign(made.dataset, value);
    else made.setAttribute(name, value === true ? "" : value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
}

/// Creates a symbol, which index.html defines. Screen readers skip it, because a word always stands beside it.
export function sign(name) {
  return drawn("svg", { class: "sign", "aria-hidden": "true" }, drawn("use", { href: `#sign-${name}` }));
}

/// Sets the text of an element only if the text has changed, because every write causes a layout.
export function setText(node, text) {
  if (node.textContent !== text) node.textContent = text;
}

export function setAttribute(node, name, value) {
  if (value === null || value === false) {
    if (node.hasAttribute(name)) node.removeAttribute(name);
  } else if (node.getAttribute(name) !== String(value)) {
    node.setAttribute(name, value);
  }
}

/// A sign and a word in the colour of a look (see looks.js). show() changes all three.
export class Mark {
  constructor(name = "span") {
    this.use = drawn("use");
    this.word = element("span", { class: "word" });
    this.element = element(name, { class: "mark" },
      drawn("svg", { class: "sign", "aria-hidden": "true" }, this.use), this.word);
  }

  show({ look, sign, word }) {
    setAttribute(this.use, "href", `#sign-${sign}`);
    setAttribute(this.element, "data-look", look);
    setText(this.word, word);
  }
}

/// A bar that shows a share, with words beside it. A share above 1 fills the bar and marks it.
export class Bar {
  constructor() {
    this.filled = element("span", { class: "filled" });
    this.words = element("span", { class: "words" });
    this.element = element("span", { class: "bar" },
      element("span", { class: "track", "aria-hidden": "true" }, this.filled), this.words);
  }

  /// Shows the share and the words. If `share` is null, only the words are shown.
  show(share, words) {
    setAttribute(this.element, "data-look", share === null ? "none" : share > 1 ? "bad" : share > 0.8 ? "poor" : "good");
    const width = `${Math.round(Math.min(share ?? 0, 1) * 100)}%`;
    if (this.filled.style.width !== width) this.filled.style.width = width;
    setText(this.words, share !== null && share > 1 ? `! ${words}` : words);
  }
}

/// Lets the arrow keys, Home and End move the focus among the elements in `root` that match `selector`. The Tab key stops at only one of
/// them.
export function arrows(root, selector, { across = false, chosen = () => {} } = {}) {
  const back = across ? "ArrowLeft" : "ArrowUp";
  const on = across ? "ArrowRight" : "ArrowDown";
  root.addEventListener("keydown", (event) => {
    if (event.altKey || event.ctrlKey || event.metaKey) return;
    const all = [...root.querySelectorAll(selector)].filter((one) => one.offsetParent !== null);
    const at = all.indexOf(event.target.closest(selector));
    const next = { [back]: at - 1, [on]: at + 1, Home: 0, End: all.length - 1 }[event.key];
    if (at < 0 || next === undefined) return;
    event.preventDefault();
    const target = all[Math.max(0, Math.min(next, all.length - 1))];
    target.focus();
    chosen(target);
  });
}
