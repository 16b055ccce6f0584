// By what is coloured, to be chosen, and what the colours mean.
import {h, replace, say} from "./dom";
import {count, withUnit} from "./format";
import {classColour, className, Colouring, colourings, Colours, ramp} from "./view_colours";

// `then` is told what was chosen; height at first. `unit`: of heights.
export function colourPanel(colours: Colours, unit: string, then: (by: Colouring) => void): HTMLElement {
  const legend = h("div", {class: "legend-box", role: "status"});
  const has: Record<Colouring, boolean> = {height: true, class: colours.attributes.includes("classification"),
    intensity: colours.attributes.includes("intensity"), tile: true};
  const tell = (by: Colouring) => {
    then(by);
    replace(legend, ...legendOf(by, colours, unit));
  };
  const choices = colourings.filter(([id]) => has[id]).map(([id, text]) => choice("colouring", `by-${id}`, text, id === "height", () => tell(id)));
  tell("height");
  return h("section", {class: "panel", "aria-labelledby": "colour-title"}, h("h2", {id: "colour-title"}, "Colours"),
    h("fieldset", {class: "choices", "aria-labelledby": "colour-title"}, ...choices), legend);
}

export function choice(group: string, id: string, text: string, chosen: boolean, then: () => void): HTMLElement {
  const input = h("input", {type: "radio", name: group, id, onchange: then});
  input.checked = chosen;
  return h("div", {class: "choice"}, input, h("label", {for: id}, text));
}

function swatch(colour: number[]): HTMLElement {
  const box = h("span", {class: "swatch", "aria-hidden": "true"});
  box.style.background = `rgb(${colour.join(" ")})`;
  return box;
}

function legendOf(by: Colouring, colours: Colours, unit: string): HTMLElement[] {
  if (by === "class") return [h("ul", {class: "classes"}, ...colours.classes.map(n => h("li", {}, swatch(classColour(n)), className(n))))];
  if (by === "tile") return [h("p", {class: "sub"}, `${count(colours.tiles)} tiles, each of one colour`)];
  const bar = h("div", {class: "ramp", "aria-hidden": "true"});
  bar.style.background = `linear-gradient(to right, ${(by === "height" ? ramp : [[20, 20, 20], [250, 250, 250]]).map(c => `rgb(${c.join(" ")})`).join(", ")})`;
  const [low, high] = by === "height" ? colours.heights : [0, colours.intensityMax];
  const end = (value: number) => {
    const text = h("span", {class: "number"});
    say(text, withUnit(value, by === "height" ? unit : ""));
    return text;
  };
  return [bar, h("div", {class: "ramp-ends sub"}, end(low), end(high))];
}
