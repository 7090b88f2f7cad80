"""The report works in a browser: alone, sortable, filterable, moving, on any screen."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from browser import CHROMIUM, DRIVER, MISSING, chromium, prefer, requested, resize
from places import ROOT
from records import instant, made_up
from refusals import refused
from research.reproduction import runner
from research.reproduction.claims.atomic import ATOMIC_CLAIMS
from research.reproduction.claims.counting import Count
from research.reproduction.claims.experiments import EXPERIMENTS
from research.reproduction.claims.findings import findings
from research.reproduction.export import read_study_csv
from research.reproduction.plan import plan
from research.reproduction.record import Record
from research.reproduction.report.page import first_finding, report_page
from research.reproduction.table import tabulate
from tegotae.figures.style import new_figure, save_figure

in_browser = pytest.mark.skipif(CHROMIUM is None or DRIVER is None, reason=MISSING)


def records() -> list[Record]:
    """Made-up results of the smallest study, one model without a single limit cycle."""
    made = [made_up(unit) for unit in plan("smoke").units]
    missing = next(i for i, record in enumerate(made) if record.model == "T-Fv")
    undefined = {name: np.full((2, 2), np.nan, "float32") for name in ("cot_inverse", "t0_s")}
    undefined["limit_cycle_share"] = np.zeros((2, 2), "float32")
    made[missing] = replace(made[missing], episodes=made[missing].episodes | undefined)
    return made


RECORDS = records()
ARCHITECTURES = sorted({str(a) for a in tabulate(RECORDS)["architecture"]})


@pytest.fixture(scope="module")
def html(tmp_path_factory) -> str:
    experiments = tmp_path_factory.mktemp("experiments")
    save_figure(new_figure(), experiments / "gain_map.png")
    return report_page(RECORDS, "A study </script><b>made up</b>.", experiments)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as driver:
        yield driver


@pytest.fixture
def page(browser, html, tmp_path):
    """The report, opened from a file on a large screen."""
    path = tmp_path / "report.html"
    path.write_text(html, encoding="utf-8")
    resize(browser, 1300)
    prefer(browser)
    browser.get_log("browser")
    requested(browser)
    browser.get(path.as_uri())
    return browser


def until(page, condition: str):
    """Wait for a JavaScript expression to be true; what it gave."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(page, 20).until(lambda p: p.execute_script(f"return {condition}"))


def column(page, label: str) -> list[str]:
    """Return the cells of a column of the table of models, from top to bottom."""
    return page.execute_script(
        """
        const heads = [...document.querySelectorAll("#models th")];
        const i = heads.findIndex((th) => th.textContent === arguments[0]);
        const rows = [...document.querySelectorAll("#models tbody tr")];
        return rows.map((row) => row.cells[i].textContent);
        """,
        label,
    )


def heading(page, label: str):
    """The heading of a column of the table of models."""
    from selenium.webdriver.common.by import By

    return page.find_element(By.XPATH, f"//*[@id='models']//th[button[text()='{label}']]")


def pixels(page) -> str:
    return page.execute_script("return document.getElementById('hop').toDataURL()")


def colours(page, canvas: str) -> int:
    """Return the number of colours that a canvas shows."""
    return page.execute_script(
        """
        const canvas = document.getElementById(arguments[0]);
        const all = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
        return new Set(new Uint32Array(all.buffer)).size;
        """,
        canvas,
    )


def element(page, selector: str):
    from selenium.webdriver.common.by import By

    return page.find_element(By.CSS_SELECTOR, selector)


# The page.


@in_browser
def test_names_cannot_end_the_script_that_holds_the_data(page) -> None:
    assert element(page, "#about").text == "A study </script><b>made up</b>."


@in_browser
def test_it_needs_nothing_but_itself(page) -> None:
    until(page, "Number(document.getElementById('hop').dataset.frame) > 2")
    assert page.get_log("browser") == []
    elsewhere = [url for url in requested(page) if not url.startswith("data:")]
    assert elsewhere == [page.current_url]


@in_browser
@pytest.mark.parametrize("width", [1300, 390])
def test_nothing_is_wider_than_the_screen(page, width) -> None:
    resize(page, width)
    until(page, f"innerWidth === {width}")
    assert page.execute_script("return document.documentElement.scrollWidth") <= width
    # What is wider than its box can be scrolled there.
    cut = """return [...document.querySelectorAll("main *")].filter((e) =>
        e.scrollWidth > e.clientWidth + 1 && getComputedStyle(e).overflowX === "hidden"
        && !e.classList.contains("hidden")).map((e) => e.outerHTML.slice(0, 80))"""
    assert page.execute_script(cut) == []


@in_browser
def test_its_contents_lead_to_every_section(page) -> None:
    links = page.execute_script(
        "return [...document.querySelectorAll('nav a')].map((a) => a.getAttribute('href'))"
    )
    sections = page.execute_script(
        "return [...document.querySelectorAll('main > section')].map((s) => '#' + s.id)"
    )
    assert links == sections
    assert len(links) >= 5


@in_browser
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_it_has_the_colours_that_the_user_prefers_and_can_be_told_others(page, scheme) -> None:
    prefer(page, color_scheme=scheme)
    page.refresh()
    lightness = """(() => { const c = getComputedStyle(document.body).backgroundColor;
        return Math.max(...c.match(/\\d+/g).slice(0, 3)) > 127 ? "light" : "dark"; })()"""
    assert page.execute_script(f"return {lightness}") == scheme
    element(page, "#theme").click()
    assert page.execute_script(f"return {lightness}") != scheme


# The claims.


@in_browser
def test_every_claim_stands_in_the_papers_words_the_headline_first(page) -> None:
    rows = page.execute_script(
        "return [...document.querySelectorAll('#claims tr.part')].map((tr) => tr.textContent)"
    )
    message = element(page, "#unmeasured").text
    unmeasured = len(ATOMIC_CLAIMS) - len(rows)
    assert message.startswith(f"{unmeasured} of {len(ATOMIC_CLAIMS)} statements are not measured")
    assert 0 < len(rows) < 10, "there are three models"
    assert not any("not measured" in row for row in rows)
    headline = [claim.name for claim in ATOMIC_CLAIMS if claim.headline]
    measured = [name for name in headline if any(name in row for row in rows)]
    assert all(name in row for name, row in zip(measured, rows, strict=False))
    for script in ("experiments.figure3", "gain-map", "experiments.parameter_limit"):
        assert message.count(script) == 1


# The models.


@in_browser
@pytest.mark.parametrize("label", ["Model", "CoT⁻¹", "T0", "Fitness"])
def test_models_are_sorted_both_ways_with_what_is_undefined_last(page, label) -> None:
    def values() -> list:
        texts = [text.replace("−", "-") for text in column(page, label)]
        return texts if label == "Model" else [float(x) if x != "–" else None for x in texts]

    def last_undefined(numbers: list) -> list:
        return [x for x in numbers if x is not None] + [x for x in numbers if x is None]

    directions = set()
    for _ in range(2):
        heading(page, label).find_element("tag name", "button").click()
        direction = heading(page, label).get_attribute("aria-sort")
        cells = values()
        defined = [x for x in cells if x is not None]
        assert defined == sorted(defined, reverse=direction == "descending")
        assert cells == last_undefined(cells)
        assert len(cells) == len(RECORDS)
        directions.add(direction)
    assert directions == {"ascending", "descending"}
    assert (None in values()) == (label in ("CoT⁻¹", "T0"))


@in_browser
def test_sorting_works_from_the_keyboard(page) -> None:
    from selenium.webdriver.common.keys import Keys

    previous = column(page, "Model")
    heading(page, "Model").find_element("tag name", "button").send_keys(Keys.ENTER)
    assert heading(page, "Model").get_attribute("aria-sort") == "ascending"
    assert column(page, "Model") == sorted(previous)


@in_browser
def test_models_are_filtered_by_words_and_by_their_design(page) -> None:
    search = element(page, "#filter")
    search.send_keys("art w8")
    assert column(page, "Model") == ["ART-rF-tphif-w8"]
    assert element(page, "#count").text == "1 of 3 models"
    search.send_keys(" nothing")
    assert column(page, "Model") == []
    assert element(page, "#models .empty").is_displayed()
    page.refresh()
    for name, value, expected in (
        ("architecture", "V", {"V-sector-w8"}),
        ("observation", "F_k, ẏ", {"T-Fv"}),
        ("omega_t", "8", {"V-sector-w8", "ART-rF-tphif-w8"}),
    ):
        choice = element(page, f"[data-filter={name}]")
        choice.find_element("css selector", f"option[value='{value}']").click()
        assert set(column(page, "Model")) == expected
        choice.find_element("css selector", "option[value='']").click()
    assert len(column(page, "Model")) == 3


# Each model.


@in_browser
@pytest.mark.parametrize("architecture", ARCHITECTURES)
def test_every_architecture_leads_to_its_best_model_whose_hop_moves(page, architecture) -> None:
    page.execute_script(
        "document.querySelector(`#pick input[value='${arguments[0]}']`).click()", architecture
    )
    assert element(page, "#model-name").text.endswith(f"the best {architecture}")
    assert colours(page, "surface") > 10
    first = pixels(page)
    until(page, f"document.getElementById('hop').toDataURL() !== {first!r}")


@in_browser
def test_a_name_in_the_table_leads_to_the_section_of_that_model_and_so_does_its_address(page):
    page.execute_script("document.querySelector(`#models a[href$='T-Fv']`).click()")
    until(page, "document.getElementById('model-name').textContent.startsWith('T-Fv')")
    assert element(page, "#model").get_attribute("value") == "T-Fv"
    page.get(page.current_url)
    page.refresh()
    assert element(page, "#model-name").text.startswith("T-Fv")
    texts = page.execute_script(
        "return [...document.querySelectorAll('#facts tbody tr')].map((tr) => tr.textContent)"
    )
    # A model without a limit cycle has no CoT⁻¹, in the mean as in its run.
    assert "CoT⁻¹––" in texts


@in_browser
def test_on_paper_the_table_is_whole_and_controls_are_not_there(page) -> None:
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": "print"})
    assert not element(page, "#play").is_displayed()
    assert not element(page, "nav").is_displayed()
    hidden = "return getComputedStyle(document.getElementById('models')).overflowY"
    assert page.execute_script(hidden) == "visible"
    page.execute_cdp_cmd("Emulation.setEmulatedMedia", {"media": ""})


@in_browser
def test_pause_stops_the_animation_and_play_goes_on(page) -> None:
    button = element(page, "#play")
    until(page, "Number(document.getElementById('hop').dataset.frame) > 2")
    button.click()
    assert button.text == "Play"
    previous = pixels(page)
    # Sixty frames of the screen, a second, in which a playing animation would draw fifty times.
    page.execute_async_script(
        "const done = arguments[0]; let n = 60;"
        "const wait = () => n-- ? requestAnimationFrame(wait) : done(); wait();"
    )
    assert pixels(page) == previous
    button.click()
    assert button.text == "Pause"
    until(page, f"document.getElementById('hop').toDataURL() !== {previous!r}")


@in_browser
def test_who_prefers_less_motion_has_to_ask_for_it(page) -> None:
    prefer(page, reduced_motion="reduce")
    page.refresh()
    assert element(page, "#play").text == "Play"
    frame = "Number(document.getElementById('hop').dataset.frame)"
    assert page.execute_script(f"return {frame}") == 0
    element(page, "#play").click()
    until(page, f"{frame} > 2")


# What it is made from.


def test_it_begins_with_the_main_claim_its_number_and_its_figure(html):
    table = read_study_csv(ROOT / "research" / "reproduction" / "kept" / "study" / "paper.csv")
    results = findings(table, claims=ATOMIC_CLAIMS[:1], resamples=50, options=[Count()])
    first = first_finding(results, table)
    assert first is not None
    main = "The paper's main claim: learned feedback is more efficient than V. Here it is so."
    assert first["sentence"] == main
    assert str(first["number"]).startswith("+0.17 [0.1")
    assert "Of 1 ways to count the same runs: reproduced in 1, " in str(first["what"])
    sections = ("first", "claims-of-the-paper", "architectures")
    order = [html.index(f'id="{name}"') for name in sections]
    assert order == sorted(order)
    three_models = findings(tabulate(RECORDS), claims=ATOMIC_CLAIMS[:1], resamples=50)
    assert first_finding(three_models, tabulate(RECORDS)) is None


def test_every_picture_is_part_of_the_page(html) -> None:
    # Two of them are the optimum, and how training converged; three models have no correlations.
    of_the_study, of_experiments = 4, 1
    assert html.count("data:image/png") == of_the_study + of_experiments


def test_a_picture_that_is_none_is_named_in_one_line(tmp_path: Path) -> None:
    (tmp_path / EXPERIMENTS[0].figure).write_text("no picture")
    refused(r"figure3\.png is no PNG picture", lambda: report_page(RECORDS[:1], "", tmp_path))


def test_a_folder_of_experiments_that_is_not_there_is_refused(
    tmp_path: Path, capsys, one_line_error
) -> None:
    runner.run_study(plan("smoke", "V*"), tmp_path / "study", instant)
    capsys.readouterr()
    options = ("--dir", str(tmp_path / "study"), "--experiments", str(tmp_path / "nowhere"))
    assert "there is no folder" in one_line_error("reproduction", "report", *options)
    assert not (tmp_path / "study" / "report.html").exists()
