// Light, dark, or as the system has it.
import {h, say} from "./dom";

const kinds = ["auto", "light", "dark"] as const;
type Kind = typeof kinds[number];
const place = "tessera-theme";

// Storage may be refused: then the choice lasts as long as the page.
function stored(): Kind {
  try {
    const kind = localStorage.getItem(place);
    return kinds.find(k => k === kind) ?? "auto";
  } catch {
    return "auto";
  }
}

function apply(kind: Kind): void {
  if (kind === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = kind;
  dispatchEvent(new Event("theme"));
}

export function themeSwitch(): HTMLElement {
  let kind = stored();
  const word = h("span"), button = h("button", {type: "button", class: "quiet theme"}, h("span", {class: "of"}, "Colours: "), word);
  const tell = () => {
    say(word, {auto: "as the system", light: "light", dark: "dark"}[kind]);
    button.title = `Next: ${{auto: "light", light: "dark", dark: "as the system has them"}[kind]}`;
  };
  button.addEventListener("click", () => {
    kind = kinds[(kinds.indexOf(kind) + 1) % kinds.length];
    try {
      localStorage.setItem(place, kind);
    } catch { /* see above */ }
    apply(kind);
    tell();
  });
  apply(kind);
  tell();
  return button;
}
