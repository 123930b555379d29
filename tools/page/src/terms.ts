// Each term of the page in a sentence or two, behind a "?".

import { html } from "./dom";

const kTerms = {
  force: "What the body pushes back with on the tool, in newtons; 100 grams weigh about 1 N.",
  depth: "How far the surface under the tool is pressed in, along its normal.",
  contact:
    "A contact sticks while friction holds it, and slides when the sideways force exceeds what friction can hold.",
  lateral: "Along the surface: the force by friction, and how far the contact is pulled aside before it slides.",
  moved: "How far the vertex moves that moves most.",
  energy: "Stored: elastic energy in the body now. Dissipated: what friction has turned into heat in this touch.",
  ticks: "The engine answers 1000 times a second, as a haptic device asks it to; the picture follows as it can.",
  stiffness: "How much the force grows with depth: its slope in newtons per metre, at the depth that you choose.",
  "test points": "Places where the body was pressed, simulated or measured; the curves between them are interpolated.",
  "held-out points": "Places where the body was pressed only to compare: no curve was fitted to them.",
  accuracy:
    "The engine's force against fresh experiments, at places and on paths that no curve was fitted to. The 95th percentile is exceeded in one row of 20.",
  "set-up":
    "What the simulation was given: nodes that are held, the coarse mesh of the body, the window that is pressed, inclusions.",
} as const;

export type Term = keyof typeof kTerms;

let shown: HTMLElement | undefined;

function explain(button: HTMLElement, term: Term): void {
  if (!shown) {
    shown = html("div", { id: "term", popover: "auto", role: "note" });
    (document.querySelector("main") ?? document.body).append(shown);
  }
  shown.textContent = kTerms[term];
  const { left, bottom } = button.getBoundingClientRect();
  shown.style.left = `${Math.max(8, Math.min(left, innerWidth - 300))}px`;
  shown.style.top = `${Math.min(bottom + 4, innerHeight - 120)}px`;
  shown.showPopover();
}

/** A button that explains a term. */
export function ask(term: Term): HTMLElement {
  return html(
    "button",
    {
      type: "button",
      class: "ask",
      title: kTerms[term],
      "aria-label": `What does ${term} mean?`,
      click: ({ currentTarget }: { currentTarget: HTMLElement }) => explain(currentTarget, term),
    },
    "?",
  );
}
