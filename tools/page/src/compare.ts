// Several runs beside each other: their errors, what they cost, and what was set otherwise.

import { seriesColour } from "./colours";
import { type Contents, linesOf } from "./contents";
import { figure, html, section, swatch, table } from "./dom";
import { bars, plot } from "./plot";
import { shown } from "./provenance";
import { percent, plain, tick } from "./words";

type Compared = NonNullable<Contents["compared"]>;

/** Rows of a table: a name, then a text for each run. */
function figures(runs: Compared): string[][] {
  const row = (name: string, value: (run: Compared[number]) => string | number | undefined) => [
    name,
    ...runs.map((run) => String(value(run) ?? "")),
  ];
  const sections = runs.flatMap((run) => run.statement?.sections ?? []);
  const lines = new Map(
    sections.flatMap(({ name, title }) =>
      runs.flatMap(({ statement }) =>
        statement
          ? linesOf(statement, name).map(([line]) => [`${title}: ${plain(line)}`, { name, line }] as const)
          : [],
      ),
    ),
  );
  return [
    row("median error", (run) => run.statement && percent(run.statement.force_error.median_rel)),
    row("95th percentile", (run) => run.statement && percent(run.statement.force_error.p95_rel)),
    row("largest", (run) => run.statement && percent(run.statement.force_error.max_rel)),
    row("rows within the just noticeable", (run) => run.statement && percent(run.statement.force_error.within_jnd)),
    ...[...lines].map(([words, { name, line }]) =>
      row(`95th percentile, ${words}`, ({ statement }) => {
        const stated = statement && linesOf(statement, name).find(([other]) => other === line)?.[1];
        return stated && percent(stated.p95_rel);
      }),
    ),
    row("reference's own error", (run) => run.statement && percent(run.statement.reference_p95_rel)),
    row("held-out rows", (run) => run.statement?.rows),
    row("law of the curves", (run) => run.family),
    row("test points", (run) => run.points),
    row("rows fitted", (run) => run.rows),
    row("a tick on the machine that ran it", (run) => run.statement && tick(run.statement.tick_ns)),
    row("size of the asset", (run) => run.statement && `${(run.statement.asset_bytes / 1e3).toFixed(0)} kB`),
  ].filter((cells) => cells.slice(1).some((cell) => cell !== ""));
}

/** Settings that are not the same in all runs. */
function differences(runs: Compared): string[][] {
  const keys = [...new Set(runs.flatMap((run) => Object.keys(run.settings ?? {})))].sort();
  return keys
    .map((key) => [
      key.replaceAll("/", "."),
      ...runs.map((run) => {
        const setting = run.settings?.[key];
        return setting ? shown(setting) : "not set";
      }),
    ])
    .filter((cells) => cells.slice(2).some((cell) => cell !== cells[1]));
}

/** Error and stiffness over each number that is not the same in all runs, as in a study. */
function overParameters(runs: Compared): HTMLElement[] {
  const keys = [...new Set(runs.flatMap((run) => Object.keys(run.settings ?? {})))].sort();
  return keys.flatMap((key) => {
    const known = runs.flatMap((run) => {
      const setting = run.settings?.[key];
      if (!setting || !("numbers" in setting) || setting.numbers.length !== 1 || !run.statement) return [];
      return [{ ...run, at: setting.numbers[0], unit: setting.unit, statement: run.statement }];
    });
    if (known.length < 3 || new Set(known.map((run) => run.at)).size < 2) return [];
    const unit = known[0].unit;
    const label = `${key.replaceAll("/", ".")}${unit === "1" ? "" : ` [${unit}]`}`;
    const dots = (name: string, runsShown: typeof known, y: number[], axis: { label: string; scale?: number }) =>
      figure(
        `${name} over ${key.replaceAll("/", ".")}`,
        plot(`${name} over ${label}`, { label }, { ...axis, min: 0 }, [
          {
            kind: "dots",
            colour: seriesColour(0),
            x: runsShown.map((run) => run.at),
            y,
            titles: runsShown.map((run) => run.name),
          },
        ]),
      );
    const stiff = known.filter((run) => run.stiffness_N_m !== undefined);
    return [
      dots(
        "Error",
        known,
        known.map((run) => run.statement.force_error.p95_rel ?? Number.NaN),
        { label: "95th percentile of the error [%]", scale: 100 },
      ),
      ...(stiff.length
        ? [
            dots(
              "Stiffness",
              stiff,
              stiff.map((run) => run.stiffness_N_m ?? 0),
              { label: "force over depth, median [N/m]" },
            ),
          ]
        : []),
    ];
  });
}

const kMaxBeside = 12; // runs that a table and bars can show

export function compareSection(contents: Contents): HTMLElement | undefined {
  const runs = contents.compared;
  if (!runs) return undefined;
  const out = section("compare", "Comparison");
  const stated = runs.flatMap((run) => (run.statement ? [{ ...run, statement: run.statement }] : []));
  const parameters = overParameters(runs);
  if (parameters.length) out.append(html("div", { class: "figures" }, ...parameters));
  if (runs.length > kMaxBeside) return out;
  if (stated.length) {
    const errors = stated.map(({ name, statement: s }) => ({
      name: name.length > 16 ? `${name.slice(0, 15)}…` : name,
      median: s.force_error.median_rel,
      p95: s.force_error.p95_rel,
    }));
    const costs = stated.filter((run) => run.rows !== undefined);
    out.append(
      html(
        "div",
        { class: "figures" },
        figure("Error by run: median and 95th percentile", bars("Error by run", errors, contents.jnd.share)),
        ...(costs.length
          ? [
              figure(
                "Error against cost",
                plot(
                  "95th percentile of the error over the rows fitted",
                  { label: "rows simulated or measured", min: 0 },
                  { label: "95th percentile of the error [%]", scale: 100, min: 0 },
                  costs.map((run, k) => ({
                    kind: "dots",
                    colour: seriesColour(k),
                    x: [run.rows ?? 0],
                    y: [run.statement.force_error.p95_rel ?? Number.NaN],
                    titles: [run.name],
                  })),
                ),
              ),
            ]
          : []),
      ),
      html("p", { class: "legend" }, ...costs.map((run, k) => swatch(run.name, seriesColour(k)))),
    );
  }
  out.append(table(["figure", ...runs.map((run) => run.name)], figures(runs)));
  const other = differences(runs);
  if (other.length)
    out.append(html("h3", {}, "Different settings"), table(["key", ...runs.map((run) => run.name)], other));
  return out;
}
