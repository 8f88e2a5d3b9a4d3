// The address says what is shown: #/modules?select=robot.servo. So a view can be linked, and the back key works.

export function currentRoute() {
  const match = location.hash.match(/^#\/([a-z]+)(?:\?(.*))?$/);
  return { view: match?.[1] ?? "cell", parameters: new URLSearchParams(match?.[2] ?? "") };
}

export function addressOf(view, parameters = {}) {
  const given = Object.entries(parameters).filter(([, value]) => value !== null && value !== undefined && value !== "");
  const text = new URLSearchParams(given).toString();
  return text ? `#/${view}?${text}` : `#/${view}`;
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
