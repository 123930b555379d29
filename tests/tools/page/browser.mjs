// A report in headless Chromium: node browser.mjs MODULES CLAIM report.html OUTPUT
// Ends with status 0 where the claim holds. OUTPUT: a file or a folder that the claim writes.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { mkdtemp, rm } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";

const [modules, claim, report, output] = process.argv.slice(2);
const { chromium } = createRequire(path.join(modules, "package.json"))("playwright-core");

const profile = await mkdtemp(path.join(tmpdir(), "palpate-chromium-"));
const context = await chromium.launchPersistentContext(profile, {
  executablePath: "/usr/bin/chromium",
  viewport: { width: 1200, height: 900 },
  args: ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"].concat(
    ["--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  ),
});
const page = context.pages()[0];
const errors = [];
const requests = [];
page.on("console", (message) => message.type() === "error" && errors.push(message.text()));
page.on("pageerror", (error) => errors.push(error.stack));
page.on("request", (request) => requests.push(request.url()));

const canvas = page.locator("#body-view");
const text = (id) => page.locator(id).textContent();

async function open() {
  await page.goto(`file://${report}`);
  await page.locator(".panel[data-ready]").waitFor();
}

/** A point of the view, from 0 to 1 across and down. */
async function at(x, y) {
  const box = await canvas.boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

/** Waits until a readout satisfies the test. */
async function until(id, test) {
  for (let i = 0; i < 200; ++i) {
    if (test(await text(id))) return;
    await page.waitForTimeout(50);
  }
  assert.fail(`${id} stays "${await text(id)}"`);
}

/** Readouts of one frame that no longer change, however slow frames are. */
async function settled(...ids) {
  const read = () => page.evaluate((all) => all.map((id) => document.querySelector(id).textContent), ids);
  let last = await read();
  for (let i = 0, same = 0; i < 100; ++i) {
    await page.waitForTimeout(100);
    const now = await read();
    same = now.join() === last.join() ? same + 1 : 0;
    if (same >= 8) return now;
    last = now;
  }
  return assert.fail(`${ids} do not settle: ${last}`);
}

/** Where a tool can press: a place of the view at which the engine answers. */
async function touchable() {
  for (const [x, y] of [
    [0.5, 0.5],
    [0.5, 0.4],
    [0.45, 0.35],
    [0.55, 0.3],
    [0.5, 0.6],
  ]) {
    await page.mouse.move(...(await at(x, y)));
    await page.mouse.down();
    // As long as a busy machine takes: another place has its vertices elsewhere.
    let state = "";
    for (let i = 0; i < 100 && state !== "sticks" && state !== "slides"; ++i) {
      await page.waitForTimeout(50);
      state = await text("#poke-state");
    }
    await page.mouse.up();
    await until("#poke-state", (s) => s === "in the air" || s === "0");
    if (state === "sticks" || state === "slides") return [x, y];
  }
  return assert.fail("nothing can be touched");
}

const claims = {
  async opens_from_disk_without_error_or_request() {
    await open();
    await page.waitForTimeout(500);
    assert.deepEqual(errors, []);
    assert.deepEqual(
      requests.filter((url) => !url.startsWith("blob:") && !url.startsWith("data:")),
      [`file://${report}`],
    );
    assert.match(await text(".verdict"), /The force is off by [\d.]+ % in the median/);
  },

  async no_row_is_no_number() {
    await open();
    const words = await text("#error");
    assert.doesNotMatch(words, /\b0\.0 %|unknown|null|NaN/);
    assert.match(words, /no row counts/);
    assert.match(words, /No force reaches 40 mN/);
    assert.match(words, /Poor: said of the asset.*Do this about it/);
    assert.doesNotMatch(await text(".verdict"), /\d %/);
    assert.deepEqual(errors, []);
  },

  async a_click_shows_the_curves_of_the_nearest_point() {
    await open();
    await canvas.scrollIntoViewIfNeeded();
    const seen = new Map();
    for (let i = 1; i < 12; ++i)
      for (let k = 1; k < 8; ++k) {
        await page.mouse.click(...(await at(i / 12, k / 8)));
        seen.set(await page.locator("#point-choice").inputValue(), await text("#point-detail p"));
      }
    assert.ok(seen.size >= 3, `clicks chose ${seen.size} points`);
    for (const [point, words] of seen) {
      const name = await page.locator(`#point-choice option[value="${point}"]`).textContent();
      assert.ok(words.startsWith(name.replace(" (dragged)", ":").split(" ")[0]), `${name}: ${words}`);
    }
    assert.ok((await page.locator("#point-detail svg.plot").count()) >= 3);
    assert.ok((await page.locator("#point-detail svg.plot circle.sample").count()) >= 5);
    assert.deepEqual(errors, []);
  },

  async grey_means_uncovered_only_beside_a_map() {
    await open();
    assert.doesNotMatch(await text("#body"), /not measured/);
    assert.deepEqual(errors, []);
  },

  async a_drag_is_recorded() {
    await open();
    await canvas.scrollIntoViewIfNeeded();
    await page.check("#poke-on");
    const [x, y] = await touchable();
    await page.mouse.move(...(await at(x, y)));
    await page.mouse.down();
    await page.waitForTimeout(500);
    for (const [dx, dy] of [
      [0.06, 0.02],
      [0.02, -0.05],
      [-0.04, 0.03],
    ])
      await page.mouse.move(...(await at(x + dx, y + dy)), { steps: 25 });
    await page.mouse.wheel(0, 200);
    await page.waitForTimeout(300);
    await page.mouse.up();
    await until("#poke-state", (s) => s === "in the air");
    const saved = page.waitForEvent("download");
    await page.click("#poke-save");
    await (await saved).saveAs(output);
    assert.deepEqual(errors, []);
  },

  async the_body_gives_way_under_the_tool() {
    await open();
    await canvas.scrollIntoViewIfNeeded();
    await page.check("#poke-on");
    const [x, y] = await touchable();
    const [px, py] = await at(x, y);
    const clip = { x: px - 40, y: py - 40, width: 80, height: 80 };
    await page.mouse.move(px, py);
    await until("#poke-dent", (s) => Number.parseFloat(s) === 0);
    await page.mouse.down();
    await until("#poke-dent", (s) => Number.parseFloat(s) > 1);
    // The dent follows the depth by as many frames as a busy machine takes.
    let [moved, pressed] = [0, 1];
    for (let i = 0; i < 10 && !(moved > 0.6 * pressed && moved < 1.3 * pressed); ++i)
      [moved, pressed] = (await settled("#poke-dent", "#poke-depth-now")).map(Number.parseFloat);
    const away = await page.locator("#poke-dent").getAttribute("data-from_tip_m");
    assert.ok(moved > 0.6 * pressed && moved < 1.3 * pressed, `${moved} mm of ${pressed}`);
    // The vertex that moves most is one under the tool: no farther from the tip than a cell of this mesh.
    assert.ok(Number(away) < 0.009, `${away} m from the tip`);
    const dented = await page.screenshot({ clip });
    for (const [dx, dy] of [[0.05, 0.02], [0.02, -0.04]]) {
      await page.mouse.move(...(await at(x + dx, y + dy)), { steps: 15 });
      await page.waitForTimeout(300);
      const there = Number(await page.locator("#poke-dent").getAttribute("data-from_tip_m"));
      assert.ok(there < 0.009, `${there} m from the tip after a drag`);
    }
    await page.mouse.up();
    await until("#poke-dent", (s) => Number.parseFloat(s) === 0);
    assert.notDeepEqual(await page.screenshot({ clip }), dented);
    if (output) await page.screenshot({ path: path.join(output, "after.png") });
    assert.deepEqual(errors, []);
  },

  async two_fingers_are_two_tools() {
    await open();
    await canvas.scrollIntoViewIfNeeded();
    await page.check("#poke-on");
    const [x, y] = await touchable();
    await page.mouse.move(...(await at(x, y)));
    await page.mouse.down();
    await until("#poke-state", (s) => s === "sticks" || s === "slides");
    const second = async (type, dx) => {
      const [clientX, clientY] = await at(x + dx, y);
      await canvas.evaluate((view, event) => view.dispatchEvent(new PointerEvent(event.type, event)), {
        ...{ type, clientX, clientY, bubbles: true, button: 0, pointerId: 77, pointerType: "touch" },
      });
    };
    await canvas.evaluate((view) => (view.setPointerCapture = () => {})); // no real pointer has that number
    await second("pointerdown", 0.06);
    await until("#poke-state", (s) => / and /.test(s) && !/air/.test(s));
    await until("#poke-force", (s) => s.split(" and ").every((force) => Number.parseFloat(force) > 0));
    await second("pointermove", 0.08);
    await page.waitForTimeout(300);
    await second("pointerup", 0.08);
    await until("#poke-state", (s) => s === "sticks" || s === "slides");
    await page.mouse.up();
    await until("#poke-state", (s) => s === "in the air");
    const saved = page.waitForEvent("download");
    await page.click("#poke-save");
    await (await saved).saveAs(output);
    assert.deepEqual(errors, []);
  },

  async keys_alone_reach_everything() {
    await open();
    const wanted = await page.evaluate(() => {
      const all = [...document.querySelectorAll("a, button, input, select, summary, canvas[tabindex], [tabindex='0']")];
      return all.filter((e) => e.checkVisibility()).map((e, i) => (e.dataset.stop = String(i)));
    });
    const reached = new Set();
    for (let i = 0; i < wanted.length + 3; ++i) {
      await page.keyboard.press("Tab");
      reached.add(await page.evaluate(() => document.activeElement?.dataset.stop));
    }
    for (const stop of wanted) assert.ok(reached.has(stop), await page.locator(`[data-stop="${stop}"]`).first().innerHTML());
    await page.locator("#poke-on").focus();
    await page.keyboard.press("Space");
    await canvas.focus();
    await page.keyboard.press("Space");
    await until("#poke-state", (s) => s === "sticks" || s === "slides");
    await until("#poke-depth-now", (s) => Number.parseFloat(s) >= 0.3);
    for (let i = 0; i < 6; ++i) await page.keyboard.press("ArrowRight");
    await until("#poke-depth-now", (s) => Number.parseFloat(s.split(",")[1]) > 0.05);
    await page.keyboard.press("Escape");
    await until("#poke-state", (s) => s === "in the air");
    await page.locator("#point-choice").focus();
    const before = await text("#point-detail p");
    await page.keyboard.press("End");
    await page.keyboard.press("Home");
    await page.keyboard.press("ArrowDown");
    assert.notEqual(await text("#point-detail p"), before);
    assert.deepEqual(errors, []);
  },

  async a_gamepad_presses_drags_and_turns() {
    await page.addInitScript(() => {
      const buttons = Array.from({ length: 17 }, () => ({ pressed: false, touched: false, value: 0 }));
      window.pad = { connected: true, mapping: "standard", axes: [0, 0, 0, 0], buttons };
      navigator.getGamepads = () => [null, window.pad];
    });
    await open();
    const set = (act) => page.evaluate(act);
    await page.evaluate(() => dispatchEvent(new Event("gamepadconnected")));
    assert.match(await text("#tool-message"), /right trigger presses/);
    await set(() => (window.pad.buttons[7].value = 0.6));
    await until("#poke-state", (s) => s === "sticks" || s === "slides");
    const range = Number(await page.locator("#poke-depth").getAttribute("max"));
    assert.ok(Math.abs(Number(await page.locator("#poke-depth").inputValue()) - 0.6 * range) < 0.01 * range);
    await until("#poke-depth-now", (s) => Number.parseFloat(s) > 0.4 * 1e3 * range);
    await set(() => (window.pad.axes[0] = 0.1)); // within what sticks rest at
    await page.waitForTimeout(300);
    assert.ok(Number.parseFloat((await text("#poke-depth-now")).split(",")[1]) < 0.05);
    await set(() => (window.pad.axes[0] = 1));
    await until("#poke-state", (s) => s === "slides");
    await set(() => (window.pad.axes[0] = 0));
    await set(() => (window.pad.buttons[7].value = 0));
    await until("#poke-state", (s) => s === "in the air");
    await set(() => (window.pad.buttons[0].pressed = true));
    await until("#poke-state", (s) => s === "sticks" || s === "slides");
    await set(() => (window.pad.buttons[0].pressed = false));
    await page.waitForTimeout(100);
    await set(() => (window.pad.buttons[0].pressed = true));
    await until("#poke-state", (s) => s === "in the air");
    const before = await canvas.screenshot();
    await set(() => (window.pad.axes[2] = 1));
    await page.waitForTimeout(300);
    await set(() => (window.pad.axes[2] = 0));
    assert.notDeepEqual(await canvas.screenshot(), before);
    assert.deepEqual(errors, []);
  },

  async the_sound_switch_plays_what_the_tool_feels() {
    // What is handed to the loudspeaker, whatever there is of one.
    await page.addInitScript(() => {
      window.heard = { samples: 0, peak: 0 };
      const copy = AudioBuffer.prototype.copyToChannel;
      AudioBuffer.prototype.copyToChannel = function (samples, ...rest) {
        window.heard.samples += samples.length;
        window.heard.peak = Math.max(window.heard.peak, ...samples.map(Math.abs));
        copy.call(this, samples, ...rest);
      };
    });
    await open();
    await page.check("#poke-on");
    const touch = async () => {
      await page.click("#poke-press");
      await until("#poke-state", (s) => s === "sticks" || s === "slides");
      await page.waitForTimeout(1000);
      await page.click("#poke-press");
      await until("#poke-state", (s) => s === "in the air");
      return page.evaluate(() => window.heard);
    };
    assert.equal((await touch()).samples, 0); // off at first
    await page.check("#poke-sound");
    const { samples, peak } = await touch();
    assert.ok(samples > 20000, `${samples} samples`); // at least half a second
    assert.ok(peak > 0 && peak < 0.2, `a smooth touch peaks at ${peak}`);
    await page.uncheck("#poke-sound");
    const until_off = await page.evaluate(() => window.heard.samples); // the air sounded until then
    assert.equal((await touch()).samples, until_off);
    assert.deepEqual(errors, []);
  },

  async recordings_are_drawn() {
    for (const [colorScheme, width] of [
      ["light", 1200],
      ["dark", 1200],
      ["light", 390],
    ]) {
      await page.setViewportSize({ width, height: 844 });
      await page.emulateMedia({ colorScheme });
      await page.goto(`file://${report}`);
      const pictures = page.locator("#recordings figure.recording");
      await pictures.first().waitFor();
      const words = await pictures.allTextContents();
      assert.equal(words.length, 3);
      assert.match(words[0], /b\.csv.*refused/);
      assert.match(words[1], /refused.*No signal was read/);
      assert.match(words[2], /a\.csv.*good.*contact 2\.0\d mm ±/);
      // The signal; of a sound one also the press and what the curve leaves, small against it.
      assert.deepEqual(await Promise.all([0, 1, 2].map((i) => pictures.nth(i).locator("svg.plot").count())), [2, 0, 3]);
      assert.ok((await pictures.nth(2).locator("rect.phase").count()) >= 3);
      assert.equal(await pictures.nth(2).locator("rect.contact").count(), 2);
      const box = async (name) => pictures.nth(2).locator(name).boundingBox();
      const [curve, contact] = [await box("svg:nth-child(2) polyline"), await box("svg:nth-child(2) rect.contact")];
      assert.ok(curve.width > 20 && curve.height > 20 && contact.x > 0);
      const wide = await page.evaluate(() => document.documentElement.scrollWidth);
      assert.ok(wide <= width, `${wide} px of content on a screen of ${width} px`);
      await page.screenshot({ path: path.join(output, `recordings-${colorScheme}-${width}.png`), fullPage: true });
    }
    assert.deepEqual(errors, []);
  },

  async both_schemes_and_narrow_screens_hold_it() {
    const grounds = [];
    for (const [colorScheme, width] of [
      ["light", 1200],
      ["dark", 1200],
      ["light", 390],
      ["dark", 390],
    ]) {
      await page.setViewportSize({ width, height: 844 });
      await page.emulateMedia({ colorScheme });
      await open();
      await page.waitForTimeout(300);
      const [scroll, ground] = await page.evaluate(() => [
        document.documentElement.scrollWidth,
        getComputedStyle(document.body).backgroundColor,
      ]);
      assert.ok(scroll <= width, `${scroll} px of content on a screen of ${width} px`);
      grounds.push(ground);
      await page.screenshot({ path: path.join(output, `${colorScheme}-${width}.png`), fullPage: true });
    }
    assert.equal(grounds[0], grounds[2]);
    assert.notEqual(grounds[0], grounds[1]);
    await page.emulateMedia({ media: "print" });
    assert.equal(await page.locator(".panel").isVisible(), false);
    assert.equal(await canvas.isVisible(), true);
    const printed = await page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    assert.equal(printed, grounds[0]); // also where the screen is dark
  },
};

let failed = false;
try {
  await claims[claim]();
} catch (error) {
  console.error(error.stack);
  failed = true;
}
await context.close();
await rm(profile, { recursive: true, force: true });
process.exit(failed ? 1 : 0);
