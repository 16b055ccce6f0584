// A list of any length of which only the rows in sight are elements. All rows have one height, which the style sheet says
// (--row), so that nothing moves when rows come; it scrolls with the page.
import {h} from "./dom";

export interface Rows {
  readonly length: number;                       // all of them, also those that are not known yet
  key(at: number): string;                       // of the row; empty: not known yet
  make(at: number): HTMLElement;                 // its content
  update(at: number, element: HTMLElement): void;
  wanted(from: number, to: number): void;        // these rows are in sight
}

const margin = 8;  // rows beyond what is in sight

export class VirtualList {
  readonly element = h("div", {class: "rows", role: "rowgroup"});
  private shown = new Map<string, {element: HTMLElement; at: number; top: number}>();
  private due = 0;
  private readonly later = () => this.refresh();

  constructor(private readonly rows: Rows) {
    addEventListener("scroll", this.later, {passive: true});
    addEventListener("resize", this.later);
  }

  close(): void {
    removeEventListener("scroll", this.later);
    removeEventListener("resize", this.later);
    cancelAnimationFrame(this.due);
  }

  // Soon, once for many changes.
  refresh(): void {
    if (this.due) return;
    this.due = requestAnimationFrame(() => {
      this.due = 0;
      this.draw();
    });
  }

  // Rows came above the first: who reads further down keeps looking at the same.
  pushedDown(rows: number): void {
    if (this.element.getBoundingClientRect().top < 0) scrollBy(0, rows * this.height());
  }

  private height(): number {
    const style = getComputedStyle(this.element);
    return parseFloat(style.getPropertyValue("--row")) * parseFloat(getComputedStyle(document.documentElement).fontSize);
  }

  private draw(): void {
    if (!this.element.isConnected) return;
    const height = this.height(), length = this.rows.length;
    this.element.style.height = `${length * height}px`;
    const top = this.element.getBoundingClientRect().top;
    const from = Math.max(0, Math.min(length, Math.floor(-top / height) - margin));
    const to = Math.max(from, Math.min(length, Math.ceil((innerHeight - top) / height) + margin));
    const keys: string[] = [];
    for (let at = from; at < to; ++at) keys.push(this.rows.key(at) || `unknown ${at}`);
    const wanted = new Set(keys);
    for (const [key, row] of this.shown) {
      if (wanted.has(key) || row.element.contains(document.activeElement)) continue;
      row.element.remove();
      this.shown.delete(key);
    }
    let last: HTMLElement | null = null;
    keys.forEach((key, place) => {
      const at = from + place;
      const row = this.shown.get(key) ?? {element: this.rows.make(at), at: -1, top: -1};
      this.shown.set(key, row);
      this.rows.update(at, row.element);
      if (row.at !== at || row.top !== at * height) {
        row.at = at;
        row.top = at * height;
        row.element.style.transform = `translateY(${row.top}px)`;
        row.element.setAttribute("aria-rowindex", String(at + 2));  // 1 is the head
      }
      // In the order in which they are read and reached by Tab; what stands right is not moved, and keeps the focus.
      if (row.element.parentElement !== this.element || row.element.previousElementSibling !== last)
        this.element.insertBefore(row.element, last ? last.nextElementSibling : this.element.firstElementChild);
      last = row.element;
    });
    this.rows.wanted(from, to);
  }
}
