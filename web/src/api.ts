// The API of the service, as far as the dashboard asks it (docs/service.md; proto/service.proto names the fields).
import {sentence} from "./format";

export interface Link { href: string; rel: string; type?: string; title?: string }
export interface Problem { status: number; title: string; detail?: string; cause?: number; type: string }

export type State = "accepted" | "running" | "successful" | "failed" | "dismissed";

export interface NodeFigures {
  name: string; tiles: number; tilesTriangulated: number; tilesStored: number; memoryBytes: number; lost: boolean;
}
export interface Figures {
  elapsed: number; pointsTotal: number; pointsRouted: number; pointsTriangulated: number;
  tilesTotal: number; tilesTriangulated: number; tilesStored: number; tilesAsleep: number;
  updatesSent: number; updatesProcessed: number; pointsSent: number; memoryBytes: number; nodes?: NodeFigures[];
}

export interface Job {
  jobID: string; processID: string; status: State; message?: string; progress: number; created?: string;
  started?: string; finished?: string; updated?: string; phase?: string; eta?: number; submitter?: string;
  points: number; nodesLost: number; resumable: boolean; problem?: Problem; triangulation?: string;
  figures?: Figures; starts: number; links?: Link[];
}
export interface JobList { jobs: Job[]; links: Link[]; numberMatched: number }

export interface Layout {
  dimension: number; bounds: number[]; axis: number[]; place: number[]; below: number[]; above: number[];
}
// Points told, from parts of the map to others, the heaviest first; a part is a row of the layout, or -1-tile.
export interface Mail { from: number[]; to: number[]; points: number[] }
export interface Tiles {
  jobID: string; stages?: string; begunAgain: number; elapsed: number; busyThreads: number[]; busy: number; layout?: Layout;
  mail?: Mail;
}

export interface Estimate {
  points: number; cells: number; tiles: number; memoryBytes: number; resultBytes: number; temporaryBytes: number;
  seconds: number; accepted: boolean; reason?: string;
}

export interface Schema { type?: string; format?: string; enum?: unknown[]; minimum?: number; items?: Schema }
export interface ProcessInput { title: string; description?: string; minOccurs: number; schema: Schema }
export interface ProcessSummary { id: string; title: string; description: string; links: Link[] }
export interface Process extends ProcessSummary { inputs: Record<string, ProcessInput> }

export interface Triangulation {
  name: string; dimension: number; vertices: number; cells: number; tiles: number; bytes: number; digest?: string;
  created?: string; crs?: string; bounds: number[]; links: Link[]; tileset: boolean;
  unit?: string; heightUnit?: string;  // of coordinates and heights, where the coordinate system says
  live?: LiveInfo;  // of a live result; the other fields tell of its stored version
  heights?: number[];  // of 2D results that have some: the lowest and the highest
}
export interface LiveInfo { version: number; storedVersion: number; vertices: number; pointsAdded: number; pointsRemoved: number }
export interface TriangulationList { triangulations: Triangulation[]; links: Link[]; numberMatched: number }

export interface Export {
  name: string; bytes: number; files: number; created?: string; submitter?: string; processID?: string; jobID?: string; links: Link[];
}
export interface ExportList { exports: Export[]; links: Link[]; numberMatched: number }

// What jobs may read.
export interface Input {
  name: string; folder: boolean; bytes: number; modified?: string; format?: string; points?: number; bounds?: number[]; crs?: string; note?: string;
}
export interface InputList { folder: string; inputs: Input[]; links: Link[]; numberMatched: number }

export interface NodeInfo {
  name: string; id?: string; address?: string; threads: number; memoryBytes: number; memoryUsedBytes: number;
  state: string; seconds: number; silentMs: number; coordinator: boolean; tiles: number;
}
export interface Caller { name: string; role: "read" | "submit" | "admin" }

// Of a live result: `kind` is version, or stored when the files of the result have the version now.
export interface Made { version: number; added: number; removed: number; changed: {bounds: number[]}[]; everything: boolean }
export interface JobEvent { id: number; jobID: string; kind: string; status?: Job; text?: string; time?: string; made?: Made }

const base = new URL("../v1/", document.baseURI);

// Where something of the API stands. `segments` are encoded.
export function address(...segments: string[]): string {
  return new URL(segments.map(encodeURIComponent).join("/"), base).href;
}

// What went wrong, as a sentence. `status` 0: nobody answers. `field`: the first word, which may be the field that the
// sentence is about: "inputs: nothing is there", "tiles is no number".
export class Failure extends Error {
  readonly field: string | null;
  constructor(readonly status: number, private readonly detail: string) {
    super(sentence(detail));
    this.field = /^([a-z_]+)[ :[]/.exec(detail)?.[1] ?? null;
  }
  // To stand at that field.
  get atField(): string {
    return sentence(this.detail.replace(/^[a-z_]+: /, ""));
  }
}

export async function failure(answer: Response): Promise<Failure> {
  const fallback = `the service answers ${answer.status} ${answer.statusText}`;
  try {
    const problem = await answer.json() as Problem;
    const detail = problem.detail || problem.title || fallback;
    return new Failure(answer.status, detail);
  } catch {
    return new Failure(answer.status, fallback);
  }
}

// Called when the service does not know who asks.
let signedOut = (): void => undefined;
export function onSignedOut(then: () => void): void {
  signedOut = then;
}

export async function send(method: string, url: string, options: {body?: unknown; headers?: Record<string, string>;
  signal?: AbortSignal} = {}): Promise<Response> {
  const headers: Record<string, string> = {Accept: "application/json", ...options.headers};
  let body: string | undefined;
  if (options.body !== undefined) {
    headers["Content-Type"] = "application/json";
    body = JSON.stringify(options.body);
  }
  let answer: Response;
  try {
    answer = await fetch(url, {method, headers, body, signal: options.signal, credentials: "same-origin"});
  } catch (error) {
    if (options.signal?.aborted) throw error;
    throw new Failure(0, "the daemon cannot be reached");
  }
  if (answer.status === 401) signedOut();
  if (!answer.ok) throw await failure(answer);
  return answer;
}

export async function get<T>(url: string, signal?: AbortSignal): Promise<T> {
  return await (await send("GET", url, {signal})).json() as T;
}

// The page after `from`. Only its query counts: behind a proxy the service may know itself by another name than this page.
export function next(list: {links: Link[]}, from: string): string | null {
  const link = list.links.find(l => l.rel === "next");
  if (!link) return null;
  const url = new URL(from);
  url.search = new URL(link.href, from).search;
  return url.href;
}

export function ended(job: Job): boolean {
  return job.status === "successful" || job.status === "failed" || job.status === "dismissed";
}

// As the service decides it; it decides again when it is asked.
export function mayChange(caller: Caller, job: Job): boolean {
  return caller.role === "admin" || (caller.role === "submit" && caller.name === job.submitter);
}
