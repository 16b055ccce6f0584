// A form made of the inputs of a process, as the service describes them: what is not filled in has the service's default.
import {Failure, Process, ProcessInput, Schema} from "./api";
import {h, say, show} from "./dom";
import {words} from "./format";
import {InputChooser} from "./input_list";

const first = ["inputs", "triangulation", "output", "dim", "memory"];  // what most jobs are about; the rest is folded away

// Where the name of an option is no word.
const labels: Record<string, string> = {dim: "Dimension", crs: "Coordinate system", output: "File name", class: "Classes",
  tile_points: "Points in a tile", without: "Points left out", stats: "Statistics", against_cgal: "Against CGAL", max_edge: "Longest edge", max_radius: "Largest circumradius",
  res: "Resolution", bbox: "Box", resolution: "Resolution (COPC only)"};

export class SchemaForm {
  readonly element = h("div", {class: "fields"});
  private readonly fields = new Map<string, Field>();

  constructor(process: Process, given: Record<string, string>) {
    const more = h("div", {class: "fields"});
    for (const [name, input] of Object.entries(process.inputs)) {
      // What makes a result reads none.
      const label = name === "output" && !("triangulation" in process.inputs) ? "Name of the result" : labels[name] ?? words(name);
      const field = new Field(name, label, input, given[name] ?? "");
      this.fields.set(name, field);
      const folded = input.minOccurs === 0 && !first.includes(name) && !given[name];
      (folded ? more : this.element).append(field.element);
    }
    if (more.childElementCount > 0)
      this.element.append(h("details", {class: "more"}, h("summary", {}, "More options"), more));
  }

  // Whether all that must be there is.
  get complete(): boolean {
    return [...this.fields.values()].every(field => !field.required || field.value() !== undefined);
  }

  values(): Record<string, unknown> {
    const values: Record<string, unknown> = {};
    for (const [name, field] of this.fields) {
      const value = field.value();
      if (value !== undefined) values[name] = value;
    }
    return values;
  }

  // Names to choose from, for a field that takes one of them.
  suggest(name: string, among: string[]): void {
    this.fields.get(name)?.suggest(among);
  }

  // What is wrong is said at the field that it is about: false when it is about none. `focus`: that field gets it.
  blame(error: Failure, focus: boolean): boolean {
    const field = this.fields.get(error.field ?? "");
    field?.blame(error.atField, focus);
    return field !== undefined;
  }
  forgive(): void {
    for (const field of this.fields.values()) field.blame("", false);
  }
}

class Field {
  readonly element: HTMLElement;
  readonly required: boolean;
  private readonly control: HTMLInputElement | HTMLTextAreaElement | HTMLSelectElement;
  private readonly wrong: HTMLElement;

  constructor(readonly name: string, label: string, input: ProcessInput, given: string) {
    this.required = input.minOccurs > 0;
    const id = `field-${name}`, schema = input.schema;
    const attributes = {id, name, "aria-describedby": `${id}-help ${id}-wrong`, required: this.required,
      autocomplete: "off", spellcheck: "false"};
    this.control = controlFor(schema, attributes);
    this.control.value = given;
    this.wrong = h("p", {class: "wrong", id: `${id}-wrong`});
    const chooser = name === "inputs" ? this.chooser() : null;
    show(this.wrong, false);
    this.element = h("div", {class: schema.type === "array" && name === "inputs" ? "field wide" : "field"},
      h("label", {for: id}, label, this.required ? h("span", {class: "muted"}, " (needed)") : null),
      this.control, h("p", {class: "help", id: `${id}-help`}, helpOf(input)), this.wrong, chooser);
  }

  // What is chosen is typed, one a line.
  private chooser(): HTMLElement {
    const lines = () => this.control.value.split("\n").map(line => line.trim()).filter(line => line !== "");
    const chooser = new InputChooser(name => lines().includes(name), (name, on) => {
      this.control.value = [...lines().filter(line => line !== name), ...(on ? [name] : [])].join("\n");
      this.control.dispatchEvent(new Event("input", {bubbles: true}));
    });
    this.control.addEventListener("input", () => chooser.refresh());
    return chooser.element;
  }

  value(): unknown {
    return valueOf(this.control.value, this.control.dataset.type ?? "", this.control.dataset.item ?? "");
  }

  suggest(among: string[]): void {
    const id = `${this.control.id}-names`;
    this.element.append(h("datalist", {id}, ...among.map(value => h("option", {value}))));
    this.control.setAttribute("list", id);
  }

  blame(sentence: string, focus: boolean): void {
    say(this.wrong, sentence);
    show(this.wrong, sentence !== "");
    if (sentence === "") return this.control.removeAttribute("aria-invalid");
    this.control.setAttribute("aria-invalid", "true");
    this.element.closest("details")?.setAttribute("open", "");
    if (focus) this.control.focus();
  }
}

function helpOf(input: ProcessInput): string {
  const list = input.schema.type !== "array" ? "" :
    input.schema.items?.type === "string" ? " One a line." : " Numbers, with commas between them.";
  return (input.description ?? "") + list;
}

function controlFor(schema: Schema, attributes: Record<string, string | boolean>) {
  const type = schema.type ?? "string";
  if (type === "boolean" || schema.enum) {
    const choices = schema.enum?.map(String) ?? ["true", "false"];
    const select = h("select", {...attributes, autocomplete: null, spellcheck: null}, h("option", {value: ""}, "Default"),
      ...choices.map(choice => h("option", {value: choice}, schema.enum ? choice : choice === "true" ? "Yes" : "No")));
    select.dataset.type = type;
    return select;
  }
  const control = type === "array" && schema.items?.type === "string"
    ? h("textarea", {...attributes, rows: 3})
    : h("input", {...attributes, type: "text", inputmode: type === "string" ? null : "decimal"});
  control.dataset.type = type;
  control.dataset.item = schema.items?.type ?? "";
  return control;
}

// What is no number is sent as it stands: the service has the sentence for it.
function numberOr(text: string): number | string {
  const value = Number(text);
  return text !== "" && Number.isFinite(value) ? value : text;
}

function valueOf(text: string, type: string, item: string): unknown {
  const trimmed = text.trim();
  if (trimmed === "") return undefined;
  if (type === "boolean") return trimmed === "true";
  if (type === "integer" || type === "number") return numberOr(trimmed);
  if (type !== "array") return trimmed;
  const parts = trimmed.split(item === "string" ? /\n/ : /[\s,;]+/).map(part => part.trim()).filter(part => part !== "");
  return item === "string" ? parts : parts.map(numberOr);
}
