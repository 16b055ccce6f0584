// A new job: a form made of the process's description, and what the job would take.
import {address, Estimate, Failure, get, Job, Process, ProcessSummary, send, TriangulationList} from "./api";
import {h, replace, say, show} from "./dom";
import {bytes, count, duration} from "./format";
import {action, Context, Figure, heading, Notice, Page} from "./page";
import {SchemaForm} from "./schema_form";

const pauseMs = 400;  // without typing, before the service is asked what it would take

function newKey(): string {
  return [...crypto.getRandomValues(new Uint32Array(4))].map(word => word.toString(16)).join("-");
}

export class SubmitPage implements Page {
  readonly title = "New job";
  readonly element: HTMLElement;
  private readonly notice = new Notice();
  private readonly about = h("p", {class: "muted"});
  private readonly place = h("div");
  private readonly choices = h("select", {id: "process", name: "process"});
  private readonly costs = new Costs();
  private process: Process | null = null;
  private form: SchemaForm | null = null;
  private timer = 0;
  private asking: AbortController | null = null;
  private key = newKey();  // sent again after an answer that was lost, the same form is the same job

  constructor(_context: Context, chosen: string, private readonly given: Record<string, string>) {
    const submit = action("Submit", () => this.submit(), {class: "primary", type: "submit"});
    const form = h("form", {class: "panel", novalidate: true, onsubmit: event => event.preventDefault()},
      h("div", {class: "field"}, h("label", {for: "process"}, "Process"), this.choices, this.about),
      this.place, h("div", {class: "actions"}, submit, h("a", {class: "button", href: "#/jobs"}, "Back to the jobs")));
    form.addEventListener("input", () => this.estimateSoon());
    this.choices.addEventListener("change", () => void this.choose(this.choices.value));
    this.element = h("div", {}, heading("New job"), this.notice.element, h("div", {class: "beside"}, form, this.costs.element));
    void this.notice.attempt(async () => {
      const list = await get<{processes: ProcessSummary[]}>(address("processes"));
      for (const each of list.processes) this.choices.append(h("option", {value: each.id}, each.title));
      this.choices.value = chosen;
      await this.choose(chosen);
    });
  }

  close(): void {
    clearTimeout(this.timer);
    this.asking?.abort();
  }

  private async choose(id: string): Promise<void> {
    await this.notice.attempt(async () => {
      this.process = await get<Process>(address("processes", id));
      say(this.about, this.process.description);
      this.form = new SchemaForm(this.process, this.given);
      replace(this.place, this.form.element);
      this.costs.clear();
      if ("triangulation" in this.process.inputs) {
        const made = await get<TriangulationList>(`${address("triangulations")}?limit=1000`);
        this.form.suggest("triangulation", made.triangulations.map(each => each.name));
      }
      show(this.costs.element, this.process.links.some(link => link.rel === "estimate"));
      this.estimateSoon();
    });
  }

  private estimateSoon(): void {
    this.key = newKey();
    clearTimeout(this.timer);
    this.asking?.abort();
    this.form?.forgive();
    if (!this.process?.links.some(link => link.rel === "estimate")) return;
    if (!this.form?.complete) return this.costs.clear();
    this.timer = window.setTimeout(() => void this.estimate(), pauseMs);
  }

  private async estimate(): Promise<void> {
    const asking = this.asking = new AbortController();
    this.costs.wait();
    try {
      const answer = await send("POST", address("processes", this.process!.id, "estimate"),
        {body: {inputs: this.form!.values()}, signal: asking.signal});
      this.costs.tell(await answer.json() as Estimate);
    } catch (error) {
      if (asking.signal.aborted || !(error instanceof Failure)) return;
      const told = this.form!.blame(error, false);
      this.costs.refuse(told ? "There is something wrong with the inputs." : error.message);
    }
  }

  private async submit(): Promise<void> {
    if (!this.form || !this.process) return;
    this.notice.clear();
    this.form.forgive();
    try {
      const answer = await send("POST", address("processes", this.process.id, "execution"),
        {body: {inputs: this.form.values()}, headers: {Prefer: "respond-async", "Idempotency-Key": this.key}});
      location.hash = `#/jobs/${(await answer.json() as Job).jobID}`;
    } catch (error) {
      if (!(error instanceof Failure && this.form.blame(error, true))) this.notice.tell(error);
    }
  }
}

// What the job would need.
class Costs {
  readonly element: HTMLElement;
  private readonly says = h("p", {role: "status"});
  private readonly list = h("dl", {class: "figures narrow"});
  private readonly figures = {
    time: new Figure("Time"), points: new Figure("Points"), cells: new Figure("Cells"), tiles: new Figure("Tiles"),
    memory: new Figure("Memory"), result: new Figure("Result"), temporary: new Figure("Disk while it runs")};

  constructor() {
    this.list.append(...Object.values(this.figures).map(figure => figure.element));
    this.element = h("aside", {class: "panel costs", "aria-label": "Estimate"}, h("h2", {}, "What the job would need"), this.says, this.list);
    this.clear();
  }

  private set(text: string, state: string, shown: boolean): void {
    say(this.says, text);
    this.says.dataset.state = state;
    this.list.classList.toggle("unknown", !shown);
    // What was told of other inputs is told to nobody any more, nor read aloud.
    if (!shown) for (const figure of Object.values(this.figures)) figure.set("–");
  }
  clear(): void { this.set("Fill in what is needed: time, memory and disk are shown here before anything is submitted.", "", false); }
  wait(): void { this.set("Asking …", "", false); }
  refuse(text: string): void { this.set(text, "failed", false); }

  tell(estimate: Estimate): void {
    // Of some jobs not all is known before.
    const known: [Figure, number, (value: number) => string][] = [
      [this.figures.time, estimate.seconds, seconds => `about ${duration(seconds)}`], [this.figures.points, estimate.points, count],
      [this.figures.cells, estimate.cells, cells => `about ${count(cells)}`], [this.figures.tiles, estimate.tiles, count],
      [this.figures.memory, estimate.memoryBytes, bytes], [this.figures.result, estimate.resultBytes, bytes],
      [this.figures.temporary, estimate.temporaryBytes, bytes]];
    for (const [figure, value, text] of known) {
      if (value > 0) figure.set(text(value));
      show(figure.element, value > 0);
    }
    if (estimate.accepted) this.set("This daemon would accept the job.", "successful", true);
    else this.set(estimate.reason ?? "This daemon would refuse the job.", "failed", true);
  }
}
