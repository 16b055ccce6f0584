// What every page is, and what it is given.
import {Caller} from "./api";
import {h, say} from "./dom";
import {Live} from "./live";

export interface Context {
  caller: Caller;
  live: Live;
  announce(text: string): void;  // to who listens to the page
}

export interface Page {
  title: string;
  element: HTMLElement;
  close(): void;
}

// One sentence about what went wrong; nothing is shown as long as there is none.
export class Notice {
  readonly element = h("p", {class: "notice", role: "alert"});
  constructor() { this.element.hidden = true; }

  clear(): void {
    this.element.hidden = true;
    say(this.element, "");
  }
  tell(error: unknown): void {
    this.element.hidden = false;
    say(this.element, error instanceof Error ? error.message : String(error));
  }
  // Does it; what goes wrong is told.
  async attempt<T>(what: () => Promise<T>): Promise<T | undefined> {
    try {
      const value = await what();
      this.clear();
      return value;
    } catch (error) {
      if (!(error instanceof DOMException && error.name === "AbortError")) this.tell(error);
      return undefined;
    }
  }
}

export function heading(title: string, ...beside: (Node | null)[]): HTMLElement {
  return h("div", {class: "heading"}, h("h1", {tabindex: -1}, title), h("div", {class: "actions"}, ...beside));
}

// While `button` does it, it cannot be pressed again.
export async function busy(button: HTMLButtonElement, what: () => Promise<unknown>): Promise<void> {
  button.setAttribute("aria-disabled", "true");
  try {
    await what();
  } finally {
    button.removeAttribute("aria-disabled");
  }
}

export function action(text: string, then: () => Promise<unknown>, attributes: Record<string, string> = {}): HTMLButtonElement {
  const button = h("button", {type: "button", ...attributes}, text);
  button.addEventListener("click", () => {
    if (button.getAttribute("aria-disabled") !== "true") void busy(button, then);
  });
  return button;
}

// A name and a value, for lists of figures. `value` may be written again.
export class Figure {
  readonly value = h("dd", {}, "–");
  readonly element: HTMLElement;
  constructor(name: string, text = "–") {
    this.element = h("div", {class: "figure"}, h("dt", {}, name), this.value);
    say(this.value, text);
  }
  set(text: string): void { say(this.value, text); }
}

export function emptyState(title: string, text: string, ...more: (Node | null)[]): HTMLElement {
  return h("div", {class: "empty"}, h("h2", {}, title), h("p", {}, text), ...more);
}
