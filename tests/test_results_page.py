"""The page of results is what its generator makes of the tables, and shows figures that are there."""

import importlib.util
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[1] / "docs"


@pytest.fixture(scope="module")
def generator():
    spec = importlib.util.spec_from_file_location("results", DOCS / "results.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_page_is_that_of_the_tables(generator):
    assert (DOCS / "results.md").read_text(encoding="utf-8") == generator.page()


def test_its_figures_and_tables_are_there(generator):
    shown = re.findall(r"\]\((figures/[^)]+)\)", generator.page())
    assert len(shown) == len(set(shown)) == 13
    assert sorted(shown) == sorted(path.relative_to(DOCS).as_posix() for path in (DOCS / "figures").iterdir())
    assert sorted(path.name for path in (DOCS / "tables").iterdir()) == sorted(generator.TABLES)


def test_another_number_makes_another_page(generator, monkeypatch, tmp_path):
    (tmp_path / "tables").mkdir()
    for path in (DOCS / "tables").iterdir():
        text = path.read_text(encoding="utf-8")
        (tmp_path / "tables" / path.name).write_text(text.replace('"value": 0.0,', '"value": 0.125,'), encoding="utf-8")
    before = generator.page()
    monkeypatch.setattr(generator, "HERE", tmp_path)
    assert generator.page() != before
    assert "| part of the run that is missing | 0.125 |" in generator.page()
