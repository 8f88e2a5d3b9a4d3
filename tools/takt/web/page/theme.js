// Applies the dark or light theme: the user's choice, which the browser remembers, or else the theme of the system.

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

/// The value of a colour that page.css defines, in the current theme, for drawing on a canvas.
export function colour(name) {
  if (!colours.has(name)) colours.set(name, getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim());
  return colours.get(name);
}
