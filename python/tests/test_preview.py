"""The page beside the command's, and in a notebook: made by a kernel of its own, opened in a browser, with nothing from elsewhere."""

import html
import html.parser
import pickle
import unittest
from pathlib import Path

import trunnion
from shared import Folder, box, command, fixture, tee

class Frames(html.parser.HTMLParser):
    """The frames of a text of HTML, and all its tags."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.frames = [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag == "iframe":
            self.frames.append(dict(attrs))


class Pages(Folder):
    def same_page(self, done, *words, code=0):
        page = self.folder / "theirs.html"
        got, document, said = command("preview", *words, "-o", page)
        self.assertEqual(got, code, said)
        self.assertEqual(done.page, page.read_bytes())
        ours = done.to_dict()
        for one in [ours, document, *ours.get("pages", []), *document.get("pages", [])]:
            del one["output"]
        self.same(ours, document)

    def test_a_program_a_plan_a_model_and_two(self):
        out, plan = self.folder / "out.gcode", self.folder / "plan.json"
        prepared = trunnion.prepare(fixture("two-boxes"), "generic-ac", slicer="builtin", overhang_deg=40, output=out, plan_out=plan)
        for given in [(prepared,), (out, plan), (str(out), prepared)]:
            done = trunnion.preview(*given)
            self.same_page(done, out, "--plan", plan)
        self.assertEqual((done.shows, done.moves, done.verify.clean), ("program", prepared.verify.moves, True))
        self.assertEqual((len(done.page), done.output), (done.bytes, None))
        self.assertEqual(pickle.loads(pickle.dumps(done)).html, done.html)
        planned = trunnion.plan(fixture("two-boxes"), "generic-ac", overhang_deg=40)
        for given in [{"shown": planned}, {"plan": planned.plan}, {"plan": plan, "profile": "generic-ac"}]:
            # Bytes in hand have no folder that the plan's model could be seen from.
            done = trunnion.preview(model=fixture("two-boxes"), **given)
            self.assertEqual((done.shows, done.verify, done.moves), ("plan", None, 0))
        self.same_page(done, "--plan", plan)
        done = trunnion.preview(fixture("two-boxes"), profile="generic-ac", overhang_deg=40, turn_deg=30)
        self.same_page(done, fixture("two-boxes"), "-m", "generic-ac", "--overhang", "40", "--turn", "30")
        for compare, words in [([plan, (out, plan)], (plan, f"{out}={plan}")), ([prepared, plan], (f"{out}={plan}", plan))]:
            done = trunnion.preview(compare=compare)
            self.assertEqual((done.shows, [one["shows"] for one in done.pages].count("program")), ("two", 1))
            self.same_page(done, "--compare", *words)

    def test_what_has_no_plan_is_shown_with_its_reasons(self):
        done = trunnion.preview(fixture("caged"), profile="generic-ac")
        self.same_page(done, fixture("caged"), "-m", "generic-ac", code=1)
        self.assertEqual(done.shows, "reasons")
        self.assertTrue(done.why_not)
        supported = trunnion.preview(fixture("hook"), profile="generic-ac", supports="auto")
        self.same_page(supported, fixture("hook"), "-m", "generic-ac", "--supports", "auto")

    def test_a_program_with_findings_is_shown(self):
        prepared = trunnion.prepare(fixture("cube"), "generic-ac", slicer="builtin")
        # What the heads of their files say is beside the first line: half of the print is missing.
        half = b"".join(prepared.gcode.splitlines(True)[:-2000])
        done = trunnion.preview(half, prepared, model=fixture("cube"))
        self.assertGreater(len(done.verify.findings), 0)

    def test_in_memory_and_cut(self):
        model = trunnion.Model.from_arrays(*tee())
        prepared = trunnion.prepare(trunnion.Model("tee.3mf", model.data), "generic-ac", slicer="builtin")
        done = trunnion.preview(prepared, output=self.folder / "tee.html")
        self.assertEqual((self.folder / "tee.html").read_bytes(), done.page)
        self.assertEqual((done.output, done.parts), (str(self.folder / "tee.html"), len(prepared.plan.parts)))
        done.write(self.folder / "again.html")
        self.assertEqual((self.folder / "again.html").read_bytes(), done.page)

    def test_what_cannot_be_shown(self):
        prepared = trunnion.prepare(fixture("cube"), "generic-ac", slicer="builtin")
        cube = fixture("cube")
        for given, keywords in [
            ((), {}), ((cube,), {}), ((prepared, None), {"compare": [prepared, prepared]}), ((), {"compare": [prepared]}),
            ((), {"compare": 3}), ((prepared,), {"output": self.folder / "page.txt"}), ((prepared,), {"overhang_deg": 40}),
            ((b"G28\n", prepared), {}), ((None, self.folder / "none.json"), {}), ((cube,), {"profile": "generic-b"}),
        ]:  # fmt: skip
            with self.subTest(given=str(given)[:60], keywords=str(keywords)[:60]), self.assertRaises(trunnion.InputError) as caught:
                trunnion.preview(*given, **keywords)
            self.assertTrue(caught.exception.code)
        self.assertEqual(list(self.folder.iterdir()), [])

    def test_a_frame_holds_the_page_and_lets_nothing_out(self):
        """Names of strangers, and the page's own quotes and tags, stay text of the frame's document."""
        name = """a"><script>top.broken = 1</script>&amp;'</iframe>"""
        model = trunnion.Model.from_meshes({name: box((0, 0, 0), (6, 6, 1))})
        done = trunnion.preview(model, profile="generic-ac")
        found = Frames(done._repr_html_())
        self.assertEqual(found.tags, ["iframe"])
        (frame,) = found.frames
        self.assertEqual(frame["srcdoc"], done.html)
        # Scripts, and no right to the notebook, its storage, its windows or its forms.
        self.assertEqual(frame["sandbox"], "allow-scripts")
        self.assertNotIn("src", frame)


if __name__ == "__main__":
    unittest.main()
