// Pictures of pages in headless Chromium: the README's, a report's body, poked, or a part of a page
// by its CSS selector (its first pixels from the top), as the tutorial has them.
//   node tools/workshop/docs/make_picture.mjs build/release/tools/page out/report.html docs/tutorial/error.png '#error .figures'
//   node tools/workshop/docs/make_picture.mjs build/release/tools/page out/report.html docs/tutorial/recordings.png '#recordings' 640
//   node tools/workshop/docs/make_picture.mjs build/release/tools/page out/liver/report.html docs/page photographs
//   node tools/workshop/docs/make_picture.mjs build/release/tools/page out/report.html docs/tutorial/liver.jpg pressed
//   node tools/workshop/docs/make_picture.mjs build/release/tools/page out/liver/report.html FOLDER frames
//   python3 tools/workshop/docs/animate.py FOLDER docs/liver.webp    (the README's)
// "photographs" makes light.png, dark.png and phone.png of the page. The first folder is where the page was built, with npm's packages.
import { createRequire } from "node:module";
import path from "node:path";

const [modules, report, output] = process.argv.slice(2, 5).map((name) => path.resolve(name));
const part = process.argv[5];
const { chromium } = createRequire(path.join(modules, "package.json"))("playwright-core");
const browser = await chromium.launch({
  executablePath: "/usr/bin/chromium",
  args: ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-background-networking"],
});
const page = await browser.newPage({ viewport: { width: part ? 900 : 1200, height: 1000 }, colorScheme: "light" });
await page.goto(`file://${report}`);
if (part === "photographs") {
  for (const [name, width, height, colorScheme, place] of [
    ["light", 1200, 900, "light", "header"],
    ["dark", 1000, 800, "dark", "header"],
    ["phone", 390, 844, "light", "header"],
  ]) {
    await page.setViewportSize({ width, height });
    await page.emulateMedia({ colorScheme });
    await page.goto(`file://${report}`);
    await page.locator(".panel[data-ready]").waitFor();
    if (name === "light") await page.click("#poke-press");
    if (name === "dark") {
      await page.evaluate(() => (document.querySelector("#map-choice").closest("details").open = true));
      await page.selectOption("#map-choice", "stiffness_N_m");
      await page.click("#poke-press");
      await page.click("#side-view");
    }
    await page.evaluate((selector) => document.querySelector(selector).scrollIntoView(), place);
    await page.waitForTimeout(5000);
    await page.screenshot({ path: path.join(output, `${name}.png`) });
  }
  await browser.close();
  process.exit();
}
if (part && part !== "pressed" && part !== "frames") {
  await page.evaluate(() => {
    for (const folded of document.querySelectorAll("details")) folded.open = true;
  });
  await page.locator(part).first().scrollIntoViewIfNeeded();
  await page.waitForTimeout(2000);
  const height = process.argv[6];
  await page.locator(part).first().evaluate((element, height) => {
    if (height) Object.assign(element.style, { maxHeight: `${height}px`, overflow: "hidden" });
  }, height);
  await page.locator(part).first().screenshot({ path: output });
  await browser.close();
  process.exit();
}
await page.locator(".panel[data-ready]").waitFor();
await page.evaluate(() => {
  document.activeElement.blur();
  document.querySelector(".bench").scrollIntoView();
});
await page.waitForTimeout(500);
const clip = await page.locator(".bench").boundingBox();
if (part === "pressed") {
  await page.click("#poke-press");
  await page.waitForTimeout(7000);
  await page.screenshot({ path: output, clip });
  await browser.close();
  process.exit();
}
// Presses, then slides to and fro beside the tumour and lifts: stills, FOLDER/00.png on.
if (part === "frames") {
  const kFrames = 40;
  for (let frame = 0; frame < kFrames; ++frame) {
    await page.evaluate(
      ([frame, last]) => {
        const canvas = document.querySelector("#body-view");
        const box = canvas.getBoundingClientRect();
        canvas.setPointerCapture = () => {}; // a made-up pointer cannot be captured
        const s = Math.min(1, Math.max(0, frame - 6) / (last - 12));
        const at = {
          clientX: box.left + (0.34 + 0.13 * (1 - Math.cos(2 * Math.PI * s))) * box.width,
          clientY: box.top + (0.42 - 0.05 * Math.sin(2 * Math.PI * s)) * box.height,
        };
        const type = frame === 2 ? "pointerdown" : frame === last - 2 ? "pointerup" : "pointermove";
        canvas.dispatchEvent(new PointerEvent(type, { ...at, pointerId: 1, button: 0, bubbles: true }));
      },
      [frame, kFrames - 1],
    );
    await page.waitForTimeout(120);
    await page.screenshot({ path: path.join(output, `${String(frame).padStart(2, "0")}.png`), clip });
  }
}
await browser.close();
