// One job.
import {address, ended, get, Job, JobEvent} from "./api";
import {h, replace, say, show} from "./dom";
import {bytes, count, duration, moment, secondsBetween, sentence} from "./format";
import {JobGraphs} from "./job_graphs";
import {JobNodes} from "./job_nodes";
import {deedsFor, Deed, doIt, makeState, nameOf, progressWords, stateWord, updateState} from "./job_words";
import {LogPanel, outcomeOf} from "./log_panel";
import {Outcome} from "./outcome";
import {action, Context, Figure, heading, Notice, Page} from "./page";
import {phases, plainPhase} from "./phases";

const deedWords: Record<Deed, string> = {cancel: "Stop", resume: "Resume", remove: "Forget"};

export class JobPage implements Page {
  title = "Job";
  readonly element: HTMLElement;
  private readonly notice = new Notice();
  private readonly body = h("div");
  private readonly head = heading("Job");
  private readonly state = makeState();
  private readonly about = h("p", {class: "muted"});
  private readonly bar = h("progress", {max: 100, value: 0, "aria-label": "Progress"});
  private readonly words = h("p", {class: "progress-words"});
  private readonly steps = h("ol", {class: "steps", "aria-label": "Phases"}, ...phases.map(phase => h("li", {"data-phase": phase.name}, phase.words)));
  private readonly problem = h("p", {class: "notice", role: "alert"});
  private readonly figures = {
    points: new Figure("Points"), elapsed: new Figure("Time"), starts: new Figure("Started"), lost: new Figure("Nodes lost"),
    by: new Figure("Submitted by"), tiles: new Figure("Tiles triangulated"), asleep: new Figure("Tiles at rest"),
    stored: new Figure("Tiles stored"), sent: new Figure("Points between tiles"), memory: new Figure("Memory")};
  private readonly graphs: JobGraphs;
  private readonly nodes = new JobNodes();
  private readonly log: LogPanel;
  private readonly outcome = new Outcome();
  private readonly leave: () => void;
  private job: Job | null = null;
  private heard = false;
  private announced = "";
  private deeds = "";
  private seenTiles = 0;

  constructor(private readonly context: Context, private readonly id: string) {
    this.graphs = new JobGraphs(id);
    this.log = new LogPanel(id);
    show(this.problem, false);
    // Nothing of it before it is known which parts there are: what appears at once does not move.
    show(this.body, false);
    this.body.append(
      h("section", {class: "panel", "aria-label": "Progress"},
        h("div", {class: "status-line"}, this.state, this.words), this.bar, this.steps, this.problem, this.about,
        h("dl", {class: "figures"}, ...Object.values(this.figures).map(figure => figure.element))),
      this.nodes.element, this.graphs.element, this.outcome.element, this.log.element);
    this.element = h("div", {class: "job"}, this.head, this.notice.element, this.body);
    this.leave = context.live.listen(event => this.hear(event), () => this.load());
    this.load();
  }

  close(): void {
    this.leave();
    this.graphs.close();
  }

  private load(): void {
    void this.notice.attempt(async () => {
      this.heard = false;
      const job = await get<Job>(address("jobs", this.id));
      // What was heard meanwhile may be newer; if it is older, what is newer will be heard.
      if (!this.heard) this.update(job);
      await this.log.load();
    });
  }

  private hear(event: JobEvent): void {
    if (event.jobID !== this.id) return;
    if (event.status) {
      this.heard = true;
      this.update(event.status);
    }
    this.log.hear(event);
  }

  private update(job: Job): void {
    const before = this.job;
    this.job = job;
    this.title = nameOf(job);
    say(this.head.querySelector("h1")!, nameOf(job));
    document.title = `${nameOf(job)} · Tessera`;
    updateState(this.state, job);
    say(this.words, progressWords(job));
    this.bar.value = job.progress;
    this.bar.dataset.state = job.status;
    say(this.about, `${job.processID} · ${job.jobID} · submitted ${moment(job.created)}`);
    const failed = job.status === "failed";
    say(this.problem, failed ? sentence(job.problem?.detail ?? job.message ?? "") : "");
    show(this.problem, failed);
    if (failed) say(this.words, "");
    this.updateSteps(job);
    this.updateFigures(job);
    this.updateActions(job);
    this.announce(job);
    this.nodes.update(job);
    this.graphs.update(job);
    show(this.body, true);
    const isOther = job.processID !== "triangulate";
    if (isOther && job.status === "successful" && before?.status !== "successful")
      void this.notice.attempt(async () => this.outcome.tell(job, await outcomeOf(this.id)));
  }

  private updateSteps(job: Job): void {
    const triangulates = job.processID === "triangulate";
    show(this.steps, triangulates);
    const now = job.status === "successful" ? phases.length : phases.findIndex(phase => phase.name === job.phase);
    [...this.steps.children].forEach((step, i) => {
      step.classList.toggle("done", i < now);
      if (i === now && job.status === "running") step.setAttribute("aria-current", "step");
      else step.removeAttribute("aria-current");
    });
  }

  private updateFigures(job: Job): void {
    const f = job.figures, all = this.figures;
    // What is known while it runs stays as it was last seen.
    const triangulates = job.processID === "triangulate";
    if (f?.tilesTotal) this.seenTiles = f.tilesTotal;
    for (const name of ["tiles", "stored", "sent"] as const) show(all[name].element, triangulates && (this.seenTiles > 0 || !ended(job)));
    for (const name of ["asleep", "memory"] as const) show(all[name].element, triangulates && !ended(job));
    const points = job.points || f?.pointsTotal || 0;
    all.points.set(points ? count(points) : "–");
    show(all.points.element, triangulates || points > 0);
    if (f?.tilesTotal) {
      all.tiles.set(`${count(f.tilesTriangulated)} of ${count(f.tilesTotal)}`);
      all.asleep.set(count(f.tilesAsleep));
      all.stored.set(`${count(f.tilesStored)} of ${count(f.tilesTotal)}`);
      all.sent.set(count(f.pointsSent));
      all.memory.set(bytes(f.memoryBytes));
    } else if (job.status === "successful" && this.seenTiles) {
      for (const name of ["tiles", "stored"] as const) all[name].set(`${count(this.seenTiles)} of ${count(this.seenTiles)}`);
    }
    const seconds = f?.elapsed ?? secondsBetween(job.started, job.finished);
    all.elapsed.set(seconds === null || !job.started ? "–" : duration(seconds));
    all.lost.set(count(job.nodesLost));
    all.lost.value.classList.toggle("warns", job.nodesLost > 0);
    all.starts.set(job.starts === 0 ? "not yet" : job.starts === 1 ? "once" : `${job.starts} times`);
    all.by.set(job.submitter ?? "–");
  }

  private updateActions(job: Job): void {
    const deeds = deedsFor(this.context.caller, job);
    const told = `${deeds.join()} ${job.status} ${job.triangulation ?? ""}`;
    if (told === this.deeds) return;
    this.deeds = told;
    const made = job.status === "successful" && job.processID === "triangulate";
    replace(this.head.querySelector(".actions")!,
      made ? h("a", {class: "button primary", href: `#/results/${encodeURIComponent(job.triangulation ?? "")}`}, "Open the result") : null,
      made ? h("a", {class: "button", href: address("jobs", this.id, "report"), target: "_blank", rel: "noopener"}, "Report") : null,
      ...deeds.map(deed => action(deedWords[deed], () => this.notice.attempt(async () => {
        const now = await doIt(deed, job);
        if (now && deed === "remove") location.hash = "#/jobs";
        else if (now) this.update(now);
      }), deed === "resume" ? {class: "primary"} : {})));
  }

  // Not every step: who listens to the page hears of every tenth part, and of each change of state.
  private announce(job: Job): void {
    const part = Math.floor(job.progress / 10) * 10;
    const text = ended(job) ? `${stateWord(job)}. ${progressWords(job)}` : `${stateWord(job)}, ${plainPhase(job.phase)} ${part} %`;
    if (text === this.announced) return;
    if (this.announced !== "") this.context.announce(`${nameOf(job)}: ${text}`);
    this.announced = text;
  }
}
