"""The order of the house: imports only go down, and each foreign library has one door."""

import ast
from pathlib import Path

import pytest

import parsph

PACKAGE = Path(parsph.__file__).parent

# Top to bottom, as a reader meets it: a module may import from rows above its own and, inside a package, from its own row.
ROWS = """
errors
files jit memory parallel schedule timing
formula linear
particles
flows kernels states waves
analysis measured viz
columns geometry wavemakers
terms damping walls
relaxation
sweep
moments reinitialisation
domain stepping
observers
io
bodies
simulation
progress
traffic
scene
run examine residuals
study
bench verify
scaling stability throughput
cli
__main__
"""
ROW_OF = {name: row for row, line in enumerate(ROWS.split("\n")) for name in line.split()}
LAZY = {"__init__", "cli"}  # they import what a command needs when it is called, so those imports do not count
TALKING = {"cli", "examine", "progress", "run", "bench", "scaling", "throughput", "verify", "scene.plan", "scene.forecast"}

MODULES = {
    ".".join(path.relative_to(PACKAGE).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(PACKAGE.rglob("*.py"))
}
every_module = pytest.mark.parametrize("name", MODULES)


def tree_of(name):
    return ast.parse(MODULES[name].read_text(encoding="utf-8"))


def package_of(name):
    """Name of the package that relative imports of the module `name` start from."""
    parts = [] if name == "__init__" else name.split(".")
    return parts if MODULES[name].name == "__init__.py" else parts[:-1]


def imports_of(name):
    """Return (absolute names of modules imported, whether at the top of the module) of a module of the package."""
    tree, found = tree_of(name), []
    for node in ast.walk(tree):
        at_top = node in tree.body
        if isinstance(node, ast.Import):
            found += [(alias.name, at_top) for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level:
            base = package_of(name)
            base = base[: len(base) - node.level + 1]
            module = [*base, *(node.module.split(".") if node.module else [])]
            for alias in node.names:
                found.append((".".join(["parsph", *(module or [alias.name])]), at_top))
        elif isinstance(node, ast.ImportFrom):
            found.append((node.module, at_top))
    return found


def test_every_module_has_a_row():
    assert {name.split(".")[0] for name in MODULES} - {"__init__"} <= set(ROW_OF)


@every_module
def test_imports_only_go_down(name):
    own = name.split(".")[0]
    row = ROW_OF.get(own, -1)
    for target, at_top in imports_of(name):
        if not target.startswith("parsph.") or (name in LAZY and not at_top):
            continue
        other = target.split(".")[1]
        if other not in ROW_OF:  # a name of parsph/__init__.py, such as __version__
            assert other.startswith("__"), f"{name} imports {target}"
            continue
        if name == "__init__":
            assert other == "errors", "the package itself must load at once"
            continue
        assert ROW_OF[other] < row or other == own, f"{name} imports {target}, which stands in a row below it"


@every_module
@pytest.mark.parametrize(("library", "door"), [("numba", "jit"), ("mpi4py", "parallel"), ("shapely", "geometry")])
def test_each_foreign_library_has_one_door(name, library, door):
    roots = {target.split(".")[0] for target, _ in imports_of(name)}
    assert library not in roots or name == door


def test_the_doors_are_used():
    """Were a door renamed, the test above would pass for nothing."""
    assert "numba" in {target.split(".")[0] for target, _ in imports_of("jit")}
    assert "mpi4py" in {target.split(".")[0] for target, _ in imports_of("parallel")}


@every_module
def test_only_what_talks_to_the_user_prints(name):
    calls = [node.func for node in ast.walk(tree_of(name)) if isinstance(node, ast.Call)]
    prints = [call.lineno for call in calls if isinstance(call, ast.Name) and call.id == "print"]
    assert not prints or name in TALKING, f"{name} prints in lines {prints}"


def public(nodes):
    kinds = (ast.FunctionDef, ast.ClassDef)
    return [node for node in nodes if isinstance(node, kinds) and not node.name.startswith("_")]


# An overridden method is described where it is first defined.
DESCRIBED = {
    method.name
    for name in MODULES
    for kind in public(tree_of(name).body)
    if isinstance(kind, ast.ClassDef)
    for method in public(kind.body)
    if ast.get_docstring(method)
}


@every_module
def test_everything_public_has_a_docstring(name):
    tree = tree_of(name)
    assert ast.get_docstring(tree), f"{name} has none"
    for node in public(tree.body):
        assert ast.get_docstring(node), f"{name}.{node.name} has none"
        for method in public(node.body) if isinstance(node, ast.ClassDef) else []:
            assert method.name in DESCRIBED, f"{name}.{node.name}.{method.name} has none"


@every_module
def test_user_input_is_not_checked_by_assert(name):
    """``python -O`` drops assertions; bad input needs an error with a cure."""
    assert not [node.lineno for node in ast.walk(tree_of(name)) if isinstance(node, ast.Assert)]
