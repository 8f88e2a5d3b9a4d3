// The web page of `takt web`. Events from the gateway fill a store, and the views show the data in the store. One view is visible at a
// time.

import { AlarmBar, Alarms } from "./alarms.js";
import { get, keepToken } from "./api.js";
import { arrows, element, Mark, setAttribute, setText, sign } from "./dom.js";
import { Details } from "./details.js";
import { Connections } from "./connections.js";
import { Faults } from "./faults.js";
import { Graph } from "./graph.js";
import { lookOfLink } from "./looks.js";
import { Modules } from "./modules.js";
import { Plots } from "./plots.js";
import { addressOf, alter, currentRoute, keepParameters } from "./route.js";
import { SharedStream } from "./shared_stream.js";
import { Speaker } from "./speaker.js";
import { Store } from "./store.js";
import { Stream } from "./stream.js";
import { Strip } from "./strip.js";
import { summaryOf } from "./summary.js";
import { Table } from "./table.js";
import { followTheme } from "./theme.js";
import { Tree } from "./tree.js";
import { Wall } from "./wall.js";
import { Watch } from "./watch.js";
import { clock } from "./words.js";

const byId = (name) => document.getElementById(name);
const store = new Store();
const speaker = new Speaker(byId("spoken"));
const alarms = new AlarmBar(byId("alarms"), store);
const details = new Details(byId("details"), store);
const tree = new Tree(byId("tree"), store);
const strip = new Strip(byId("strip"), store);
const narrow = matchMedia("(max-width: 900px)");  // the tree and the details are sheets
const views = {
  cell: { title: "Cell", view: new Graph(store) },
  modules: { title: "Modules", view: new Modules(store) },
  connections: { title: "Connections", view: new Connections(store) },
  alarms: { title: "Alarms", view: new Alarms(store) },
  faults: { title: "Faults", view: new Faults(store) },
  table: { title: "Table", view: new Table(store) },
  plots: { title: "Plots", view: new Plots(store) },
  watch: { title: "Watch", view: new Watch(store) },
};
const wall = new URLSearchParams(location.search).has("wall") ? { title: "Cell", view: new Wall(store) } : null;
document.body.classList.toggle("wall", wall !== null);
let shown = null;

function showRoute() {
  if (keepToken()) askRights();  // the user opened an address with a token in a tab that already shows the page
  const route = currentRoute();
  const name = Object.hasOwn(views, route.view) ? route.view : "cell";
  const { view, title } = wall ?? views[name];
  if (shown !== view) {
    shown?.hide?.();
    byId("view").replaceChildren(view.element);
    shown = view;
  }
  const selected = wall ? null : route.parameters.get("select");
  byId("details-button").hidden = !selected;
  view.show(route.parameters);
  details.show(selected);
  tree.show();
  strip.show();
  if (narrow.matches) {
    fold("tree", true);
    fold("details", false);
  } else showFolds();
  for (const tab of byId("tabs").children) {
    const is = tab.dataset.view === name;
    setAttribute(tab, "aria-selected", String(is));
    setAttribute(tab, "tabindex", is ? "0" : "-1");
    if (is) tab.scrollIntoView({ block: "nearest", inline: "center" });
  }
  byId("view").setAttribute("aria-labelledby", `tab-${name}`);
  document.title = `${title} - ${store.cell?.cell ?? "Takt"}`;
}

function makeTabs() {
  for (const [name, { title }] of Object.entries(views)) {
    byId("tabs").append(element("a", {
      role: "tab", id: `tab-${name}`, title: `key ${byId("tabs").children.length + 1}`, href: addressOf(name), text: title, "aria-controls": "view", dataset: { view: name },
    }));
  }
  arrows(byId("tabs"), "a", { across: true, chosen: (tab) => tab.click() });
}

/// A folded column stays folded on this computer. On a narrow screen, where the columns are sheets, each selection begins anew.
const isFolded = (name) => (localStorage.getItem(`takt-${name}`) ?? (name === "tree" && innerWidth < 1280 ? "folded" : "")) === "folded";

function fold(name, folded) {
  if (!narrow.matches) localStorage.setItem(`takt-${name}`, folded ? "folded" : "open");
  byId(name).classList.toggle("folded", folded);
  setAttribute(byId(`${name}-button`), "aria-expanded", String(!folded));
}

function showFolds() {
  for (const name of ["tree", "details"]) {
    byId(name).classList.toggle("folded", isFolded(name));
    setAttribute(byId(`${name}-button`), "aria-expanded", String(!isFolded(name)));
  }
}

function findInTree() {
  fold("tree", false);
  tree.filter.focus();
  tree.filter.select();
}

const link = new Mark();
const rights = new Mark();
const summary = new Mark();
byId("link").replaceChildren(link.element);
byId("rights").replaceChildren(rights.element);
byId("summary").replaceChildren(summary.element);

function showHeader(changes) {
  setText(byId("cell-name"), store.cell?.cell ?? "Takt");
  summary.show(summaryOf(store));
  if (changes.link) showLink();
  if (changes.rights) {
    const { command, why } = store.rights;
    rights.show({ look: command ? "good" : "faint", sign: command ? "good" : "note", word: command ? "may command" : `read-only${why.includes("is wrong") ? `: ${why}` : ""}` });
    setAttribute(byId("rights"), "title", why);
  }
}

function showLink() {
  link.show(lookOfLink(store.link));
  const stale = store.link === "lost" || store.link === "quiet";
  document.body.classList.toggle("stale", stale);
  const banner = byId("stale");
  banner.hidden = !stale;
  if (!stale) return;
  const what = store.link === "lost" ? "The connection to takt web has been lost" : "takt web has sent nothing";
  banner.replaceChildren(sign("lost"), `${what} since ${clock(store.linkSince)}; reconnecting. The page shows the last known state.`);
}

async function askRights() {
  try {
    store.setRights(await get("api/rights"));
  } catch (problem) {
    store.setRights({ command: false, why: problem.text });
  }
}

function take(name, data) {
  if (name === "state") speaker.take(data);
  store.take(name, data);
}

function follow(link, since) {
  store.setLink(link, since);
  if (link === "live") askRights();
}

/// Reads the stream that all tabs share, or, if the browser has no shared workers, a stream of this page alone.
function listen() {
  let stream;
  const begin = (made) => {
    stream = made;
    stream.rest(document.hidden);
  };
  const alone = () => begin(new Stream(take, follow));
  if (globalThis.SharedWorker) begin(new SharedStream(take, follow, alone));
  else alone();
  store.ports.choose = (ports) => stream.choose(ports);
  store.chooseNewest = (ports) => stream.chooseNewest(ports);
  document.addEventListener("visibilitychange", () => stream.rest(document.hidden));
}

store.listen((changes) => {
  if (changes.cell) store.ports.ask();  // the new cell may have ports that the former one did not have
  showHeader(changes);
  if (changes.alarms) alarms.update();
  shown?.update(changes);
  tree.update(changes);
  strip.update(changes);
  details.update(changes);
  if (changes.cell) document.title = `${views[currentRoute().view]?.title ?? "Cell"} - ${store.cell?.cell ?? "Takt"}`;
});
keepToken();
keepParameters();
makeTabs();
for (const name of ["tree", "details"]) byId(`${name}-button`).addEventListener("click", () => fold(name, !byId(name).classList.contains("folded")));
narrow.addEventListener("change", showRoute);
followTheme(byId("theme"), () => {
  shown?.redraw?.();
  strip.show();
  details.redraw();
});
addEventListener("hashchange", showRoute);
addEventListener("keydown", (event) => {
  if (!wall && !event.ctrlKey && !event.altKey && !event.metaKey && !event.target.closest("input, select, dialog")) {
    const act = { "/": findInTree, t: () => strip.focus() }[event.key] ?? (() => byId("tabs").children[event.key - 1]?.click());
    if (event.key === "/") event.preventDefault();  // Firefox opens a search of its own
    act();
  }
  if (event.key === "Escape" && narrow.matches && !byId("tree").classList.contains("folded")) {
    fold("tree", true);
    return;
  }
  if (event.key !== "Escape" || event.target.closest("dialog") || !currentRoute().parameters.has("select")) return;
  const back = details.name;
  alter({ select: null });
  shown?.focusOn?.(back);
});
showRoute();
showLink();
listen();
