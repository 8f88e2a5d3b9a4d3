// Reads the gateway's events for all tabs in which a browser shows the page. A browser opens at most six connections to a server, so streams
// of six tabs would leave none for a command. The browser runs one instance of this worker while a tab of the page is open.

import { Store } from "./store.js";
import { Stream } from "./stream.js";

const kAlive_ms = 1000;

const store = new Store();
// Each tab by its MessagePort: {hidden, ports, newest}, where `ports` are the ports that the tab plots, and `newest` those whose newest value
// it shows. A tab that crashes does not say that it leaves. It remains until the last tab is closed.
const tabs = new Map();

/// Sends an event to the visible tabs. Values of ports go to the tabs that show them, even if they are hidden, so that plots have no gaps.
function send(name, data) {
  for (const [to, { hidden, ports }] of tabs) {
    if ("port" in data ? ports.includes(data.port) : !hidden) to.postMessage([name, data]);
  }
}

const stream = new Stream((name, data) => {
  store.take(name, data);
  send(name, data);
}, (link, since) => {
  store.setLink(link, since);
  sendLink();
});

function sendLink() {
  send("link", { link: store.link, since: store.linkSince });
}

/// `news` are the ports that a tab did not show before. It needs all their values, even if another tab shows them.
function choose(news) {
  return stream.choose([...new Set([...tabs.values()].flatMap((tab) => tab.ports))], news);
}

/// Chooses the newest values of the ports that visible tabs show.
function chooseNewest() {
  const ports = [...new Set([...tabs.values()].flatMap((tab) => (tab.hidden ? [] : tab.newest)))].sort();
  for (const port of store.newest.keys()) if (!ports.includes(port)) store.newest.delete(port);
  if (ports.join() !== stream.newest.join()) stream.chooseNewest(ports);
}

onconnect = ({ ports: [tab] }) => {
  const about = { hidden: true, ports: [], newest: [] };
  tab.onmessage = async ({ data: { hidden, ports, newest, request, left } }) => {
    if (left) tabs.delete(tab);
    else tabs.set(tab, about);
    if (about.hidden && hidden === false) for (const event of store.events) tab.postMessage(event);
    about.hidden = hidden ?? about.hidden;
    about.newest = newest ?? about.newest;
    if (newest) tab.postMessage(["newest", { values: Object.fromEntries(store.newest) }]);
    chooseNewest();
    if (!ports) return;
    const news = ports.filter((port) => !about.ports.includes(port));
    about.ports = ports;
    const problems = await choose(news);
    tab.postMessage(["problems", { request, problems: problems.filter(({ port }) => !port || ports.includes(port)) }]);
  };
};
setInterval(sendLink, kAlive_ms);
stream.rest(false);
