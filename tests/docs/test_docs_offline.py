"""Without a network the documentation shows its equations, in a real browser."""

import subprocess
import sys

import pytest

import browser
from pages import DOCS

pytest.importorskip("selenium")
for extra in ("furo", "myst_parser", "sphinx", "sphinx-mathjax-offline"):
    pytest.importorskip(extra)


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """A page with equations, built as all pages are."""
    folder = tmp_path_factory.mktemp("docs")
    source, html = folder / "source", folder / "html"
    source.mkdir()
    text = (DOCS / "concepts.md").read_text(encoding="utf-8")
    (source / "index.md").write_text(text, encoding="utf-8")
    completed = subprocess.run(
        [sys.executable, "-m", "sphinx", "-Q", "-c", DOCS, "-D", "html_static_path=", source, html],
        capture_output=True,
        text=True,
    )
    assert completed.returncode == 0, completed.stderr
    return html / "index.html"


@pytest.mark.skipif(not (browser.CHROMIUM and browser.DRIVER), reason=browser.MISSING)
@pytest.mark.thorough
def test_equations_are_drawn_without_a_network(page, tmp_path):
    with browser.chromium(tmp_path) as driver:
        driver.execute_cdp_cmd("Network.enable", {})
        offline = {"offline": True, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0}
        driver.execute_cdp_cmd("Network.emulateNetworkConditions", offline)
        driver.get(page.as_uri())
        # Typeset, as MathJax itself tells.
        equations, drawn = driver.execute_async_script(
            "const done = arguments[0];"
            "const count = () => done([document.querySelectorAll('.math').length,"
            " document.querySelectorAll('.math mjx-container').length]);"
            "if (window.MathJax?.startup?.promise) MathJax.startup.promise.then(count);"
            "else count();"
        )
        assert equations > 10
        assert drawn >= equations
        assert not [url for url in browser.requested(driver) if url.startswith("http")]
