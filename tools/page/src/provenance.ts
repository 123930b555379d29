// Provenance of the numbers: warnings, scene, versions, timings.

import { bytes, type Contents } from "./contents";
import { details, html, section, table } from "./dom";
import { digits, plain, quantity, tick } from "./words";

/** Statuses of rows and points that are not good, counted. */
function counts(contents: Contents): string[] {
  const out: string[] = [];
  const tally = (names: string[]) => {
    const found = new Map<string, number>();
    for (const name of names) if (name !== "good") found.set(name, (found.get(name) ?? 0) + 1);
    return [...found].map(([name, count]) => `${count} ${plain(name)}`).join(", ");
  };
  const { rows, points } = contents;
  const status = rows ? Array.from(bytes(rows.status), (code) => rows.status_names[code]) : [];
  const [badRows, badPoints] = [tally(status), tally(points?.status ?? [])];
  if (badRows) out.push(`Of ${status.length} rows, these were not used: ${badRows}.`);
  if (badPoints) out.push(`Of ${points?.name.length} test points: ${badPoints}.`);
  return out;
}

export function warningsSection(contents: Contents): HTMLElement | undefined {
  const all = [...counts(contents), ...contents.warnings];
  if (!all.length) return undefined;
  return section("warnings", "Notes and warnings", html("ul", {}, ...all.map((text) => html("li", {}, text))));
}

export function provenanceSection(contents: Contents): HTMLElement {
  const out = section("provenance", "Provenance");
  const facts: string[][] = [["page written by", contents.program]];
  if (contents.asset?.program) facts.push(["asset written by", contents.asset.program]);
  if (contents.family) facts.push(["law of the curves", contents.family]);
  const probe = contents.probe;
  if (probe) {
    const sizes = Object.entries(probe.values).map(
      ([key, v]) =>
        `${plain(key)} ${key.endsWith("angle") ? `${digits(v[0])} rad` : v.map((x) => quantity(x, "m")).join(", ")}`,
    );
    facts.push(["probe", [probe.shape, ...sizes, `friction ${digits(probe.friction, 2)}`].join(", ")]);
  }
  if (contents.statement) {
    facts.push(["a tick of the engine, on the machine that ran this", tick(contents.statement.tick_ns)]);
    facts.push(["size of the asset", `${(contents.statement.asset_bytes / 1e3).toFixed(0)} kB`]);
  }
  out.append(table(["fact", "value"], facts));
  if (contents.set_up?.scene) out.append(details("Scene", html("pre", {}, contents.set_up.scene)));
  return out;
}
