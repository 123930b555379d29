"""The Python module as a user has it. ctest gives PYTHONPATH, PALPATE_PROGRAM and PALPATE_SOURCE."""
import csv
import importlib.util
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import numpy as np

import palpate

SOURCE = pathlib.Path(os.environ["PALPATE_SOURCE"])
GOLDEN = sorted((SOURCE / "tests/libfit/runtime/golden").glob("*.palp"))
PROGRAM = os.environ["PALPATE_PROGRAM"]


def random_path(asset, seed, ticks=4000):
    """Strokes that press, slide and lift all over what can be touched, 40 mm/s at most."""
    random, (low, high) = np.random.default_rng(seed), asset.box_m
    corners = random.uniform(low - 0.002, high + 0.004, (60, 3))
    way = np.r_[0, np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))]
    at = np.linspace(0, min(way[-1], 4e-5 * ticks), ticks)
    return np.column_stack([np.interp(at, way, corners[:, i]) for i in range(3)])


def walled_in(path):
    """A closed block of 80 x 80 x 30 mm, as the tests of the program have it."""
    n, vertices, faces = 8, [], []
    grids = [lambda s, t: (s, t, 1), lambda s, t: (t, s, 0), lambda s, t: (s, 0, t), lambda s, t: (t, 1, s),
             lambda s, t: (0, t, s), lambda s, t: (1, s, t)]
    for place in grids:
        first = len(vertices)
        vertices += [place(i / n, j / n) for j in range(n + 1) for i in range(n + 1)]
        for a in (first + j * (n + 1) + i for j in range(n) for i in range(n)):
            faces += [(a, a + 1, a + n + 2), (a, a + n + 2, a + n + 1)]
    rows = [f"{80 * x} {80 * y} {30 * z}" for x, y, z in vertices] + [f"3 {a} {b} {c}" for a, b, c in faces]
    pathlib.Path(path).write_text(f"OFF\n{len(vertices)} {len(faces)} 0\n" + "\n".join(rows) + "\n")
    return path


class Ticks(unittest.TestCase):
    def test_repeat_replay_bit_for_bit(self):
        touched = 0
        for golden in GOLDEN:
            with palpate.open(golden) as asset, tempfile.TemporaryDirectory() as folder:
                path = random_path(asset, seed=7)
                table, forces = pathlib.Path(folder, "path.csv"), pathlib.Path(folder, "forces.csv")
                table.write_text("t_s,x_m,y_m,z_m\n" + "".join(
                    f"{i / 1000},{x!r},{y!r},{z!r}\n" for i, (x, y, z) in enumerate(path.tolist())))
                palpate.command("replay", golden, table, output=forces, quiet=True)
                ticks = asset.contact().tick(path)
                with forces.open() as file:
                    rows = list(csv.DictReader(file))
            self.assertEqual(len(rows), len(ticks))
            for name, field, part in [("fx_N", "force_on_tool_N", 0), ("fy_N", "force_on_tool_N", 1),
                                      ("fz_N", "force_on_tool_N", 2), ("cx_m", "contact_m", 0),
                                      ("depth_m", "normal_m", None), ("lateral_m", "lateral_m", None)]:
                told = np.array([float(row[name]) for row in rows])
                played = ticks[field] if part is None else ticks[field][:, part]
                np.testing.assert_array_equal(told, played, f"{golden.name}: {name}")
            touched += np.count_nonzero(ticks["state"])
        self.assertGreater(touched, 500)

    def test_are_the_same_one_by_one_in_pieces_and_in_float32_rounded_alike(self):
        with palpate.open(GOLDEN[0]) as asset:
            path = random_path(asset, seed=3).astype(np.float32)
            whole = asset.contact().tick(path)
            single, pieces = asset.contact(), asset.contact()
            np.testing.assert_array_equal(np.array([single.tick(row) for row in path.astype(float)]), whole)
            np.testing.assert_array_equal(np.concatenate([pieces.tick(p) for p in np.array_split(path, 7)]), whole)
            self.assertTrue(whole["state"].any())

    def test_take_arrays_with_gaps_and_of_the_other_order(self):
        with palpate.open(GOLDEN[0]) as asset:
            path = random_path(asset, seed=4)
            wide = np.full((2 * len(path), 5), np.nan)
            wide[::2, 1:4] = path
            for view in (wide[::2, 1:4], np.asfortranarray(path), path[::-1][::-1], path.tolist()):
                np.testing.assert_array_equal(asset.contact().tick(view), asset.contact().tick(path))

    def test_refuse_shapes_and_types_that_are_none(self):
        with palpate.open(GOLDEN[0]) as asset:
            contact = asset.contact()
            for bad in (np.zeros((3, 4)), np.zeros(2), np.zeros((2, 2, 3)), np.float64(1)):
                self.assertRaisesRegex(ValueError, r"position_m must have the shape \(n, 3\)", contact.tick, bad)
            for bad in (np.zeros((3, 3), complex), [["a", "b", "c"]], None, np.zeros((1, 3), object)):
                self.assertRaisesRegex(TypeError, "position_m must be real numbers", contact.tick, bad)
            self.assertRaisesRegex(ValueError, "orientation has 2 rows, position_m 3", contact.tick,
                                   np.zeros((3, 3)), orientation=np.ones((2, 4)))
            self.assertRaisesRegex(palpate.Error, "tool: ", asset.contact, radius_m=-1)
            self.assertRaisesRegex(ValueError, "radius_m is 4, .*is it in metres", asset.contact, radius_m=4)
            for dt_s in (0, -0.001, np.nan, np.inf):
                self.assertRaisesRegex(ValueError, "dt_s must be above 0", contact.tick, np.zeros((2, 3)), dt_s=dt_s)
            self.assertRaises(IndexError, contact.deform, 0, 10**9)
            self.assertEqual(len(contact.tick(np.zeros((0, 3)))), 0)

    def test_tell_what_is_wrong_with_a_row_and_give_no_force_there(self):
        with palpate.open(GOLDEN[0]) as asset:
            row = asset.contact().tick([np.nan, 0, 0])
            self.assertIn("finite", palpate.sentence(row["status"]).lower())
            self.assertFalse(row["force_on_tool_N"].any())

    def test_turn_with_the_body(self):
        with palpate.open(GOLDEN[0]) as asset:
            path, half = random_path(asset, seed=5, ticks=1500), np.sqrt(0.5)
            turned = path[:, [1, 0, 2]] * [-1, 1, 1] + [0.3, 0, 0]  # by 90 degrees about z, then aside
            here = asset.contact().tick(path)
            there = asset.contact().tick(turned, body_position_m=[0.3, 0, 0], body_orientation=[half, 0, 0, half])
            force = here["force_on_tool_N"][:, [1, 0, 2]] * [-1, 1, 1]
            np.testing.assert_allclose(there["force_on_tool_N"], force, atol=1e-9)
            self.assertTrue(force.any())

    def test_of_a_copy_go_on_alike(self):
        with palpate.open(GOLDEN[0]) as asset:
            path, first = random_path(asset, seed=6), asset.contact()
            first.tick(path[:2000])
            second = first.copy()
            np.testing.assert_array_equal(first.tick(path[2000:]), second.tick(path[2000:]))
            first.restart()
            np.testing.assert_array_equal(first.tick(path), asset.contact().tick(path))

    def test_of_a_batch_are_those_of_each_contact(self):
        for golden in GOLDEN[:2]:
            with palpate.open(golden) as asset:
                radius = asset.probe_radius_m or 0.004
                paths = np.stack([random_path(asset, seed=k, ticks=800) for k in range(20, 37)])
                batch, alone = asset.batch(17, radius_m=radius), [asset.contact(radius).tick(path) for path in paths]
                self.assertEqual(len(batch), 17)
                for jobs in (1, 3):
                    played = np.stack([batch.tick(paths[:, i], jobs=jobs) for i in range(800)], axis=1)
                    np.testing.assert_array_equal(played, alone)
                    batch.restart()
                self.assertGreater(np.count_nonzero(played["state"]), 300)
                batch.restart(np.arange(17) < 5)
                self.assertRaisesRegex(ValueError, "3 rows for 17 contacts", batch.tick, paths[0][:3])
                self.assertRaisesRegex(ValueError, "one truth value", batch.restart, [True])
                self.assertRaisesRegex(ValueError, "1 contact or more", asset.batch, 0)
                self.assertRaisesRegex(ValueError, "dt_s", batch.tick, paths[:, 0], dt_s=0.0)

    def test_of_tools_that_feel_nothing_of_each_other_are_those_of_each(self):
        with palpate.open(GOLDEN[1]) as asset:
            self.assertFalse(asset.couples)
            with self.assertRaisesRegex(palpate.Error, "several balls"):
                asset.contact(radius_m=0.004, centre_m=[[0, 0, 0], [0.01, 0, 0]])
            paths = np.stack([random_path(asset, seed=k) for k in (11, 12)])
            radius = asset.probe_radius_m or 0.004
            tools = [asset.contact(), asset.contact(radius)]
            alone = [asset.contact().tick(paths[0]), asset.contact(radius).tick(paths[1])]
            half = [palpate.tick_together(tools, part) for part in (paths[:, :1500], paths[:, 1500:])]
            np.testing.assert_array_equal(np.concatenate(half, axis=1), alone)
            self.assertEqual(palpate.tick_together(tools, paths[:, 0]).shape, (2,))

    def test_of_a_ball_aside_turn_about_the_tools_place(self):
        with palpate.open(GOLDEN[0]) as asset:
            path, half = random_path(asset, seed=13), np.sqrt(0.5)
            ball = asset.contact(0.003, [0.01, 0, 0])  # under the tool once it is turned by 90 degrees about y
            turned = ball.tick(path + [0, 0, 0.01], orientation=[half, 0, half, 0])
            plain = asset.contact(0.003).tick(path)
            np.testing.assert_allclose(turned["force_on_tool_N"], plain["force_on_tool_N"], atol=1e-9)
            self.assertGreater(np.count_nonzero(plain["touching"]), 100)
            lever = turned["acts_at_m"] - path - [0, 0, 0.01]
            np.testing.assert_allclose(turned["torque_on_tool_Nm"][turned["state"] > 0],
                                       np.cross(lever, turned["force_on_tool_N"])[turned["state"] > 0], atol=1e-12)

    def test_refuse_tools_that_do_not_go_together(self):
        with palpate.open(GOLDEN[0]) as asset, palpate.open(GOLDEN[1]) as other:
            tip, at = asset.contact(), np.zeros((2, 3))
            for contacts, words in (([], "1 to 8"), ([tip, tip], "twice"), ([tip, other.contact()], "one asset"),
                                    ([asset.contact() for _ in range(9)], "not 9")):
                self.assertRaisesRegex(ValueError, words, palpate.tick_together, contacts, at)
            two = [tip, asset.contact()]
            self.assertRaisesRegex(ValueError, "3 items for 2 contacts", palpate.tick_together, two, np.zeros((3, 3)))
            self.assertRaisesRegex(ValueError, "2 rows of contact 1, 1 of contact 0", palpate.tick_together, two,
                                   [np.zeros((1, 3)), np.zeros((2, 3))])
            self.assertRaisesRegex(ValueError, "2 numbers, centre_m 3 rows", asset.contact, [1e-3, 2e-3], np.zeros((3, 3)))
            self.assertRaisesRegex(ValueError, "not 9", asset.contact, 1e-3, np.zeros((9, 3)))

    def test_from_threads_are_those_of_one(self):
        with palpate.open(GOLDEN[0]) as asset:
            path = random_path(asset, seed=8)
            alone, results = asset.contact().tick(path), [None] * 8
            shared = asset.contact()

            def play(i):
                results[i] = asset.contact().tick(path)
                shared.tick(path)

            threads = [threading.Thread(target=play, args=(i,)) for i in range(len(results))]
            for thread in threads:
                thread.start()
            for thread in threads:
                thread.join()
            for result in results:
                np.testing.assert_array_equal(result, alone)

    def test_release_the_interpreter_and_end_on_interrupt(self):
        with palpate.open(GOLDEN[0]) as asset:
            contact, path = asset.contact(), np.tile(asset.box_m.mean(axis=0), (1_500_000, 1))
            counted, stop = [0], threading.Event()

            def count():
                while not stop.is_set():
                    counted[0] += 1
                    time.sleep(0.001)

            other = threading.Thread(target=count)
            other.start()
            threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT)).start()
            with self.assertRaises(KeyboardInterrupt):
                for _ in range(50):
                    contact.tick(path)
                    counted[0] = 0
            stop.set()
            other.join()
            self.assertGreater(counted[0], 0)


class AnAsset(unittest.TestCase):
    def test_says_what_it_is(self):
        for golden in GOLDEN:
            with palpate.open(str(golden)) as asset:
                told = palpate.command("inspect", golden)
                self.assertEqual(asset.law, told["family"])
                self.assertEqual(asset.vertices_m.shape, (told["vertices"], 3))
                self.assertEqual(asset.triangles.shape, (told["triangles"], 3))
                self.assertEqual(np.count_nonzero(asset.covered == 1), told["measured_vertices"])
                self.assertEqual(asset.range_m, told["range_m"])
                self.assertIsInstance(asset.meta, dict)
                np.testing.assert_allclose(np.linalg.norm(asset.inward_normal, axis=1), 1, atol=1e-5)

    def test_that_is_closed_answers_nothing(self):
        with palpate.open(GOLDEN[0]) as asset:
            contact = asset.contact()
        self.assertTrue(asset.closed)
        for ask in (lambda: contact.tick([0, 0, 0]), contact.deform, asset.contact, lambda: asset.law):
            self.assertRaisesRegex(ValueError, "the asset is closed", ask)

    def test_that_is_none_is_refused_in_the_engines_words(self):
        content = GOLDEN[0].read_bytes()
        for bytes_, words in ((b"", "too few"), (b"x" * 500, ""), (content[:-1], ""),
                              (content[:900] + b"?" + content[901:], "")):
            with self.assertRaises(palpate.Error) as caught:
                palpate.Asset(bytes_, "some.palp")
            self.assertEqual(caught.exception.where, "some.palp")
            self.assertIn(words, caught.exception.what)
        self.assertRaises(FileNotFoundError, palpate.open, "nowhere.palp")


@unittest.skipUnless(importlib.util.find_spec("h5py"), "python3-h5py is not installed")
class Files(unittest.TestCase):
    """One small run, by the example that a user would begin with."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.at = pathlib.Path(cls.folder.name)
        cls.said = example("run_and_look.py", walled_in(cls.at / "block.off"), cls.at / "out",
                           *([cls.at / "curve.png"] if importlib.util.find_spec("matplotlib") else []))

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def test_are_made_by_the_example_from_a_dict(self):
        self.assertIn("19 of 20 within", self.said)
        self.assertEqual(self.said.count(" N at "), 4)
        if importlib.util.find_spec("matplotlib"):
            self.assertGreater((self.at / "curve.png").stat().st_size, 5000)

    def test_hold_what_the_program_says(self):
        error = palpate.statement(self.at / "out")["force_error"]
        self.assertEqual(error, palpate.statement(self.at / "out/asset.palp")["force_error"])
        body = palpate.read(self.at / "out/body.h5")
        self.assertEqual(body["test_points/position"].shape, (4, 3))
        samples = palpate.read(self.at / "out/samples.h5")
        self.assertEqual(samples["rows/status/names"][0], "good")
        points = palpate.by_point(samples)
        self.assertEqual(sum(len(rows["force"]) for rows in points.values()), len(samples["rows/force"]))

    def test_that_are_read_and_written_again_fit_alike(self):
        samples = palpate.read(self.at / "out/samples.h5")
        again = palpate.fit(samples, self.at / "again.h5", jobs=1, quiet=True)
        direct = palpate.fit(self.at / "out/samples.h5", self.at / "direct.h5", jobs=1, quiet=True)
        for point, kinds in direct.items():
            for kind, curve in kinds.items():
                for key, value in curve.items():
                    np.testing.assert_array_equal(value, again[point][kind][key])
                self.assertTrue((np.diff(curve["value_N"]) >= 0).all())
            self.assertTrue((kinds["normal"]["deviation_N"][1:] > 0).all())

    def test_samples_in_time_of_several_tools_keep_their_units(self):
        samples = palpate.read(self.at / "out/samples.h5")
        rows = len(samples["rows/force"])
        samples.update({"rows/time": np.full(rows, np.nan), "rows/tool": np.zeros(rows), "rows/lean": np.zeros((rows, 2)),
                        "relaxation/share": np.array([0.3]), "relaxation/time": np.array([0.5])})
        first = samples["rows/experiment"] == samples["rows/experiment"][0]
        samples["rows/time"][first] = 0.1 * np.arange(1, first.sum() + 1)
        self.assertTrue(palpate.fit(samples, self.at / "timed.h5", jobs=1, quiet=True))

    def test_samples_of_a_second_probe_are_written_as_they_were(self):
        import h5py
        samples = palpate.read(self.at / "out/samples.h5")
        last = samples["rows/experiment"] == samples["rows/experiment"][-1]
        samples["rows/probe"] = last.astype(np.int32)
        samples["rows/kind"][last] = samples["rows/kind/names"].index("other")
        samples.update({"probe_1/" + name[6:]: value for name, value in samples.items() if name.startswith("probe/")})
        palpate.write_samples(self.at / "two.h5", samples)
        again = palpate.read(self.at / "two.h5")
        with h5py.File(self.at / "two.h5") as two, h5py.File(self.at / "out/samples.h5") as one:
            for name in set(samples) - {"attributes"}:
                np.testing.assert_array_equal(again[name], samples[name], name)
                if name in two:
                    twin = one.get(name.replace("probe_1/", "probe/"), one["rows/step"])
                    kinds = ["text" if set_.dtype.kind in "SO" else set_.dtype for set_ in (two[name], twin)]
                    self.assertEqual(kinds[0], kinds[1], name)
                    self.assertEqual(two[name].attrs["unit"], palpate.files._text(twin.attrs["unit"]), name)
        self.assertTrue(palpate.fit(self.at / "two.h5", self.at / "two_curves.h5", jobs=1, quiet=True))

    def test_of_another_kind_are_refused(self):
        for path in (self.at / "block.off", GOLDEN[0]):
            self.assertRaises(palpate.Error, palpate.read, path)
        self.assertRaises(FileNotFoundError, palpate.read, self.at / "none.h5")
        with self.assertRaises(palpate.Error) as caught:
            palpate.fit(self.at / "out/body.h5", self.at / "no.h5", quiet=True)
        self.assertIn("palpate-body", str(caught.exception))
        samples = palpate.read(self.at / "out/samples.h5")
        self.assertRaisesRegex(palpate.Error, "there is no rows/force", palpate.write_samples, "x.h5",
                               {name: value for name, value in samples.items() if name != "rows/force"})
        samples["rows/force"] = samples["rows/force"][:-1]
        self.assertRaisesRegex(palpate.Error, "rows/force", palpate.fit, samples, self.at / "no.h5", quiet=True)
        self.assertFalse((self.at / "no.h5").exists())

    def test_samples_that_a_file_would_hold_otherwise_are_refused(self):
        samples = palpate.read(self.at / "out/samples.h5")
        point, kind, force = (samples["rows/" + name] for name in ("point", "kind", "force"))
        for changed, said in (({"rows/point": point + 0.6}, "rows/point: 0.6 is no whole number"),
                              ({"rows/kind": np.full(len(kind), 256)}, "rows/kind: 256 is no whole number from -128"),
                              ({"rows/step": np.full(len(kind), np.nan)}, "rows/step: nan is no whole number"),
                              ({"rows/forces": force}, "rows/forces is no array of samples; is it rows/force"),
                              ({"points/position": 1e3 * samples["points/position"]}, "points/position: reaches over"),
                              ({"rows/deflection": 1e3 * samples["rows/deflection"]}, "Lengths are in metres")):
            self.assertRaisesRegex(palpate.Error, said, palpate.fit, {**samples, **changed}, self.at / "no.h5", quiet=True)
        samples["rows/forces"] = samples.pop("rows/force")
        self.assertRaisesRegex(palpate.Error, "there is no rows/force", palpate.fit, samples, self.at / "no.h5")
        self.assertFalse((self.at / "no.h5").exists())

    def test_names_of_samples_are_those_of_their_page(self):
        page = (SOURCE / "docs/formats/samples.md").read_text().split("<!-- table: samples -->")[1].split("\n\n")[0]
        listed = set(re.findall(r"^\| `(\w+/\w+)`", page, re.M))
        self.assertEqual({name for name in palpate.files._COLUMNS if not name.startswith("probe/")}, listed)

    def test_of_a_shape_move_the_surface(self):
        with palpate.open(self.at / "out/asset.palp") as asset:
            contact, vertices = asset.contact(radius_m=0.008), asset.vertices_m
            down = np.linspace(0.045, 0.035, 400)
            contact.tick(np.column_stack([np.full(400, 0.04), np.full(400, 0.04), down]))
            moved = contact.deform()
            self.assertEqual((moved.shape, moved.dtype), (vertices.shape, np.float32))
            self.assertLess(moved[:, 2].min(), -0.002)
            np.testing.assert_array_equal(contact.deform(5, 7), moved[5:12])
            other = asset.contact(radius_m=0.008)
            other.tick(np.column_stack([np.full(400, 0.06), np.full(400, 0.04), down]))
            both = palpate.deform_together([contact, other])
            np.testing.assert_allclose(both, moved + other.deform(), atol=1e-3)
            self.assertLess(both[:, 2].min(), -0.002)

    def test_of_a_mesh_of_ones_own_follow_the_surface(self):
        mine, output = self.at / "mine.obj", self.at / "mine.palp"
        mine.write_text("v 40 40 30\nv 0 0 31\n")
        palpate.command("export", self.at / "out/asset.palp", visual=mine, output=output)
        with palpate.open(output) as asset:
            np.testing.assert_allclose(asset.place_visual(), [[0.04, 0.04, 0.03], [0, 0, 0.031]], atol=1e-7)
            contact = asset.contact(radius_m=0.008)
            contact.tick(np.column_stack([np.full(400, 0.04), np.full(400, 0.04), np.linspace(0.045, 0.035, 400)]))
            self.assertLess(asset.place_visual(contact.deform())[0, 2], 0.028)
            self.assertRaises(ValueError, asset.place_visual, [[0, 0, 0]])

    @unittest.skipUnless(importlib.util.find_spec("matplotlib"), "python3-matplotlib is not installed")
    def test_are_drawn_as_the_documents_show_them(self):
        pictures = pathlib.Path(os.environ.get("PALPATE_PICTURES", self.at))
        run = pathlib.Path(os.environ.get("PALPATE_PICTURED_RUN", self.at / "out"))
        palpate.command("tabulate", run / "curves.h5", output=self.at / "curves.csv", quiet=True)
        with palpate.open(run / "asset.palp") as asset:  # a press, a slide, a lift
            corners = np.array([*asset.box_m.mean(axis=0)[:2], asset.box_m[1][2]]) + asset.range_m * np.array(
                [[0, 0, 0.2], [0, 0, -0.8], [2, 0, -0.8], [2, 0, 0.2]])
        path = np.vstack([np.linspace(a, b, 250) for a, b in zip(corners, corners[1:])])
        np.savetxt(self.at / "path.csv", np.column_stack([np.arange(len(path)) / 1000, path]), delimiter=",",
                   header="t_s,x_m,y_m,z_m", comments="")
        palpate.command("replay", run / "asset.palp", self.at / "path.csv", output=self.at / "forces.csv",
                        quiet=True)
        drawn = {"statement": palpate.plot_statement(run),
                 "curves": palpate.plot_curves(self.at / "curves.csv"),
                 "path": palpate.plot_path(self.at / "forces.csv")}
        for name, axes in drawn.items():
            axes.figure.savefig(pictures / f"{name}.png", dpi=60)
            self.assertGreater((pictures / f"{name}.png").stat().st_size, 3000, name)
        stated = palpate.statement(run)["by_path"]
        widths = [bar.get_width() for bar in drawn["statement"].patches]
        self.assertEqual(widths[:len(stated)], [100 * error["p95_rel"] for error in stated.values()])
        with (self.at / "curves.csv").open() as file:
            points = {row["point"] for row in csv.DictReader(file)}
        self.assertEqual(len(drawn["curves"].lines), len(points))
        self.assertGreater(np.ptp(drawn["path"].lines[2].get_ydata()), 0.01)  # the path touches

    @unittest.skipUnless(importlib.util.find_spec("pandas"), "pandas is not installed")
    def test_become_frames(self):
        frame = palpate.frame(next(iter(palpate.by_point(palpate.read(self.at / "out/samples.h5")).values())))
        self.assertIn("force_2", frame)


class Program(unittest.TestCase):
    def test_refuses_in_its_own_words(self):
        with self.assertRaises(palpate.Error) as caught:
            palpate.run({"body": {"surface": "nowhere.off", "length_unit": "mm"}, "material": {"young": "9 kPa"},
                         "probe": {"radius": "8 mm"}}, "unused", quiet=True)
        self.assertIn("nowhere.off", str(caught.exception))
        self.assertTrue(caught.exception.remedy)
        self.assertFalse(os.path.exists("unused"))
        with tempfile.TemporaryDirectory() as folder:
            scene = {"body": {"surface": walled_in(os.path.join(folder, "b.off")), "length_unit": "mm"},
                     "material": {"young": "soft"}}
            self.assertRaisesRegex(palpate.Error, "young", palpate.command, "check", scene, quiet=True)
        self.assertRaisesRegex(ValueError, "no command \"fitt\"", palpate.command, "fitt", quiet=True)
        self.assertRaisesRegex(ValueError, "no option --degre", palpate.command, "fit", "s.h5", degre=3,
                               quiet=True)

    @unittest.skipUnless(importlib.util.find_spec("h5py"), "python3-h5py is not installed")
    def test_keeps_what_is_done_when_interrupted(self):
        with tempfile.TemporaryDirectory() as folder:
            scene = {"body": {"surface": walled_in(os.path.join(folder, "b.off")), "length_unit": "mm",
                              "fixed": [{"below": {"axis": "z", "at": "1 mm"}}]},
                     "material": {"young": "10 kPa", "poisson": 0.45}, "probe": {"radius": "8 mm"},
                     "experiments": {"depth": "4 mm", "drag_distance": "5 mm"}}
            out = os.path.join(folder, "out")

            def interrupt():  # once the body is there it simulates, for minutes
                while not os.path.exists(os.path.join(out, "body.h5")):
                    time.sleep(0.05)
                time.sleep(0.5)
                os.kill(os.getpid(), signal.SIGINT)

            threading.Thread(target=interrupt, daemon=True).start()
            with self.assertRaises(KeyboardInterrupt):
                palpate.run(scene, out, jobs=1, quiet=True)
            self.assertFalse(os.path.exists(os.path.join(out, "samples.h5")))
            self.assertEqual(palpate.read(os.path.join(out, "body.h5"))["test_points/normal"].shape[1], 3)


def example(name, *arguments):
    """What the example printed."""
    return subprocess.run([sys.executable, SOURCE / "docs/embedding/python" / name, *arguments], check=True,
                          stdout=subprocess.PIPE, text=True).stdout


class Examples(unittest.TestCase):
    def test_force_along_path_presses_and_slides(self):
        with tempfile.TemporaryDirectory() as folder:
            picture = pathlib.Path(folder, "path.png")
            wants = [folder] if importlib.util.find_spec("matplotlib") else []
            said = example("force_along_path.py", GOLDEN[0], *wants)
            self.assertRegex(said, r"\d+ ticks, [1-9]\d* in contact, [1-9]\d* slipping")
            self.assertTrue(not wants or picture.stat().st_size > 5000)

    @unittest.skipUnless(importlib.util.find_spec("h5py"), "python3-h5py is not installed")
    def test_own_simulator_gets_its_forces_back(self):
        with tempfile.TemporaryDirectory() as folder:
            lines = example("own_simulator.py", folder).splitlines()
        self.assertEqual(len(lines), 4)
        for line in lines:
            fitted, simulated = (float(part.split()[0]) for part in (line.split(": ")[1], line.split("simulated ")[1]))
            self.assertAlmostEqual(fitted / simulated, 1, delta=0.02)


if __name__ == "__main__":
    unittest.main()
