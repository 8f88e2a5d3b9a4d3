// Exports what the plots show: the values as a CSV table, and the drawing as a picture.

import { element } from "./dom.js";
import { colourOf, dashOf } from "./plot.js";
import { colour } from "./theme.js";

/// The values of the series from one time to another, in the columns that `takt plot --csv` writes.
export function csvOf(series, from, to) {
  const lines = new Map();
  series.forEach(({ rows, column, labels }, i) => {
    for (const row of rows.between(from, to)) {
      if (!lines.has(row[0])) lines.set(row[0], series.map(() => ""));
      lines.get(row[0])[i] = labels?.[row[column]] ?? row[column] ?? "";
    }
  });
  const times = [...lines.keys()].sort((a, b) => a - b);
  const cells = times.map((time) => [BigInt(Math.round(time * 1e3)) * 1000n, ((time - times[0]) / 1e3).toFixed(6), ...lines.get(time)]);
  return [["time_ns", "seconds", ...series.map(({ name }) => name)], ...cells].map((line) => `${line.join(",")}\n`).join("");
}

/// A PNG of the plots, one below the other, with the names of the series.
export function pictureOf(plots, series) {
  const [sharp, line] = [window.devicePixelRatio || 1, 20];
  const width = plots[0].element.clientWidth;
  const height = plots.reduce((sum, plot) => sum + plot.element.clientHeight, line * (series.length + 1));
  const canvas = element("canvas", { width: Math.round(width * sharp), height: Math.round(height * sharp) });
  const context = canvas.getContext("2d");
  context.scale(sharp, sharp);
  context.fillStyle = colour("page");
  context.fillRect(0, 0, width, height);
  context.font = `11px ${getComputedStyle(document.body).fontFamily}`;
  context.textBaseline = "middle";
  context.fillStyle = colour("text");
  let top = 0;
  for (const { element: plot } of plots) {
    const at = plot.getBoundingClientRect();
    for (const part of plot.querySelectorAll("canvas")) context.drawImage(part, 0, top, part.clientWidth, part.clientHeight);
    for (const label of plot.querySelectorAll(".dygraph-axis-label")) {
      const its = label.getBoundingClientRect();
      context.textAlign = label.classList.contains("dygraph-axis-label-y2") ? "left" : label.classList.contains("dygraph-axis-label-y") ? "right" : "center";
      context.fillText(label.textContent, { left: its.left, right: its.right, center: (its.left + its.right) / 2 }[context.textAlign] - at.left,
        top + (its.top + its.bottom) / 2 - at.top);
    }
    top += plot.clientHeight;
  }
  context.textAlign = "left";
  context.lineWidth = 2;
  for (const { title, index } of series) {
    top += line;
    context.strokeStyle = colour(colourOf(index));
    context.setLineDash(dashOf(index) ?? []);
    context.beginPath();
    context.moveTo(16, top);
    context.lineTo(48, top);
    context.stroke();
    context.fillText(title, 56, top);
  }
  return new Promise((done) => { canvas.toBlob(done, "image/png"); });
}

export function download(content, name) {
  const address = URL.createObjectURL(content);
  element("a", { href: address, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(address), 10000);
}
