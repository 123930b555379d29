// The page: reads what `palpate report` wrote into it and builds its sections.

import { bodySection } from "./body-section";
import type { Contents } from "./contents";
import { PointSection } from "./curves";
import { html } from "./dom";
import { PathFigure } from "./paths";
import { provenanceSection, warningsSection } from "./provenance";
import { recordingsSection } from "./recordings";
import { statementSection, verdict } from "./statement";

function read(id: string): string {
  return document.getElementById(id)?.textContent ?? "";
}

function build(contents: Contents): void {
  document.title = `${contents.name} - Palpate`;
  const main = html("main", {});
  const header = html(
    "header",
    {},
    html("h1", {}, contents.name),
    html("p", { class: "verdict" }, ...verdict(contents)),
  );
  const points = contents.points?.name.length ? new PointSection(contents) : undefined;
  const paths = new PathFigure(contents);
  const body = contents.surface ? bodySection(contents, read("engine"), points, paths) : undefined;
  const sections = [
    contents.statement || contents.points ? statementSection(contents, paths.element) : undefined,
    warningsSection(contents),
    points?.element,
    recordingsSection(contents),
    provenanceSection(contents),
  ].filter((s) => s !== undefined);
  const links = sections.map((s) => html("a", { href: `#${s.id}` }, s.querySelector("h2")?.textContent ?? ""));
  main.append(header, ...(body ? [body] : []), html("nav", { "aria-label": "Sections" }, ...links), ...sections);
  document.body.append(main);
  points?.chooseFirst();
}

const contents = JSON.parse(read("contents")) as Contents;
if (contents.schema === "palpate-report") build(contents);
else
  document.body.append(
    html("main", {}, html("p", {}, "This page is empty: `palpate report DIR -o report.html` fills it.")),
  );
