// What a job found that makes no triangulation: of verify what was proved, of export the files, of info what there is.
import {address, Job} from "./api";
import {h, replace, show} from "./dom";
import {bytes, words} from "./format";

// Where the name of a figure is no word.
const names: Record<string, string> = {left_out: "Cells left out"};

interface Written { path: string; bytes: number; xxh3: string }

export class Outcome {
  readonly element = h("section", {class: "panel", "aria-label": "Outcome"});
  constructor() { show(this.element, false); }

  tell(job: Job, value: unknown): void {
    if (value === undefined || value === null) return;
    const told = value as Record<string, unknown>;
    const files = job.triangulation && Array.isArray(told.written) ? told.written as Written[] : [];
    replace(this.element, h("h2", {}, "Outcome"),
      files.length ? h("ul", {class: "files"}, ...files.slice(0, 200).map(file => h("li", {},
        h("a", {href: fileAddress(job.triangulation!, file.path), download: true}, file.path),
        h("span", {class: "sub number"}, bytes(file.bytes))))) : null,
      table(told));
    show(this.element, true);
  }
}

// `path`: with slashes.
export function fileAddress(triangulation: string, path: string): string {
  return address("triangulations", triangulation, "files", ...path.split("/"));
}

// What is simple as figures, lists of sentences as lists, the rest as text.
function table(value: Record<string, unknown>): HTMLElement {
  const simple: HTMLElement[] = [], lists: HTMLElement[] = [], deep: Record<string, unknown> = {};
  for (const [key, each] of Object.entries(value)) {
    if (key === "written" || key === "event" || each === "") continue;
    if (Array.isArray(each) && each.length > 0 && each.every(one => typeof one === "string"))
      lists.push(h("h3", {}, words(key)), h("ul", {class: `sentences ${key}`}, ...each.map(one => h("li", {}, one))));
    else if (each === null || typeof each === "object") deep[key] = each;
    else simple.push(h("div", {class: "figure"}, h("dt", {}, names[key] ?? words(key)),
      h("dd", {class: "wraps"}, typeof each === "number" ? each.toLocaleString("en") : String(each))));
  }
  return h("div", {}, h("dl", {class: "figures"}, ...simple), ...lists,
    Object.keys(deep).length ? h("pre", {class: "log", tabindex: 0, "aria-label": "The whole outcome"}, JSON.stringify(deep, null, 2)) : null);
}
