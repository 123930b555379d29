// A report in headless Chromium: node browser.mjs MODULES CLAIM report.html OUTPUT
// Ends with status 0 where the claim holds. OUTPUT: a file or a folder that the claim writes.
import assert from "node:assert/strict";
import { createRequire } from "node:module";
import { mkdtemp, readFile, rm, writeFile } from "node:fs/promises";
import { tmpdir } from "node:os";
import path from "node:path";

const [modules, claim, report, output] = process.argv.slice(2);
const fromModules = createRequire(path.join(modules, "package.json"));
const { chromium } = fromModules("playwright-core");

const profile = await mkdtemp(path.join(tmpdir(), "palpate-chromium-"));
const context = await chromium.launchPersistentContext(profile, {
  executablePath: "/usr/bin/chromium",
  viewport: { width: 1200, height: 900 },
  args: ["--no-sandbox", "--disable-gpu", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic"].concat(
    ["--no-first-run", "--disable-background-networking", "--disable-component-update", "--disable-sync"],
  ),
});
const page = context.pages()[0];
page.setDefaultTimeout(180000); // a claim holds on a slow machine, too
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

/** Opens all that is folded away. */
async function unfold() {
  await page.evaluate(() => {
    for (const folded of document.querySelectorAll("details")) folded.open = true;
  });
}

/** A point of the view, from 0 to 1 across and down. */
async function at(x, y) {
  const box = await canvas.boundingBox();
  return [box.x + x * box.width, box.y + y * box.height];
}

/** Waits until a readout satisfies the test, as long as a busy machine takes. */
async function until(id, test) {
  for (let i = 0; i < 600; ++i) {
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

/** Waits until the page has drawn so many times. */
async function frames(count) {
  await page.evaluate(async (n) => {
    for (let i = 0; i < n; ++i) await new Promise(requestAnimationFrame);
  }, count);
}

/** Waits until the view is another picture. */
async function changed(before) {
  for (let i = 0; i < 100; ++i) if (!(await canvas.screenshot()).equals(before)) return;
  assert.fail("the view stays as it was");
}

/** Schemes of colour and widths of a screen [px]. */
const kLooks = [
  ["light", 1200],
  ["dark", 1200],
  ["light", 390],
  ["dark", 390],
];

async function lookAt([colorScheme, width]) {
  await page.setViewportSize({ width, height: 844 });
  await page.emulateMedia({ colorScheme });
}

/** Expects no content beside the screen; keeps a picture in the folder OUTPUT. */
async function fits(name, [colorScheme, width]) {
  const wide = await page.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(wide <= width, `${wide} px of content on a screen of ${width} px`);
  await page.screenshot({ path: path.join(output, `${name}-${colorScheme}-${width}.png`), fullPage: true });
}

const isTouching = (s) => s === "sticks" || s === "slides";
const isOver = (s) => s === "in the air";

/** Where a tool can press: a place of the view that is measured, at which the engine answers. */
async function touchable() {
  await canvas.scrollIntoViewIfNeeded();
  for (const [x, y] of [
    [0.5, 0.5],
    [0.5, 0.4],
    [0.45, 0.35],
    [0.55, 0.3],
    [0.5, 0.6],
  ]) {
    await page.mouse.move(...(await at(x, y)));
    await page.mouse.down();
    let state = "";
    // As long as a busy machine takes: another place has its vertices elsewhere.
    for (let i = 0; i < 200 && !isTouching(state); ++i) {
      await page.waitForTimeout(50);
      if (await page.locator("#poke-where").isVisible()) break;
      state = await text("#poke-state");
    }
    await page.mouse.up();
    await until("#poke-state", isOver);
    if (isTouching(state)) return [x, y];
  }
  return assert.fail("nothing can be touched");
}

const claims = {
  async opens_from_disk_without_error_or_request() {
    await open();
    await frames(10);
    assert.deepEqual(
      requests.filter((url) => !url.startsWith("blob:") && !url.startsWith("data:")),
      [`file://${report}`],
    );
    assert.match(await text(".verdict"), /^(Good|Fair|Poor)( (or|to) (good|fair))?: /);
    assert.equal(await page.locator("main > section").first().getAttribute("id"), "body");
    assert.equal(await page.locator("#error details[open]").count(), 0); // the audit is behind its line
  },

  async no_row_is_no_number() {
    await open();
    const words = await text("#error");
    assert.doesNotMatch(words, /\b0\.0 %|unknown|null|NaN/);
    assert.match(words, /All that is known/);
    assert.match(await text(".verdict"), /^Poor: said of the asset\. \?$/);
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
    assert.ok((await page.locator("#point-detail svg.plot").count()) >= 1);
    assert.ok((await page.locator("#point-detail svg.plot circle.sample").count()) >= 5);
  },

  async a_click_shows_the_forces_of_the_nearest_held_out_path() {
    await open();
    await unfold();
    await page.locator("#mark-choice").selectOption("held_out");
    await canvas.scrollIntoViewIfNeeded();
    const seen = new Map();
    for (let i = 1; i < 8; ++i)
      for (let k = 1; k < 6; ++k) {
        await page.mouse.click(...(await at(i / 8, k / 6)));
        const lines = page.locator("#path-forces polyline");
        seen.set(await page.locator("#path-choice").inputValue(), await lines.first().getAttribute("points"));
      }
    assert.ok(seen.size >= 2, `clicks chose ${seen.size} paths`);
    assert.equal(new Set(seen.values()).size, seen.size);
    const shares = (await page.locator("#path-choice option").allTextContents()).map((s) => Number.parseFloat(s.split(": ")[1]));
    assert.deepEqual(shares, [...shares].sort((a, b) => b - a)); // the worst first
  },

  async a_click_picks_the_window() {
    await page.goto(`file://${report}`);
    await page.mouse.click(...(await at(0.5, 0.5)));
    const lines = await page.locator("#pick-lines").inputValue();
    await page.locator("#pick-part").selectOption("held");
    await page.mouse.click(...(await at(0.5, 0.45)));
    assert.match(await page.locator("#pick-lines").inputValue(), /^# \[body\]\nfixed = \[ { sphere = /);
    await writeFile(output, `${lines}\n`);
    await page.click("#pick-again");
    assert.doesNotMatch(await page.locator("#pick-lines").inputValue(), /sphere/);
  },

  async grey_means_uncovered_only_beside_a_map() {
    await open();
    assert.doesNotMatch(await text("#body"), /not measured/);
  },

  async the_body_gives_way_under_the_tool() {
    await open();
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
      await page.mouse.move(...(await at(x + dx, y + dy)), { steps: 6 });
      await settled("#poke-dent", "#poke-depth-now");
      const there = Number(await page.locator("#poke-dent").getAttribute("data-from_tip_m"));
      assert.ok(there < 0.009, `${there} m from the tip after a drag`);
    }
    await page.mouse.up();
    await until("#poke-dent", (s) => Number.parseFloat(s) === 0);
    assert.notDeepEqual(await page.screenshot({ clip }), dented);
    if (output) await page.screenshot({ path: path.join(output, "after.png") });
  },

  async two_fingers_are_two_tools() {
    await open();
    const [x, y] = await touchable();
    await page.mouse.move(...(await at(x, y)));
    await page.mouse.down();
    await until("#poke-state", isTouching);
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
    await settled("#poke-state");
    await second("pointerup", 0.08);
    await until("#poke-state", isTouching);
    await page.mouse.up();
    await until("#poke-state", isOver);
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
    await canvas.focus();
    await page.keyboard.press("Space");
    await until("#poke-state", isTouching);
    await until("#poke-depth-now", (s) => Number.parseFloat(s) >= 0.3);
    for (let i = 0; i < 6; ++i) await page.keyboard.press("ArrowRight");
    await until("#poke-lateral-now", (s) => Number.parseFloat(s) > 0);
    await page.keyboard.press("Escape");
    await until("#poke-state", isOver);
    const first = await canvas.screenshot();
    await page.keyboard.press("+");
    await changed(first);
    const turned = await canvas.screenshot();
    await page.keyboard.press("v");
    assert.equal(await page.locator("#turn-only").getAttribute("aria-pressed"), "true");
    await page.keyboard.press("ArrowLeft");
    await page.keyboard.press("ArrowLeft");
    await changed(turned);
    await page.locator("#point-choice").focus();
    await page.keyboard.press("Home");
    const before = await text("#point-detail p");
    await page.keyboard.press("ArrowDown");
    assert.notEqual(await text("#point-detail p"), before);
  },

  async the_window_is_pressed_at_once_and_all_else_turns_the_body() {
    await open();
    const [x, y] = await touchable();
    const pull = async (from, button) => {
      await page.mouse.move(...(await at(...from)));
      await page.mouse.down({ button });
      await page.mouse.move(...(await at(from[0] + 0.1, from[1] + 0.05)), { steps: 5 });
      await page.mouse.up({ button });
    };
    const still = async () => {
      await frames(5);
      return canvas.screenshot();
    };
    // Beside the window a drag turns, and says that nothing was measured there if it is on the body.
    let seen = await still();
    await pull([0.03, 0.97], "left");
    await changed(seen);
    assert.equal(await text("#poke-force"), "0 N");
    await page.click("#reset-view");
    seen = await still();
    await pull([x, y], "right");
    await changed(seen);
    await page.click("#reset-view");
    await page.click("#turn-only");
    seen = await still();
    await pull([x, y], "left");
    await changed(seen);
    await frames(5);
    assert.equal(await text("#poke-force"), "0 N");
  },

  async grey_says_that_it_is_not_measured() {
    await open();
    await canvas.scrollIntoViewIfNeeded();
    const said = page.locator("#poke-where");
    const seen = new Set();
    // From the middle out: the window first, then what is beside it.
    for (let i = 0; i < 20 && seen.size < 2; ++i) {
      await page.mouse.move(...(await at(0.5 + 0.025 * i, 0.5 + 0.02 * i)));
      await frames(2);
      const isWindow = await canvas.evaluate((view) => view.classList.contains("pressable"));
      if (isWindow && seen.has("window")) continue;
      await page.mouse.down();
      if (isWindow) {
        await until("#poke-state", (s) => !isOver(s));
        assert.equal(await said.isVisible(), false);
        seen.add("window");
      } else if (await said.isVisible()) {
        assert.match(await said.textContent(), /^Not measured here/);
        seen.add("grey");
      }
      await page.mouse.up();
      await until("#poke-state", isOver);
    }
    assert.deepEqual([...seen].sort(), ["grey", "window"]);
  },

  async the_body_is_seen_cut_from_the_side() {
    await open();
    await page.click("#poke-press");
    await until("#poke-state", isTouching);
    const whole = await canvas.screenshot();
    await page.click("#side-view");
    assert.equal(await page.locator("#side-view").getAttribute("aria-pressed"), "true");
    await changed(whole);
    await until("#poke-state", isTouching);
    await page.click("#side-view");
    assert.equal(await page.locator("#side-view").getAttribute("aria-pressed"), "false");
  },

  async axe_finds_nothing() {
    const axe = await readFile(fromModules.resolve("axe-core/axe.min.js"), "utf8");
    for (const look of [kLooks[0], kLooks[3]]) {
      await lookAt(look);
      await open();
      await unfold();
      await page.click(".ask >> nth=0");
      assert.match(await text("#term"), /95th percentile/);
      await page.evaluate(axe);
      const { violations } = await page.evaluate(() => window.axe.run());
      const said = violations.map(({ id, nodes }) => `${id}: ${nodes.map(({ html }) => html).join("\n  ")}`);
      assert.deepEqual(said, [], look.join());
    }
  },

  async recordings_are_drawn() {
    for (const look of kLooks.slice(0, 3)) {
      await lookAt(look);
      await page.goto(`file://${report}`);
      const pictures = page.locator("#recordings figure.recording");
      await pictures.first().waitFor();
      const words = await pictures.allTextContents();
      assert.equal(words.length, 3);
      assert.match(words[0], /b\.csv.*refused/);
      assert.match(words[1], /refused.*No signal was read/);
      assert.match(words[2], /a\.csv.*good.*contact 2\.0\d mm ±/);
      // The press; of a sound one also what the curve leaves, small against it.
      assert.deepEqual(await Promise.all([0, 1, 2].map((i) => pictures.nth(i).locator("svg.plot").count())), [1, 0, 2]);
      assert.equal(await pictures.nth(2).locator("rect.contact").count(), 2);
      const box = async (name) => pictures.nth(2).locator(name).boundingBox();
      const [curve, contact] = [await box("svg:nth-child(1) polyline"), await box("svg:nth-child(1) rect.contact")];
      assert.ok(curve.width > 20 && curve.height > 20 && contact.x > 0);
      await fits("recordings", look);
    }
  },

  // Lights turn with the eye, and the sky is where the window faces. They shone from the origin, so a
  // body far below it lay in the dark, and a window that faces down lay in the dark.
  async the_body_is_lit_alike_wherever_it_lies() {
    const html = await readFile(report, "utf8");
    const changed = (floats, change) => {
      const bytes = Buffer.from(floats, "base64");
      for (let i = 0; i < bytes.length; i += 4) bytes.writeFloatLE(change(bytes.readFloatLE(i), (i / 4) % 3), i);
      return bytes.toString("base64");
    };
    const brightness = async (height_m, isUpsideDown) => {
      const moved = html.replace(/(id="contents">)(.*?)(<\/script>)/s, (_, before, json, after) => {
        const contents = JSON.parse(json);
        const { surface } = contents;
        const turned = (value, axis) => (isUpsideDown && axis > 0 ? -value : value); // about x
        const lifted = (value, axis) => turned(value, axis) + (axis === 2 ? height_m : 0);
        surface.vertices_m = changed(surface.vertices_m, lifted);
        if (surface.inward_normal) surface.inward_normal = changed(surface.inward_normal, turned);
        delete contents.asset, delete contents.set_up; // which would make it transparent
        return before + JSON.stringify(contents).replaceAll("<", "\\u003c") + after;
      });
      await writeFile(path.join(profile, "moved.html"), moved);
      await page.goto(`file://${profile}/moved.html`);
      const red = () => canvas.evaluate((view) => {
        const copy = Object.assign(document.createElement("canvas"), { width: view.width, height: view.height });
        const paper = copy.getContext("2d");
        paper.drawImage(view, 0, 0);
        const { data } = paper.getImageData(0, 0, view.width, view.height);
        let [sum, count] = [0, 0];
        for (let i = 0; i < data.length; i += 4) if (data[i + 3] === 255) (sum += data[i]), ++count;
        return sum / count;
      });
      let now = await red();
      for (let i = 0, last = -1; i < 60 && now !== last; ++i) {
        last = now; // until it is drawn in full
        await page.waitForTimeout(700);
        now = await red();
      }
      return now;
    };
    const here = await brightness(0);
    for (const height_m of [-3, 3]) {
      const there = await brightness(height_m);
      assert.ok(Math.abs(there / here - 1) < 0.05, `red ${here} at the origin, ${there} at ${height_m} m`);
    }
    const below = await brightness(0, true);
    assert.ok(below / here > 0.9, `red ${here} of a window that faces up, ${below} of one that faces down`);
  },

  async both_schemes_and_narrow_screens_hold_it() {
    const grounds = [];
    const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    for (const look of kLooks) {
      await lookAt(look);
      await open();
      await frames(5);
      await fits("page", look);
      grounds.push(await ground());
    }
    assert.equal(grounds[0], grounds[2]);
    assert.notEqual(grounds[0], grounds[1]);
    await page.emulateMedia({ media: "print" });
    assert.equal(await page.locator(".panel").isVisible(), false);
    assert.equal(await canvas.isVisible(), true);
    assert.equal(await ground(), grounds[0]); // also where the screen is dark
  },
};

let failed = false;
try {
  await claims[claim]();
  assert.deepEqual(errors, []);
} catch (error) {
  console.error(error.stack);
  failed = true;
}
await context.close();
await rm(profile, { recursive: true, force: true });
process.exit(failed ? 1 : 0);
