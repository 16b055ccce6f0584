// All jobs.
import {Job} from "./api";
import {h, replace, say, show} from "./dom";
import {count, moment} from "./format";
import {JobList} from "./job_list";
import {deedsFor, Deed, doIt, makeState, nameOf, progressWords, updateState} from "./job_words";
import {Context, emptyState, heading, Notice, Page} from "./page";
import {Rows, VirtualList} from "./virtual_list";

const filters: [string, string, string[]][] = [
  ["all", "All", []], ["active", "Active", ["accepted", "running"]], ["done", "Done", ["successful"]],
  ["failed", "Failed", ["failed"]], ["stopped", "Stopped", ["dismissed"]]];
const deedWords: Record<Deed, string> = {cancel: "Stop", resume: "Resume", remove: "Forget"};

export class JobsPage implements Page, Rows {
  readonly title = "Jobs";
  readonly element: HTMLElement;
  private readonly notice = new Notice();
  private readonly list = new VirtualList(this);
  private readonly counted = h("p", {class: "muted counted", role: "status"});
  private readonly table: HTMLElement;
  private readonly nothing = h("div");
  private readonly jobs: JobList;
  private readonly leave: () => void;

  constructor(private readonly context: Context, filter: string) {
    const chosen = filters.find(([id]) => id === filter) ?? filters[0];
    this.jobs = new JobList(chosen[2], above => this.changed(above));
    const submit = context.caller.role === "read" ? null : h("a", {class: "button primary", href: "#/submit"}, "New job");
    this.table = h("div", {class: "table jobs", role: "table", "aria-label": "Jobs"},
      h("div", {class: "head", role: "row", "aria-rowindex": 1},
        ...["State", "Job", "Progress", "Points", "By", "Since", "Actions"].map(name =>
          h("span", {role: "columnheader", class: `c-${name.toLowerCase()}`}, name))),
      this.list.element);
    this.element = h("div", {}, heading("Jobs", submit),
      h("nav", {class: "tabs", "aria-label": "Which jobs"}, ...filters.map(([id, text]) =>
        h("a", {href: id === "all" ? "#/jobs" : `#/jobs?show=${id}`, "aria-current": id === chosen[0] ? "page" : null}, text)),
        this.counted),
      this.notice.element, this.table, this.nothing);
    show(this.table, false);
    replace(this.nothing, chosen[0] === "all"
      ? emptyState("No jobs yet", "A job turns point clouds into a triangulation, proves one, or exports it.",
        submit ? h("a", {class: "button", href: "#/submit"}, "Submit the first one") : null)
      : emptyState("None of these", "No job is in this state now."));
    show(this.nothing, false);
    this.leave = context.live.listen(event => this.jobs.hear(event), () => this.load());
    this.load();
  }

  close(): void {
    this.leave();
    this.list.close();
  }

  private load(): void {
    void this.notice.attempt(() => this.jobs.reload());
  }

  private changed(above: number): void {
    say(this.counted, this.jobs.total === 1 ? "1 job" : `${count(this.jobs.total)} jobs`);
    this.table.setAttribute("aria-rowcount", String(this.jobs.total + 1));
    show(this.table, this.jobs.total > 0);
    show(this.nothing, this.jobs.loaded && this.jobs.total === 0);
    if (above) this.list.pushedDown(above);
    this.list.refresh();
  }

  get length(): number { return this.jobs.total; }
  key(at: number): string { return this.jobs.at(at)?.jobID ?? ""; }

  wanted(_from: number, to: number): void {
    void this.notice.attempt(() => this.jobs.extend(to));
  }

  make(at: number): HTMLElement {
    const cell = (name: string, ...content: (Node | string)[]) =>
      h("div", {role: "cell", class: `c-${name}`}, ...content);
    const job = this.jobs.at(at);
    return h("div", {class: "row", role: "row"},
      cell("state", makeState()),
      cell("job", h("a", {class: "name", href: job ? `#/jobs/${job.jobID}` : null}), h("span", {class: "sub"})),
      cell("progress", h("progress", {max: 100, value: 0, "aria-label": "Progress"}), h("span", {class: "sub"})),
      cell("points"), cell("by"), cell("since"), cell("actions"));
  }

  update(at: number, row: HTMLElement): void {
    const job = this.jobs.at(at);
    row.classList.toggle("unknown", !job);
    if (!job) return;
    const cell = (name: string) => row.querySelector<HTMLElement>(`.c-${name}`)!;
    updateState(cell("state").firstElementChild as HTMLElement, job);
    say(cell("job").firstElementChild!, nameOf(job));
    say(cell("job").lastElementChild!, `${job.processID} · ${job.jobID}`);
    const bar = cell("progress").firstElementChild as HTMLProgressElement;
    bar.value = job.progress;
    bar.classList.toggle("off", job.status !== "running");
    say(cell("progress").lastElementChild!, progressWords(job));
    cell("progress").title = job.status === "failed" ? progressWords(job) : "";
    const points = job.points || job.figures?.pointsTotal || 0;
    say(cell("points"), points ? count(points) : "–");
    say(cell("by"), job.submitter ?? "");
    say(cell("since"), moment(job.finished || job.started || job.created));
    this.updateActions(cell("actions"), job);
  }

  private updateActions(element: HTMLElement, job: Job): void {
    const deeds = deedsFor(this.context.caller, job).slice(0, 1);
    if (element.dataset.deeds === deeds.join()) return;
    element.dataset.deeds = deeds.join();
    replace(element, ...deeds.map(deed => {
      const button = h("button", {type: "button", class: "quiet", "aria-label": `${deedWords[deed]} ${nameOf(job)}`}, deedWords[deed]);
      button.addEventListener("click", () => void this.notice.attempt(async () => {
        const now = await doIt(deed, job);
        if (now && deed === "remove") this.jobs.forget(job.jobID);
        else if (now) this.jobs.put(now);
      }));
      return button;
    }));
  }
}
