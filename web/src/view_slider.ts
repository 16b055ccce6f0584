// A number between two others, by mouse or keys.
import {h, say} from "./dom";

const steps = 1000;
const plain = (value: number) => value.toLocaleString("en", {maximumFractionDigits: 2, useGrouping: false});

export class Slider {
  readonly element: HTMLElement;
  private readonly input: HTMLInputElement;
  private readonly shown = h("span", {class: "number"});
  private low = 0;
  private high = 1;
  private exact = 0;  // between two steps of the input, too
  private curve: (value: number) => number = value => value;

  constructor(id: string, title: string, private readonly then: () => void, private readonly words: (value: number) => string = plain) {
    this.input = h("input", {type: "range", id, min: 0, max: steps, step: 1, oninput: () => {
      this.exact = this.low + (this.high - this.low) * Number(this.input.value) / steps;
      this.tell();
      this.then();
    }});
    this.element = h("div", {class: "slider"}, h("label", {for: id}, title), this.shown, this.input);
  }

  get value(): number { return this.curve(this.exact); }

  // `curve`: from what the slider is even in to the number.
  range(low: number, high: number, value: number, curve = this.curve): void {
    [this.low, this.high, this.curve] = [low, high, curve];
    this.set(value);
  }

  set(value: number): void {
    this.exact = Math.min(this.high, Math.max(this.low, value));
    this.input.value = String(Math.round((this.exact - this.low) / (this.high - this.low || 1) * steps));
    this.tell();
  }

  // As if somebody had.
  move(by: number): void {
    this.grow(by);
    this.then();
  }

  grow(by: number): void { this.set(this.exact + by); }

  private tell(): void {
    const words = this.words(this.value);
    say(this.shown, words);
    this.input.setAttribute("aria-valuetext", words);
  }
}
