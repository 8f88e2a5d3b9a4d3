// Reads the gateway's events for all tabs in which a browser shows the page. A browser opens at most six connections to a server, so streams
// of six tabs would leave none for a command. The browser runs one instance of this worker while a tab of the page is open.

import { Store } from "./store.js";
import { Stream } from "./stream.js";

const kAlive_ms = 1000;

const store = new Store();
// Each tab by its MessagePort: {hidden, ports}, where `ports` are the ports whose values the tab shows. A tab that crashes does not say that
// it leaves. It remains until the last tab is closed.
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

function choose() {
  return stream.choose([...new Set([...tabs.values()].flatMap((tab) => tab.ports))]);
}

onconnect = ({ ports: [tab] }) => {
  const about = { hidden: true, ports: [] };
  tab.onmessage = async ({ data: { hidden, ports, request, left } }) => {
    if (left) tabs.delete(tab);
    else tabs.set(tab, about);
    if (about.hidden && hidden === false) for (const event of store.events) tab.postMessage(event);
    about.hidden = hidden ?? about.hidden;
    if (!ports) return;
    about.ports = ports;
    const problems = await choose();
    tab.postMessage(["problems", { request, problems: problems.filter(({ port }) => !port || ports.includes(port)) }]);
  };
};
setInterval(sendLink, kAlive_ms);
stream.rest(false);
