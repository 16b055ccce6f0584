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
  const button = h("button", {type: "button", class: "quiet theme"});
  const tell = () => {
    const shown = {auto: "Auto", light: "Light", dark: "Dark"}[kind];
    say(button, shown);
    button.setAttribute("aria-label", `${shown} colours${kind === "auto" ? ", as the system has them" : ""}. Change`);
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
