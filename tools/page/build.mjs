// Builds the page: node build.mjs SOURCE_DIR MODULES_DIR OUTPUT.html [ENGINE.wasm]
import { readFile, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import path from "node:path";

const [source, modules, output, engine] = process.argv.slice(2);
const esbuild = createRequire(path.join(modules, "package.json"))("esbuild");

const common = {
  bundle: true,
  minify: true,
  write: false,
  target: "es2022",
  format: "iife",
  legalComments: "none",
  charset: "utf8",
  loader: { ".inc": "text" },
  nodePaths: [path.join(modules, "node_modules")],
};
const bundle = async (entry, plugins = []) => {
  const built = await esbuild.build({ ...common, entryPoints: [path.join(source, "src", entry)], plugins });
  return built.outputFiles[0].text;
};

const worker = await bundle("worker.ts");
const workerText = {
  name: "worker-source",
  setup(build) {
    build.onResolve({ filter: /^worker-source$/ }, () => ({ path: "worker", namespace: "worker-source" }));
    build.onLoad({ filter: /.*/, namespace: "worker-source" }, () => ({ contents: worker, loader: "text" }));
  },
};
const script = await bundle("main.ts", [workerText]);
const style = await esbuild.transform(await readFile(path.join(source, "style.css"), "utf8"), {
  loader: "css",
  minify: true,
});
const wasm = engine ? (await readFile(engine)).toString("base64") : "";

const page = await readFile(path.join(source, "page.html"), "utf8");
const parts = { STYLE: style.code.trim(), ENGINE: wasm, SCRIPT: script.trim().replaceAll("</script", "<\\/script") };
const license = "three.js is Copyright three.js authors, MIT licence.";
const filled = page.replace(/STYLE|ENGINE|SCRIPT/g, (name) => parts[name]);
await writeFile(output, filled.replace("<body>", `<body><!-- ${license} -->`));
console.log(`${output}: ${filled.length} bytes, engine ${wasm.length ? `${wasm.length} bytes` : "none"}`);
