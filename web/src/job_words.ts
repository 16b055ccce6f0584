// What is said of a job, on all pages alike.
import {Job, ended, address, get, mayChange, Caller, send} from "./api";
import {confirmed, h, say} from "./dom";
import {duration, secondsBetween, sentence, words} from "./format";
import {plainPhase} from "./phases";

const stateWords = {accepted: "Waiting", running: "Running", successful: "Done", failed: "Failed", dismissed: "Stopped"};

export function stateWord(job: Job): string {
  return stateWords[job.status] ?? job.status;
}

const makes = ["triangulate", "region"];  // results
const ofWhat: Record<string, string> = {verify: "Proof of", export: "Export of", dem: "Raster of", contours: "Contour lines of", surface: "Surface of", alpha: "Alpha shape of", voronoi: "Voronoi cells of", density: "Density of", volume: "Volumes of", measure: "Measures of", hag: "Heights above", info: "Info on"};

// Of a result what it is called; of another job what it makes, of what.
export function nameOf(job: Job): string {
  if (makes.includes(job.processID)) return job.triangulation || job.jobID;
  return job.triangulation ? `${ofWhat[job.processID] ?? words(job.processID)} ${job.triangulation}` : words(job.processID);
}

export function makeState(): HTMLElement {
  return h("span", {class: "state"}, h("span", {class: "dot", "aria-hidden": "true"}), h("span", {}));
}

export function updateState(element: HTMLElement, job: Job): void {
  element.dataset.state = job.status;
  say(element.lastElementChild!, stateWord(job));
}

// "joining tiles, 42 %, about 12 s left"; of a job that has ended, how long it took.
export function progressWords(job: Job): string {
  if (job.status === "accepted") return "in the queue";
  if (job.status === "running") {
    const parts = [plainPhase(job.phase), `${job.progress} %`];
    if (job.eta) parts.push(`about ${duration(job.eta)} left`);
    return parts.filter(p => p !== "").join(", ");
  }
  if (job.status === "failed") return sentence(job.problem?.detail ?? job.message ?? "");
  const seconds = secondsBetween(job.started, job.finished);
  if (job.status === "dismissed") return job.started ? "can be resumed" : "before it began";
  return seconds === null ? "" : `in ${duration(seconds)}`;
}

export type Deed = "cancel" | "resume" | "remove";

export function deedsFor(caller: Caller, job: Job): Deed[] {
  if (!mayChange(caller, job)) return [];
  if (!ended(job)) return ["cancel"];
  return job.resumable ? ["resume", "remove"] : ["remove"];
}

// What has become of the job; null when it was not done after all.
export async function doIt(deed: Deed, job: Job): Promise<Job | null> {
  const url = address("jobs", job.jobID);
  if (deed === "resume") return await (await send("POST", `${url}/resume`)).json() as Job;
  const sure = deed === "cancel"
    ? await confirmed(`Stop ${nameOf(job)}?`, "What is done stays, and the job can be resumed.", "Stop the job")
    : await confirmed(`Forget ${nameOf(job)}?`,
      "The job is removed from the list, with its log, and cannot be resumed any more. A finished result stays.", "Forget the job");
  if (!sure) return null;
  // It may have ended while the question stood there: to stop it would be to forget it.
  if (deed === "cancel") {
    const now = await get<Job>(url);
    if (ended(now)) return now;
  }
  return await (await send("DELETE", url)).json() as Job;
}
