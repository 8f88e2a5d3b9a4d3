// Announces state changes to screen readers. Changes are collected and announced together, because each announcement interrupts the previous
// announcement.

const kEvery_ms = 1500;
const kNamed = 3;

export class Speaker {
  #element;
  #waiting = new Map();
  #timer = null;

  constructor(element) {
    this.#element = element;
  }

  take(news) {
    if (news.whole) return;
    for (const device of news.devices ?? []) {
      this.#waiting.set(device.name, `${device.name} ${device.gone ? "is gone" : device.alive ? device.state : "lost"}`);
    }
    for (const module of news.modules ?? []) {
      if (module.gone) continue;
      const why = module.text ? `, ${module.text}` : "";
      this.#waiting.set(module.name, `${module.name} ${module.state}${why}`);
    }
    if (this.#timer === null && this.#waiting.size > 0) this.#timer = setTimeout(() => this.#speak(), kEvery_ms);
  }

  #speak() {
    this.#timer = null;
    const all = [...this.#waiting.values()];
    this.#waiting.clear();
    const more = all.length > kNamed ? `; and ${all.length - kNamed} more` : "";
    this.#element.textContent = all.slice(0, kNamed).join("; ") + more;
  }
}
