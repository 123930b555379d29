// The error statement, first in words, then as pictures.

import { seriesColour } from "./colours";
import { type Contents, heldOutPaths } from "./contents";
import { details, figure, html, section, swatch } from "./dom";
import { errorPlot, plot, type Series } from "./plot";
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

/** Errors at a placement round's new test points, over the number of points that predicted them. */
function costPlot(contents: Contents): HTMLElement | undefined {
  const placement = contents.placement;
  if (!placement) return undefined;
  const lines: [string, number[]][] = [
    ["median", placement.median_rel],
    ["95th percentile", placement.p95_rel],
  ];
  const most = Math.max(...placement.points);
  const jnd = contents.jnd.share;
  return figure(
    "Error against cost: new test points, predicted from those before",
    plot(
      "Error of the prediction at new test points over the number of test points",
      { label: "test points that predicted", min: 0, max: 1.04 * most },
      { label: "error [%]", scale: 100, min: 0 },
      [
        { kind: "line", look: "jnd", x: [0, 1.04 * most], y: [jnd, jnd] },
        ...lines.map(([, y], k): Series => ({ kind: "line", colour: seriesColour(k), x: placement.points, y })),
      ],
    ),
    html("p", { class: "legend" }, ...lines.map(([name], k) => swatch(name, seriesColour(k)))),
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
  const pictures = html("div", { class: "figures" });
  for (const picture of [scatter(contents), costPlot(contents)]) if (picture) pictures.append(picture);
  out.append(
    details("Rows, paths, causes and baselines", html("pre", { class: "scroll", tabindex: 0 }, s.words), pictures),
  );
  return out;
}
