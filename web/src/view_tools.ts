// What every view has: buttons on the picture, and how high heights are drawn.
import {h} from "./dom";
import {Slider} from "./view_slider";

const highest = 20;

interface Viewed { fit(): void; top(): void; exaggerate(times: number): void }

// Stands on the picture. `viewed`: what is seen, once it is.
export function viewButtons(viewed: () => Viewed | null): HTMLElement {
  const button = (text: string, title: string, then: (scene: Viewed) => void) => h("button", {type: "button", title, onclick: () => {
    const scene = viewed();
    if (scene) then(scene);
  }}, text);
  return h("div", {class: "view-buttons", role: "group", "aria-label": "Where to look from"},
    button("Fit", "The whole fills the picture", scene => scene.fit()), button("Top", "From above, north up", scene => scene.top()));
}

export function heightSlider(viewed: () => Viewed | null): HTMLElement {
  const tenth = (value: number) => Math.round(10 * Math.exp(value)) / 10;
  const slider: Slider = new Slider("heights", "Heights drawn", () => viewed()?.exaggerate(slider.value), times => times === 1 ? "as they are" : `${times} times as high`);
  slider.range(0, Math.log(highest), 0, tenth);
  return h("div", {class: "sliders"}, slider.element);
}
