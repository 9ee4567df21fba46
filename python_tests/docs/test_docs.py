"""The documentation: its links lead somewhere, its snippets run, its command lines exist."""

import ast
import importlib.util
import os
import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
import typer

from checkout import BUILD, TOP
from hnav.cli.app import COMMANDS, load
from hnav.io.recordings import Recording
from motion import tilted_motion
from studies.command import app_of
from studies.plausibility.good import good_recording

README = TOP / "README.md"
PAGES = [README, TOP / "CHANGELOG.md", TOP / "SECURITY.md", *sorted((TOP / "docs").glob("*.md"))]
FMUS = Path(os.environ.get("HNAV_FMUS", BUILD / "fmus"))
LIBRARY = Path(os.environ.get("HNAV_LIBRARY", BUILD / "c_src" / "libhnav.so"))

FENCE = re.compile(r"^```(\w*)[^\n]*\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
COMMENT = re.compile(r"\s{2,}.*$")


def blocks(language: str) -> list:
    """Fenced blocks as parameters named after page and number."""
    found = []
    for page in PAGES:
        texts = [text for kind, text in FENCE.findall(page.read_text()) if kind == language]
        found += [pytest.param(text, id=f"{page.stem}-{number}") for number, text in enumerate(texts, 1)]
    return found


# ------------------------------------------------------------------------------------------------ links


def anchors(page: Path) -> set[str]:
    """As GitHub and MkDocs make them of headings: lower case, no punctuation, spaces to hyphens."""
    headings = re.findall(r"^#{1,6}\s+(.*)$", FENCE.sub("", page.read_text()), re.MULTILINE)
    plain = [re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).lower() for heading in headings]
    return {re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", heading).strip()) for heading in plain}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_every_relative_link_leads_to_a_file_and_a_heading(page):
    broken = []
    for link in LINK.findall(FENCE.sub("", page.read_text())):
        if "://" in link or link.startswith("mailto:"):
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        if not target.exists() or (anchor and anchor not in anchors(target)):
            broken.append(link)
    assert broken == []


# ------------------------------------------------------------------------------------------------ snippets


def write_recording(path: Path, r: Recording) -> None:
    table = np.column_stack([r.t_s, r.rate_b_rad_s, r.force_b_m_s2, r.field_b_tesla])
    np.savetxt(path, table, fmt="%.9g", delimiter=",", header="t_s,gx,gy,gz,ax,ay,az,mx,my,mz", comments="")


@pytest.fixture(scope="module")
def recordings(tmp_path_factory) -> Path:
    """The files that the names in the snippets stand for."""
    folder = tmp_path_factory.mktemp("recordings")
    write_recording(folder / "flight.csv", tilted_motion(3).recording)
    write_recording(folder / "tumbled.csv", tilted_motion(30).recording)
    write_recording(folder / "walk.csv", good_recording("hand", "consumer", seed=10))
    return folder


@pytest.fixture
def scratch(tmp_path, recordings, monkeypatch) -> Path:
    """A folder with recordings and a build, as the checkout has them."""
    for recording in recordings.iterdir():
        shutil.copy(recording, tmp_path)
    if FMUS.is_dir():
        (tmp_path / "build").mkdir()
        (tmp_path / "build" / "fmus").symlink_to(FMUS.resolve())
        (tmp_path / "build" / "ssp").symlink_to((BUILD / "ssp").resolve())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def inputs_that_the_reader_has() -> dict:
    """Names that snippets use and leave to the reader: an input signal of two seconds at rest."""
    names = [f"{sensor}[{i}]" for sensor in ("gyro.rate", "accel.force", "mag.field") for i in (1, 2, 3)]
    signal = np.zeros(201, dtype=[("time", float), *((name, float) for name in names)])
    signal["time"] = 0.01 * np.arange(201)
    signal["accel.force[3]"], signal["mag.field[1]"], signal["mag.field[3]"] = -9.81, 2e-5, 4.5e-5
    return {"signal": signal}


@pytest.mark.usefixtures("scratch")
@pytest.mark.parametrize("code", blocks("python"))
def test_a_python_snippet_runs(code):
    if "BROAD_DIR" in code and not os.environ.get("BROAD_DIR"):
        pytest.skip("BROAD_DIR is not set: no BROAD recordings")
    if ("fmu" in code or "simulate" in code) and not FMUS.is_dir():
        pytest.skip(f"{FMUS} is not built")
    given = {name: value for name, value in inputs_that_the_reader_has().items() if name in names_read(code)}
    exec(compile(code, "snippet", "exec"), {"__name__": "snippet", **given})


@pytest.mark.usefixtures("scratch")
def test_the_readme_says_what_its_snippet_prints(capsys):
    text = README.read_text()
    ((code, printed),) = re.findall(r"^```python\n(.*?)^```\n\n```text\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    exec(compile(code, "snippet", "exec"), {"__name__": "snippet"})
    assert capsys.readouterr().out == printed


def names_read(code: str) -> set[str]:
    """Names that are read and never assigned."""
    names = [node for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Name)]
    return {n.id for n in names if isinstance(n.ctx, ast.Load)} - {n.id for n in names if isinstance(n.ctx, ast.Store)}


# Statements that stand alone become a program: two seconds of a level body, and what the reader would supply.
PROGRAM = """
#include <stdio.h>
%(includes)s
static double t_s; static int rounds;
static const double rate_b_rad_s[3] = {0, 0, 0}, force_b_m_s2[3] = {0, 0, -9.81}, field_b_tesla[3] = {2e-5, 0, 4.5e-5};
static void use(const hnav_attitude *attitude) {
    if (++rounds < 200) t_s += 0.01;
    else printf("%%.6f\\n", attitude->q_nb[0]);
}
int main(void) {
%(body)s
    return 0;
}
"""


def as_program(code: str) -> str:
    if "int main" in code:
        return code
    lines = code.splitlines()
    includes = "\n".join(line for line in lines if line.startswith("#include"))
    body = "\n".join(line for line in lines if not line.startswith("#include"))
    return PROGRAM % {"includes": includes, "body": body.replace("for (;;)", "while (rounds < 200)")}


@pytest.mark.parametrize("code", blocks("c"))
def test_a_c_snippet_compiles_without_a_warning_and_runs(code, tmp_path):
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None or not LIBRARY.is_file():
        pytest.skip("no C compiler, or the library is not built")
    source, program = tmp_path / "snippet.c", tmp_path / "snippet"
    source.write_text(as_program(code))
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", f"-I{TOP / 'c_src' / 'include'}"]
    made = subprocess.run(
        [compiler, *flags, str(source), str(LIBRARY), f"-Wl,-rpath,{LIBRARY.parent.resolve()}", "-lm", "-o", str(program)],
        capture_output=True,
        text=True,
    )
    assert made.returncode == 0, made.stderr
    ran = subprocess.run([str(program)], capture_output=True, text=True, timeout=60)
    assert ran.returncode == 0 and ran.stdout.strip(), ran.stderr


def test_the_compile_line_of_the_readme_makes_a_program(tmp_path):
    (line,) = re.findall(r"^    (gcc .*)$", README.read_text(), re.MULTILINE)
    if shutil.which("gcc") is None or not LIBRARY.is_file():
        pytest.skip("no gcc, or the library is not built")
    program = next(code for kind, code in FENCE.findall(README.read_text()) if kind == "c")
    (tmp_path / "c_src").symlink_to(TOP / "c_src")
    (tmp_path / "build").mkdir()
    (tmp_path / "build" / "c_src").symlink_to(LIBRARY.resolve().parent)
    stated = re.findall(r"(?<= )\.\d{3}\b", program)  # sigma after 2 s, and after 10 s
    for steps, sigma in zip((200, 1000), stated, strict=True):
        (tmp_path / "heading.c").write_text(program.replace("k <= 200", f"k <= {steps}"))
        done = subprocess.run(line, shell=True, capture_output=True, text=True, cwd=tmp_path, timeout=60)
        assert done.returncode == 0 and done.stdout.startswith("heading "), done.stderr
        assert done.stdout.endswith(f"sigma 0{sigma} rad\n")


# ------------------------------------------------------------------------------------------------ command lines


def command_lines(pages: Sequence[Path] = PAGES) -> list:
    """Every ./run ... of an indented block, a fence or inline code; a description behind two spaces does not belong to it."""
    found = {}
    for page in pages:
        text = page.read_text()
        inline = re.findall(r"`(\./run [^`]+)`", text)
        lines = re.findall(r"^ {4,}((?:\./run|hnav) [^\n]*)$", text, re.MULTILINE)
        indented = [re.sub("^hnav ", "./run hnav ", COMMENT.sub("", line.strip())) for line in lines]
        for line in [*inline, *indented]:
            for command in re.split(r"\s*(?:&&|#)\s*", " ".join(line.split())):
                if command.startswith("./run "):
                    found.setdefault(command, page.stem)
    return [pytest.param(command, id=f"{page}: {command}") for command, page in found.items()]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_a_command_is_laid_out_as_one(page):
    assert re.findall(r"^(?:\./run|cmake) .*$", FENCE.sub("", page.read_text()), re.MULTILINE) == []


# They build, check and run everything else, here or in the CI; `docs` is tested in test_site.py.
NOT_RUN_HERE = ("./run test", "./run demo", "./run release", "./run docs")


def lines_of_the_readme() -> list[str]:
    found = [line.values[0] for line in command_lines([README])]
    return [line for line in found if not line.startswith(NOT_RUN_HERE)]


@pytest.mark.parametrize("line", lines_of_the_readme())
def test_a_command_of_the_readme_runs(line, scratch, request):
    words = shlex.split(line)[1:]
    if "DIR" in words:
        trial = next(iter(request.getfixturevalue("broad_trials").values()))
        (scratch / "DIR").mkdir()
        (scratch / "DIR" / trial.name).symlink_to(trial)
    module = ["hnav", *words[1:]] if words[0] == "hnav" else ["studies", *words[1:]]
    environment = os.environ | {"PYTHONPATH": str(TOP / "python"), "HNAV_LIBRARY": str(LIBRARY)}
    done = subprocess.run([sys.executable, "-m", *module], capture_output=True, text=True, env=environment, timeout=120)
    assert done.returncode == 0, done.stderr
    if "--report" in words:
        assert "</html>" in Path(words[words.index("--report") + 1]).read_text()


def test_the_readme_is_short():
    assert len(README.read_text().splitlines()) <= 110


def test_nothing_is_said_to_be_published():
    assert [page.name for page in PAGES if re.search(r"pip install '?hnav\b", page.read_text())] == []


def modules() -> list[str]:
    return sorted({name for page in PAGES for name in re.findall(r"-m ((?:hnav|makers|studies|twins)[\w.]*)", page.read_text())})


@pytest.mark.parametrize("module", modules())
def test_a_module_that_is_to_be_run_exists(module):
    found = importlib.util.find_spec(module)
    if found is not None and found.submodule_search_locations:
        found = importlib.util.find_spec(f"{module}.__main__")
    assert found is not None and "__main__" in Path(found.origin).read_text(), f"python -m {module} does nothing"


def run_commands() -> set[str]:
    """The commands that the script answers to, from its last case."""
    script = (TOP / "run").read_text()
    return set(re.findall(r"^  ([a-z]+)(?: \||\))", script[script.rindex("case $command in") :], re.MULTILINE))


@pytest.mark.parametrize("line", command_lines())
def test_a_command_line_names_commands_and_options_that_exist(line):
    words = shlex.split(re.sub(r"[\[\]|]", " ", line.partition(" > ")[0]))[1:]
    assert words[0] in run_commands(), f"./run has no command {words[0]}"
    if words[0] == "hnav" and len(words) > 1 and words[1].islower() and not words[1].startswith("-"):
        assert words[1] in COMMANDS, f"hnav has no command {words[1]}"
        known = options_of(load(words[1]))
    elif words[0] == "study" and len(words) > 1 and words[1].islower():
        known = study_options(words[1])
    else:
        return
    assert [word for word in words[2:] if word.startswith("--") and word.split("=")[0] not in known] == []
    if words[0] == "hnav" and "..." not in words:
        assert words_that_are_no_argument(load(words[1]), words[2:]) == []


def words_that_are_no_argument(command, words: list[str]) -> list[str]:
    """Words beyond the options and arguments that a command takes."""
    import click

    with click.Context(command) as context:
        return list(command.make_parser(context).parse_args(list(words))[1])


def options_of(command) -> set[str]:
    return {name for parameter in command.params for name in (*parameter.opts, *parameter.secondary_opts)} | {"--help"}


def study_options(name: str) -> set[str]:
    assert importlib.util.find_spec(f"studies.{name}") is not None, f"there is no study {name}"
    return options_of(typer.main.get_command(app_of(name)))
