// Which node of a cluster has how many of a job's tiles, and how far it is with them.
import {Job, NodeFigures} from "./api";
import {h, say, show} from "./dom";
import {bytes, count} from "./format";
import {PhaseRow, phaseNamed, phases} from "./phases";

interface Row { element: HTMLElement; update(node: NodeFigures, phase: PhaseRow): void }

export class JobNodes {
  private readonly body = h("tbody");
  private readonly rows: Row[] = [];
  readonly element = h("section", {class: "panel scrolls", tabindex: 0, "aria-label": "The nodes of this job, as a table"},
    h("table", {class: "nodes", "aria-label": "Nodes of this job"},
      h("thead", {}, h("tr", {}, ...["Node", "State", "Tiles done", "Memory"].map(name => h("th", {scope: "col"}, name)))), this.body));

  constructor() {
    show(this.element, false);
  }

  // What is known while it runs stays as it was last seen.
  update(job: Job): void {
    const nodes = job.figures?.nodes ?? [];
    if (nodes.length === 0) return;
    // A node keeps its place: others come after it.
    nodes.forEach((node, i) => {
      if (i === this.rows.length) {
        this.rows.push(make(node.name));
        this.body.append(this.rows[i]!.element);
      }
      this.rows[i]!.update(node, phaseNamed(job.phase) ?? phases[0]!);
    });
    show(this.element, true);
  }
}

function make(name: string): Row {
  const state = h("span", {class: "state"}, h("span", {class: "dot", "aria-hidden": "true"}), h("span"));
  const done = h("meter", {min: 0, "aria-label": `Tiles done by ${name}`}), words = h("span", {class: "sub number"});
  const memory = h("td", {class: "number"});
  const element = h("tr", {}, h("th", {scope: "row"}, name), h("td", {}, state), h("td", {}, done, words), memory);
  return {element, update: (node, phase) => {
    const tiles = node[phase.tiles];
    state.dataset.state = node.lost ? "gone" : "free";
    say(state.lastElementChild!, node.lost ? "lost" : "at work");
    element.classList.toggle("gone", node.lost);
    done.max = Math.max(1, node.tiles, tiles);
    done.value = tiles;
    say(words, node.lost ? `${count(node.tilesStored)} stored` : `${count(tiles)} of ${count(Math.max(node.tiles, tiles))} ${phase.tilesAre}`);
    say(memory, node.lost ? "–" : bytes(node.memoryBytes));
  }};
}
