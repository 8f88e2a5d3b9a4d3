// The page's address selects the view: #/modules?select=robot.servo. So a link can open a view, and the browser's back button works.

import { element } from "./dom.js";

const kKept = ["select", "watch", "at", "collapsed", "values", "span"];  // the parameters that stay when the user opens another view

export function currentRoute() {
  const match = location.hash.match(/^#\/([a-z]+)(?:\?(.*))?$/);
  return { view: match?.[1] ?? "cell", parameters: new URLSearchParams(match?.[2] ?? "") };
}

export function addressOf(view, parameters = {}) {
  const given = Object.entries(parameters).filter(([, value]) => value !== null && value !== undefined && value !== "");
  const text = new URLSearchParams(given).toString();
  return text ? `#/${view}?${text}` : `#/${view}`;
}

/// Makes every link to a view keep the selection, the watch list and the instant of the current address, unless the link has its own. A tab
/// opens its view as the user left it.
export function keepParameters() {
  const left = new Map();  // by view: its own parameters when the user left it
  document.addEventListener("click", (event) => {
    const link = event.target.closest?.('a[href^="#/"]');
    if (!link) return;
    const before = link.getAttribute("href");
    const [view, own] = before.slice(2).split("?");
    const route = currentRoute();
    const isKept = ([name]) => kKept.includes(name);
    left.set(route.view, [...route.parameters].filter((one) => !isKept(one)));
    const asLeft = link.role === "tab" ? left.get(view) ?? [] : [];
    link.href = addressOf(view, Object.fromEntries([...[...route.parameters].filter(isKept), ...asLeft, ...new URLSearchParams(own)]));
    setTimeout(() => link.setAttribute("href", before));  // the next click starts from another address
  }, true);
}

/// Creates a link that selects a module or device. The current view and its filters stay.
export function linkTo(name, text, attributes = {}) {
  return linkWith({ select: name }, text, attributes);
}

/// Creates a link that changes these parameters of the current view.
export function linkWith(parameters, text, attributes = {}) {
  const address = () => {
    const route = currentRoute();
    return addressOf(route.view, { ...Object.fromEntries(route.parameters), ...parameters });
  };
  return element("a", { ...attributes, href: address(), text, on: { click: (event) => { event.currentTarget.href = address(); } } });
}

export function go(view, parameters = {}) {
  location.hash = addressOf(view, parameters);
}

/// Changes some parameters of the current view's address. A parameter with the value null is removed.
export function alter(parameters) {
  const route = currentRoute();
  go(route.view, { ...Object.fromEntries(route.parameters), ...parameters });
}

/// Like alter(), but adds no entry to the browser's history.
export function adjust(parameters) {
  const route = currentRoute();
  const address = addressOf(route.view, { ...Object.fromEntries(route.parameters), ...parameters });
  history.replaceState(null, "", address);
}
