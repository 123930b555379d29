// The error statement, first in words, then as pictures.

import { seriesColour } from "./colours";
import { type Contents, heldOutRows, linesOf, type Statement, type TorqueFigures } from "./contents";
import { details, figure, html, section, swatch, table } from "./dom";
import { bars, errorPlot, type Series } from "./plot";
import { ask } from "./terms";
import { counted, percent, plain, quantity, tick } from "./words";

/** One line on how wrong it is. */
export function verdict(contents: Contents): (string | HTMLElement)[] {
  if (contents.statement) return [contents.statement.verdict, " ", ask("accuracy")];
  if (!contents.files) return ["A set-up to look at: nothing has been simulated yet."];
  return ["This folder holds no error statement: how wrong these curves are is not known."];
}

function sentences(s: Statement, contents: Contents): string[] {
  const e = s.force_error;
  const { floor_N, share, moving, direction_deg } = contents.jnd;
  if (s.rows === 0) return s.advice;
  const out = [
    ...s.advice,
    `Compared at ${counted(s.probes, "held-out contact point", "held-out contact points")} in ` +
      `${counted(s.rows, "row", "rows")}; shares of the force are of the ${s.rows_above_floor} above ${quantity(s.floor_N, "N", 2)}.`,
    `Median ${quantity(e.median_N, "N")}, 95th percentile ${quantity(e.p95_N, "N")}, largest ${quantity(e.max_N, "N")} (${percent(e.max_rel)}).`,
    `The force's size: median ${percent(s.magnitude.median_rel)}, 95th percentile ${percent(s.magnitude.p95_rel)}; its direction: ` +
      `median ${degrees(s.direction_deg.median)}, 95th percentile ${degrees(s.direction_deg.p95)} degrees.`,
    s.unnoticed === null
      ? `No force reaches ${quantity(floor_N, "N", 2)}, the least that a person feels.`
      : `${percent(s.unnoticed, s.unnoticed < 1 ? 1 : 0)} of the rows are within what a person notices: force ${percent(share, 0)}, ` +
        `${percent(moving, 0)} of one that slides, and ${quantity(floor_N, "N", 2)}; direction ${direction_deg.toFixed(0)} degrees.`,
  ];
  if (s.interval.low_rel !== undefined && s.interval.high_rel !== undefined)
    out.push(
      `Forces of the body itself: 95 % within ${percent(s.interval.low_rel, 0)} to +${percent(s.interval.high_rel, 0)} of the asset's, ` +
        "by how well its material is known.",
    );
  if (s.reference_p95_rel !== null)
    out.push(`The reference's own estimated error is ${percent(s.reference_p95_rel)} at the 95th percentile.`);
  if (s.reference_p95_rel !== null && e.p95_rel !== null && s.reference_p95_rel > 0.5 * e.p95_rel)
    out.push(
      `This compares noise in part: at ${percent(s.within_reference, 0)} of the rows the error is within the reference's own.`,
    );
  const undamaged = linesOf(s, "baselines").find(([name]) => name === "undamaged")?.[1];
  if (undamaged)
    out.push(
      `Touches damage this body. Answered as if none ever did, the force is off by ${percent(undamaged.median_rel)} in the median and ` +
        `${percent(undamaged.p95_rel)} at the 95th percentile.`,
    );
  const shape = s.shape_error;
  if (shape.near && shape.all)
    out.push(
      `The surface is shown within ${percent(shape.near.median_rel)} of the depth (95th percentile ${percent(shape.near.p95_rel)}, ` +
        `${quantity(shape.near.p95_m, "m")}) within three contact radii of the tool, over the whole body within ` +
        `${percent(shape.all.p95_rel)} (95th percentile).`,
    );
  if (s.reference_failures > 0)
    out.push(
      `${counted(s.reference_failures, "reference row", "reference rows")} could not be solved and ${s.reference_failures === 1 ? "is" : "are"} left out.`,
    );
  return out;
}

const degrees = (angle_deg: number | null) => (angle_deg === null ? "-" : angle_deg.toFixed(1));

/** Every compared row: its error over its force, and the just noticeable difference. */
function scatter(contents: Contents): HTMLElement | undefined {
  const rows = heldOutRows(contents);
  if (!rows.length) return undefined;
  const paths = [...new Set(rows.map(({ path }) => path))];
  const series = paths.map((path, k): Series => {
    const own = rows.filter((row) => row.path === path);
    return {
      kind: "dots",
      colour: seriesColour(k),
      x: own.map(({ force_N }) => force_N),
      y: own.map(({ error_N }) => error_N),
      titles: own.map(
        (row) => `${row.point}, ${plain(path)}: ${quantity(row.force_N, "N")}, off by ${quantity(row.error_N, "N")}`,
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
    ),
  );
}

/** Errors of the torque about the grip, of every line that has one. */
function torqueTable(s: Statement): HTMLElement[] {
  const row = (name: string, e: Partial<TorqueFigures>) => [
    name,
    quantity(e.typical_Nm ?? null, "N m"),
    percent(e.median_rel ?? null),
    percent(e.p95_rel ?? null),
    quantity(e.median_Nm ?? null, "N m"),
    quantity(e.p95_Nm ?? null, "N m"),
  ];
  if (s.torque_at_handle.median_Nm === undefined) return [];
  const head = [
    `torque at a handle of ${quantity(s.handle_m, "m")}`,
    "typical",
    "median error",
    "95th percentile",
    "median error",
    "95th percentile",
  ];
  return [
    table(head, [
      row("all paths", s.torque_at_handle),
      ...s.sections.flatMap(({ name, title }) =>
        linesOf(s, name).flatMap(([line, e]) =>
          e.torque_at_handle ? [row(`${title}: ${plain(line)}`, e.torque_at_handle)] : [],
        ),
      ),
    ]),
  ];
}

export function statementSection(contents: Contents): HTMLElement {
  const out = section("error", "Accuracy");
  const s = contents.statement;
  if (!s) {
    out.append(html("p", {}, "`palpate run`, or `palpate validate`, makes one from fresh experiments."));
    return out;
  }
  const pictures = html("div", { class: "figures" });
  const rows = scatter(contents);
  if (rows) pictures.append(rows);
  const sections = s.sections
    .map(({ name, title }) => ({
      name,
      title: title.charAt(0).toUpperCase() + title.slice(1),
      lines: linesOf(s, name),
    }))
    .filter(({ lines }) => lines.length > 0);
  for (const { title, lines } of sections) pictures.append(figure(title, bars(title, lines, contents.jnd.share)));
  out.append(
    details(
      "Rows, paths, causes and baselines",
      html("ul", {}, ...sentences(s, contents).map((text) => html("li", {}, text))),
      pictures,
      html(
        "p",
        { class: "legend" },
        swatch("median", seriesColour(0)),
        swatch("95th percentile of the error as a share of the force", seriesColour(0), "p95"),
        swatch(`just noticeable, ${percent(contents.jnd.share, 0)}`, "", "jnd"),
        ask("just noticeable"),
        ...(sections.some(({ name }) => name === "baselines")
          ? [html("span", {}, "baselines "), ask("baselines")]
          : []),
      ),
      details(
        "Numbers",
        table(
          ["of", "rows", "median", "p95", "median", "p95", "size", "p95", "degrees", "p95", "unnoticed", "a tick"],
          sections.flatMap(({ title, lines }) =>
            lines.map(([name, e]) => [
              `${title}: ${plain(name)}`,
              String(e.rows),
              percent(e.median_rel),
              percent(e.p95_rel),
              quantity(e.median_N, "N"),
              quantity(e.p95_N, "N"),
              percent(e.magnitude.median_rel),
              percent(e.magnitude.p95_rel),
              degrees(e.direction_deg.median),
              degrees(e.direction_deg.p95),
              percent(e.unnoticed, 0),
              e.tick_ns ? tick(e.tick_ns) : "",
            ]),
          ),
        ),
        ...torqueTable(s),
      ),
    ),
  );
  return out;
}
