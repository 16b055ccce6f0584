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
  private due = 0;

  constructor(private readonly job: string) {
    const whole = address("jobs", job, "log");
    this.cut = h("p", {class: "sub"}, "Only its end is shown.");
    show(this.cut, false);
    this.element = h("section", {class: "panel", "aria-labelledby": "log-title"},
      h("div", {class: "heading"}, h("h2", {id: "log-title"}, "Log"),
        h("a", {class: "button quiet", href: whole, target: "_blank", rel: "noopener"}, "All of it")),
      this.cut, this.text);
  }

  async load(): Promise<void> {
    const answer = await send("GET", address("jobs", this.job, "log"), {headers: {Range: `bytes=-${bytesKept}`}});
    const text = await answer.text();
    const part = answer.status === 206 && text.length >= bytesKept - 3;
    this.lines = text.split("\n");
    if (part) this.lines.shift();  // half of one
    if (this.lines.at(-1) === "") this.lines.pop();
    show(this.cut, part);
    this.draw();
  }

  hear(event: JobEvent): void {
    if (event.kind !== "log" || event.text === undefined) return;
    this.lines.push(`${event.time ?? ""} ${event.text}`);
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

// What a job that is no triangulation has found.
export async function outcomeOf(job: string): Promise<unknown> {
  const results = await get<{outcome?: {value: unknown}}>(address("jobs", job, "results"));
  return results.outcome?.value;
}
