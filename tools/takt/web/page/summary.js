// Summarizes the state of the whole cell in one sentence.

import { lookOfDevice } from "./looks.js";
import { listed, several } from "./words.js";

/// Returns {look, sign, word}; `word` is the sentence.
export function summaryOf(store) {
  const names = store.deviceNames;
  if (names.length === 0) {
    const where = store.cell ? ` on domain ${store.cell.domain}` : "";
    return { look: "faint", sign: "wait", word: `no devices found${where}` };
  }
  const devices = names.map((name) => ({ name, look: lookOfDevice(store.devices.get(name)), is: store.devices.get(name) }));
  const lost = devices.filter((device) => device.look.key === "lost" || device.look.key === "none");
  const failed = devices.filter((device) => device.look.key === "failed");
  const modules = [...store.modules.values()].filter((module) => module.state || module.about);
  const counted = modules.filter((module) => module.state?.state === "EXECUTING" && !store.isLost(module)).length;
  const recover = modules.filter((module) => module.state?.state === "RECOVER" && !store.isLost(module));
  const safe = modules.filter((module) => module.state?.state === "EXECUTING" && module.measures?.safe_stop && !store.isLost(module));
  const stopped = modules.filter((module) => store.shown(module).stopped);

  const trouble = [];
  if (lost.length > 0) trouble.push(`${listed(lost.map((device) => device.name))} lost`);
  if (failed.length > 0) trouble.push(`${listed(failed.map((device) => device.name))} failed`);
  if (recover.length > 0) trouble.push(`${listed(recover.map((module) => module.name))} in RECOVER`);
  const what = doing(devices);
  const words = modules.length > 0 ? `${counted} of ${several(modules.length, "module")} EXECUTING` : several(names.length, "device");
  const stops = [];
  if (stopped.length > 0) stops.push(`${listed(stopped.map((module) => module.name))} stopped`);
  if (safe.length > 0) stops.push(`${listed(safe.map((module) => module.name))} in a safe stop`);
  const word = [`${what}: ${words}`, ...trouble, ...stops].join(", ");
  if (trouble.length > 0) return { look: "bad", sign: lost.length > 0 ? "lost" : "recover", word };
  if (safe.length > 0 || counted < modules.length) return { look: "poor", sign: "poor", word };
  if (what !== "running") return { look: "plain", sign: "wait", word };
  return { look: "good", sign: "executing", word };
}

/// The states of the live devices: "running", or "running and preparing".
function doing(devices) {
  const states = new Set(devices.filter((device) => device.is?.alive).map((device) => device.is.state));
  if (states.size === 0) return "lost";
  return [...states].join(" and ");
}
