// Dark or light: as the system is, unless somebody chose. The choice is this browser's.

const kKept = "takt-theme";

export function followTheme(select, changed) {
  const system = matchMedia("(prefers-color-scheme: dark)");
  const show = () => {
    const chosen = select.value;
    colours.clear();
    document.documentElement.dataset.theme = chosen === "system" ? (system.matches ? "dark" : "light") : chosen;
    changed();
  };
  select.value = localStorage.getItem(kKept) ?? "system";
  if (select.selectedIndex < 0) select.value = "system";
  select.addEventListener("change", () => {
    localStorage.setItem(kKept, select.value);
    show();
  });
  system.addEventListener("change", show);
  show();
}

const colours = new Map();

/// What canvases draw with: the colours of page.css as they are now.
export function colour(name) {
  if (!colours.has(name)) colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  return colours.get(name);
}
