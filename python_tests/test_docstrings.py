"""What is public has a docstring: modules, functions, classes, methods, and fields by the string that follows them."""

import ast
import importlib
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parents[1] / "python" / "hnav"
FOLDERS = ("native", "filters", "simulation")
MODULES = sorted(
    [*(p for folder in FOLDERS for p in (PACKAGE / folder).glob("*.py") if p.name != "_hnav.py"), *PACKAGE.glob("*.py")]
)


def public(body: list[ast.stmt]):
    """Functions and classes that are for others, those in classes by their class."""
    for node in body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef) and not node.name.startswith("_"):
            yield node.name, node
            if isinstance(node, ast.ClassDef):
                yield from ((f"{node.name}.{name}", inner) for name, inner in public(node.body))


def fields_without_a_word(node: ast.ClassDef):
    for field, follower in zip(node.body, [*node.body[1:], None]):
        documented = isinstance(follower, ast.Expr) and isinstance(follower.value, ast.Constant)
        if isinstance(field, ast.AnnAssign) and not documented and not ast.unparse(field.annotation).startswith("ClassVar"):
            yield f"{node.name}.{ast.unparse(field.target)}"


@pytest.mark.parametrize("path", MODULES, ids=lambda p: p.relative_to(PACKAGE).as_posix())
def test_what_is_public_is_documented(path):
    tree = ast.parse(path.read_text())
    silent = [] if ast.get_docstring(tree) or path.name == "__main__.py" else ["the module"]
    for name, node in public(tree.body):
        if not ast.get_docstring(node):
            silent.append(name)
        if isinstance(node, ast.ClassDef):
            silent += fields_without_a_word(node)
    assert silent == []


@pytest.mark.parametrize("name", importlib.import_module("hnav").__all__)
def test_names_of_the_package_are_documented(name):
    value = getattr(importlib.import_module("hnav"), name)
    assert isinstance(value, str) or (value.__doc__ and len(value.__doc__) > 20)
