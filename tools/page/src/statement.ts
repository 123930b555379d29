// The error statement in words.

import type { Contents } from "./contents";
import { details, html, section } from "./dom";
import { ask } from "./terms";

/** One line on how wrong it is. */
export function verdict(contents: Contents): (string | HTMLElement)[] {
  if (contents.statement) return [contents.statement.verdict, " ", ask("accuracy")];
  if (!contents.points && !contents.asset) return ["A set-up to look at: nothing has been simulated yet."];
  return ["This folder holds no error statement: how wrong these curves are is not known."];
}

/** paths: the force along one of them, shown first. */
export function statementSection(contents: Contents, paths: HTMLElement): HTMLElement {
  const out = section("error", "Accuracy");
  const s = contents.statement;
  if (!s) {
    out.append(html("p", {}, "`palpate run`, or `palpate validate`, makes one from fresh experiments."));
    return out;
  }
  const words = html("pre", { class: "scroll", tabindex: 0 }, s.words);
  out.append(paths, details("Rows, paths, causes and baselines", words));
  return out;
}
