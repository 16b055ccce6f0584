// The end of a job's log, and what is added to it.
import {address, get, JobEvent, send} from "./api";
import {h, replace, show} from "./dom";

const bytesKept = 64 << 10;  // of the log as it is; the file has all of it
const linesKept = 1000;

export class LogPanel {
  readonly element: HTMLElement;
  private readonly text = h("pre", {class: "log", tabindex: 0, "aria-label": "Log"});
  private readonly cut: HTMLElement;
  private lines: string[] = [];
  private heard: JobEvent[] = [];  // since the log was asked for: in what came of it or not
  private due = 0;

  constructor(private readonly job: string) {
    const whole = address("jobs", job, "log");
    this.cut = h("p", {class: "sub"}, "Only the end of the log is shown.");
    show(this.cut, false);
    this.element = h("section", {class: "panel", "aria-labelledby": "log-title"},
      h("div", {class: "heading"}, h("h2", {id: "log-title"}, "Log"),
        h("a", {class: "button quiet", href: whole, target: "_blank", rel: "noopener"}, "Whole log")),
      this.cut, this.text);
  }

  async load(): Promise<void> {
    this.heard = [];
    const answer = await send("GET", address("jobs", this.job, "log"), {headers: {Range: `bytes=-${bytesKept}`}});
    const text = await answer.text();
    const part = answer.status === 206 && text.length >= bytesKept - 3;
    this.lines = text.split("\n");
    if (part) this.lines.shift();  // half of one
    if (this.lines.at(-1) === "") this.lines.pop();
    const end = this.lines.slice(-this.heard.length - 1);
    for (const event of this.heard.splice(0)) {
      const at = end.findIndex(line => line.endsWith(` ${event.text}`));
      if (at < 0) this.lines.push(lineOf(event));
      else end.splice(0, at + 1);
    }
    show(this.cut, part);
    this.draw();
  }

  hear(event: JobEvent): void {
    if (event.kind !== "log" || event.text === undefined) return;
    this.heard.push(event);
    if (this.heard.length > linesKept) this.heard.shift();
    this.lines.push(lineOf(event));
    if (!this.due) this.due = requestAnimationFrame(() => this.draw());
  }

  private draw(): void {
    this.due = 0;
    if (this.lines.length > linesKept) {
      this.lines = this.lines.slice(-linesKept);
      show(this.cut, true);
    }
    // Who reads at its end stays there.
    const follows = this.text.scrollTop + this.text.clientHeight >= this.text.scrollHeight - 4;
    replace(this.text, this.lines.join("\n") || "Nothing yet.");
    if (follows) this.text.scrollTop = this.text.scrollHeight;
  }
}

function lineOf(event: JobEvent): string {
  return `${event.time ?? ""} ${event.text}`;
}

// What a job that is no triangulation has found.
export async function outcomeOf(job: string): Promise<unknown> {
  const results = await get<{outcome?: {value: unknown}}>(address("jobs", job, "results"));
  return results.outcome?.value;
}
