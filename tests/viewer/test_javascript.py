"""The front-end's modules: pure functions under node, and all of them as one text for notebooks."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from airlight.bundling import bundled

HERE = Path(__file__).parent
WEB = HERE.parents[1] / "src" / "airlight" / "viewer" / "web"
NODE = shutil.which("node")
needs_node = pytest.mark.skipif(NODE is None, reason="needs node")


def run(*words: str, text: str = "") -> str:
    assert NODE is not None
    done = subprocess.run([NODE, *words], input=text, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@needs_node
@pytest.mark.parametrize("file", sorted((HERE / "js").glob("*.test.mjs")), ids=lambda file: file.stem)
def test_pure_functions(file: Path) -> None:
    run("--no-warnings", "--test", str(file))


@needs_node
def test_the_front_end_is_one_text_for_notebooks() -> None:
    text = bundled(WEB, "app.js")
    told = run("--no-warnings", "--input-type=module", text=text + "\nconsole.log(typeof of_app.default_.render);")
    assert told.strip() == "function"
    assert not re.search(r"^(import|export) (?!default of_app)", text, re.MULTILINE)


def test_modules_are_put_together(tmp_path: Path) -> None:
    (tmp_path / "inner").mkdir()
    inner = ['import { one } from "../c.js";', "export const two = one + 1;", "export function f() {}"]
    (tmp_path / "inner" / "b.js").write_text("\n".join([*inner, ""]))
    (tmp_path / "c.js").write_text("export const one = 1;\n")
    (tmp_path / "d.js").write_text("export default { nothing: 0 };\n")
    entry = ['import { two as zwei, f } from "./inner/b.js";', 'import { one } from "./c.js";']
    entry += ['import { default as none } from "./d.js";', "export default { three: zwei + one + none.nothing, f };", ""]
    (tmp_path / "a.js").write_text("\n".join(entry))
    text = bundled(tmp_path, "a.js")
    assert text.count("const one = 1;") == 1
    assert text.endswith("export default of_a.default_;\n")
    if NODE is not None:
        told = run("--no-warnings", "--input-type=module", text=text + "\nconsole.log(of_a.default_.three);")
        assert told.strip() == "3"


def test_nothing_is_loaded_from_elsewhere() -> None:
    for file in WEB.rglob("*"):
        if file.suffix in (".js", ".css", ".html"):
            text = file.read_text(encoding="utf-8").replace("http://www.w3.org/2000/svg", "")
            assert not re.search(r"https?://|innerHTML|insertAdjacentHTML|eval\(|@import", text), file
