// The address says what is shown: #/modules?select=robot.servo. So a view can be linked, and the back key works.

import { element } from "./dom.js";

export function currentRoute() {
  const match = location.hash.match(/^#\/([a-z]+)(?:\?(.*))?$/);
  return { view: match?.[1] ?? "cell", parameters: new URLSearchParams(match?.[2] ?? "") };
}

export function addressOf(view, parameters = {}) {
  const given = Object.entries(parameters).filter(([, value]) => value !== null && value !== undefined && value !== "");
  const text = new URLSearchParams(given).toString();
  return text ? `#/${view}?${text}` : `#/${view}`;
}

/// To choose a module or device, beside the view and with the filters that there are when the link is followed.
export function linkTo(name, text, attributes = {}) {
  const address = () => {
    const route = currentRoute();
    return addressOf(route.view, { ...Object.fromEntries(route.parameters), select: name });
  };
  return element("a", { ...attributes, href: address(), text, on: { click: (event) => { event.currentTarget.href = address(); } } });
}

export function go(view, parameters = {}) {
  location.hash = addressOf(view, parameters);
}

/// The same view with some parameters changed; null takes one out.
export function alter(parameters) {
  const route = currentRoute();
  go(route.view, { ...Object.fromEntries(route.parameters), ...parameters });
}

/// As alter, without another step for the back key.
export function adjust(parameters) {
  const route = currentRoute();
  const address = addressOf(route.view, { ...Object.fromEntries(route.parameters), ...parameters });
  history.replaceState(null, "", address);
}
