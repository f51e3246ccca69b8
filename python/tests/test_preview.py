"""The page beside the command's, and in a notebook: made by a kernel of its own, opened in a browser, with nothing from elsewhere."""

import html
import html.parser
import json
import os
import pickle
import shutil
import subprocess
import sys
import unittest
import unittest.mock
import warnings
from importlib.util import find_spec
from pathlib import Path

import trunnion
from shared import ROOT, Folder, box, command, fixture, tee

BROWSER = next(filter(shutil.which, ["chromium", "chromium-browser", "google-chrome"]), None)


def left_out(why):
    """A test that cannot be made here says so aloud: the test command lists it."""
    print(f"SKIPPED: {why}", file=sys.stderr, flush=True)
    raise unittest.SkipTest(why)


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


#: The cells of a notebook as somebody would write them.
CELLS = [
    "import trunnion\nimport warnings\nwarnings.simplefilter('ignore')",
    "done = trunnion.prepare(MODEL, 'generic-ac', slicer='builtin')\ndone.verify.clean",
    "trunnion.preview(done)",
    "trunnion.preview(CAGED, profile='generic-ac')",
]


class Notebook(Folder):
    def outputs(self):
        """What each cell of a notebook gives, as a kernel makes it."""
        if not all(find_spec(name) for name in ("nbformat", "nbclient", "ipykernel")):
            left_out("nbformat, nbclient and ipykernel are not installed: no notebook was run")
        import nbclient
        import nbformat

        notebook = nbformat.v4.new_notebook()
        first = f"MODEL, CAGED = {fixture('cube')!r}, {fixture('caged')!r}\n"
        notebook.cells = [nbformat.v4.new_code_cell((first if not index else "") + cell) for index, cell in enumerate(CELLS)]
        # A kernel of this very interpreter, whatever kernels this computer has; nothing is left in anybody's home.
        kernel = self.folder / "kernels" / "python3"
        kernel.mkdir(parents=True)
        argv = [sys.executable, "-m", "ipykernel_launcher", "-f", "{connection_file}"]
        (kernel / "kernel.json").write_text(json.dumps({"argv": argv, "display_name": "Python", "language": "python"}))
        own = {name: str(self.folder) for name in ("JUPYTER_PATH", "JUPYTER_RUNTIME_DIR", "IPYTHONDIR", "JUPYTER_CONFIG_DIR")}
        with unittest.mock.patch.dict(os.environ, own), warnings.catch_warnings():
            warnings.simplefilter("ignore")
            nbclient.NotebookClient(notebook, kernel_name="python3", timeout=600).execute()
        nbformat.validate(notebook)
        nbformat.write(notebook, self.folder / "print.ipynb")
        return [[out for out in cell["outputs"] if out["output_type"] == "execute_result"] for cell in notebook.cells]

    def test_the_page_of_a_notebook(self):
        outputs = self.outputs()
        self.assertEqual(outputs[1][0]["data"]["text/plain"], "True")
        shown = [outputs[cell][0]["data"]["text/html"] for cell in (2, 3)]
        facts = ["program", "reasons"]
        page = self.folder / "notebook.html"
        page.write_text("<!DOCTYPE html><title>a notebook</title><style>iframe { display: block }</style>" + "\n".join(shown))
        self.assertEqual(Frames(page.read_text()).tags.count("iframe"), 2)
        for kind, one in zip(facts, shown):
            alone = self.folder / f"{kind}.html"
            alone.write_text(f"<!DOCTYPE html><title>a cell</title>{one}")
            self.opened(alone, kind)

    def opened(self, page, kind):
        """In a browser: the frame draws, complains of nothing, asks nothing of the network, and cannot reach the notebook."""
        if BROWSER is None:
            left_out("Chromium is not installed: the notebook's page is not opened")
        # With more rights it would be no page of its own, for which the driver waits.
        self.assertEqual([frame["sandbox"] for frame in Frames(page.read_text()).frames], ["allow-scripts"])
        outside = "(() => { try { return String(top.document.title); } catch (error) { return error.name; } })()"
        steps = [
            {"frame": "ready.then(() => facts.kind)"},
            {"frame": outside},
            {"frame": "document.querySelector('canvas').width > 0"},
            {"eval": "document.querySelector('iframe').contentDocument === null"},
        ]
        driver = [sys.executable, ROOT / "tests/it/preview/chromium.py", BROWSER, page, "1100", "700"]
        run = subprocess.run(list(map(str, driver)), input=json.dumps(steps), capture_output=True, text=True, timeout=900)
        self.assertEqual(run.returncode, 0, run.stderr)
        answer = json.loads(run.stdout)
        self.assertEqual(answer["results"], [kind, "SecurityError", True, True])
        self.assertEqual(answer["console"], [])
        self.assertEqual([one for one in answer["requests"] if not one.startswith(("file:///", "about:srcdoc", "data:"))], [])


if __name__ == "__main__":
    unittest.main()
