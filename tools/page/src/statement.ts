// The error statement, first in words, then as pictures.

import { seriesColour } from "./colours";
import { type Contents, heldOutPaths } from "./contents";
import { details, figure, html, section, swatch } from "./dom";
import { errorPlot, type Series } from "./plot";
import { ask } from "./terms";
import { plain, quantity } from "./words";

/** One line on how wrong it is. */
export function verdict(contents: Contents): (string | HTMLElement)[] {
  if (contents.statement) return [contents.statement.verdict, " ", ask("accuracy")];
  if (!contents.files) return ["A set-up to look at: nothing has been simulated yet."];
  return ["This folder holds no error statement: how wrong these curves are is not known."];
}

/** Every compared row: its error over its force, and the just noticeable difference. */
function scatter(contents: Contents): HTMLElement | undefined {
  const all = heldOutPaths(contents);
  if (!all.length) return undefined;
  const paths = [...new Set(all.map(({ path }) => path))];
  const series = paths.map((name, k): Series => {
    const own = all
      .filter(({ path }) => path === name)
      .flatMap(({ point, rows }) => rows.map((row) => ({ point, ...row })));
    return {
      kind: own.length > 1000 ? "readings" : "dots",
      colour: seriesColour(k),
      x: own.map(({ force_N }) => force_N),
      y: own.map(({ error_N }) => error_N),
      titles: own.map(
        (row) => `${row.point}, ${plain(name)}: ${quantity(row.force_N, "N")}, off by ${quantity(row.error_N, "N")}`,
      ),
    };
  });
  return figure(
    "Every row: errors in the shaded area cannot be felt",
    errorPlot(
      "Error of each held-out row over its force, with the just noticeable difference",
      "force of the reference",
      "error",
      contents.jnd,
      series,
    ),
    html(
      "p",
      { class: "legend" },
      ...paths.map((path, k) => swatch(plain(path), seriesColour(k))),
      swatch("just noticeable", "", "jnd"),
      ask("just noticeable"),
    ),
  );
}

/** paths: the force along one of them, shown first. */
export function statementSection(contents: Contents, paths: HTMLElement): HTMLElement {
  const out = section("error", "Accuracy");
  const s = contents.statement;
  if (!s) {
    out.append(html("p", {}, "`palpate run`, or `palpate validate`, makes one from fresh experiments."));
    return out;
  }
  out.append(paths);
  const words = details("Rows, paths, causes and baselines", html("pre", { class: "scroll", tabindex: 0 }, s.words));
  const picture = scatter(contents);
  if (picture) words.append(html("div", { class: "figures" }, picture));
  out.append(words);
  return out;
}
