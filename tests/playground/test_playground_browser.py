"""The playground in a browser: every control does what it says, by mouse, keyboard and touch."""

import html
import re

import numpy as np
import pytest

from apps.playground import Page, standard
from apps.playground.standard import DEMO
from browser import CHROMIUM, DRIVER, MISSING, chromium, prefer, requested, resize
from pages import DOCS
from played import PLAYED, all_that_can_happen, arrays, assert_same
from tegotae.api.demo import CONTROLLER
from tegotae.systems.resolve import resolve
from tegotae.training.collection import controller_of

pytestmark = pytest.mark.skipif(CHROMIUM is None or DRIVER is None, reason=MISSING)


@pytest.fixture(scope="module")
def browser(tmp_path_factory):
    with chromium(tmp_path_factory.mktemp("profile")) as driver:
        driver.set_script_timeout(60)
        yield driver


@pytest.fixture(scope="module")
def address(tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("page") / "page.html"
    path.write_text(Page(standard()).html(), encoding="utf-8")
    return path.as_uri()


def opened(browser, address: str, width: int = 1300, **features: str):
    """The page, paused; nothing but what a test does moves it."""
    resize(browser, width)
    prefer(browser, **features)
    browser.get_log("browser")
    requested(browser)
    browser.get(address)
    until(browser, "window.playground !== undefined")
    return browser


@pytest.fixture(scope="module")
def loaded(browser, address):
    return opened(browser, address)


@pytest.fixture
def page(loaded):
    """The page as it is after loading: the hopper, two controllers, nothing changed; paused."""
    script_result(loaded, 'await playground.takeBody("hopper"); playground.state.playing = false')
    loaded.execute_script("document.getElementById('release').click()")
    return loaded


def script_result(page, script: str):
    """Return the result of an asynchronous script."""
    return page.execute_async_script(
        "const [done] = [arguments[arguments.length - 1]];"
        f"(async () => {{ {script} }})().then(done, (error) => done('failed: ' + error))"
    )


def until(page, condition: str):
    """Wait for a JavaScript expression to be true; what it gave."""
    from selenium.webdriver.support.ui import WebDriverWait

    return WebDriverWait(page, 40).until(lambda p: p.execute_script(f"return {condition}"))


def click(page, name: str) -> None:
    page.execute_script("document.getElementById(arguments[0]).click()", name)


def slide(page, name: str, value: float) -> None:
    page.execute_script(
        "const input = document.getElementById('number-' + arguments[0]);"
        "input.value = arguments[1]; input.dispatchEvent(new Event('input'))",
        name,
        value,
    )


def of_lanes(page, name: str, index: int = 0) -> list[float]:
    """A number of the lanes of both sides."""
    return page.execute_script(
        "return playground.panes.map((pane) => pane.runner.lane.get(arguments[0], arguments[1]))",
        name,
        index,
    )


def advance(page, seconds: float) -> None:
    page.execute_script("playground.advance(arguments[0]); playground.draw()", seconds)


def pressed(page, key: str) -> None:
    from selenium.webdriver.common.action_chains import ActionChains

    ActionChains(page).send_keys(key).perform()


def test_the_engine_in_the_browser_moves_as_the_package_does(page):
    case = all_that_can_happen()
    record = page.execute_async_script(
        PLAYED + "const [task, done] = arguments;"
        "const name = playground.panes[1].runner.controller.engines.hopper;"
        "playground.engines.get(name).then((engine) => done(played(engine.lane(), task)))",
        case.task(),
    )
    assert_same(arrays(record), case.by_the_package())


def test_the_page_says_nothing_to_the_console_and_asks_the_network_for_nothing(page, address):
    advance(page, 5.0)
    assert page.get_log("browser") == []
    urls = [url for url in requested(page) if not url.startswith(("data:", "blob:"))]
    assert set(urls) <= {address}


def test_dropping_the_ground_lowers_it_on_both_sides_by_what_is_chosen(page):
    click(page, "drop")
    advance(page, 0.1)
    assert of_lanes(page, "channel.ground_m") == pytest.approx([-0.2, -0.2])
    click(page, "drop")
    advance(page, 0.1)
    assert of_lanes(page, "channel.ground_m") == pytest.approx([-0.4, -0.4])
    click(page, "release")
    assert of_lanes(page, "channel.ground_m") == [0.0, 0.0]


@pytest.mark.parametrize(("name", "speed"), [("push-up", 0.5), ("push-down", -0.5)])
def test_a_push_changes_the_velocity_at_once(page, name, speed):
    previous = of_lanes(page, "state.lane.moment.body.velocity")
    click(page, name)
    following = of_lanes(page, "state.lane.moment.body.velocity")
    assert np.subtract(following, previous) == pytest.approx([speed, speed])


def test_a_push_on_a_corner_turns_the_plate_too(page):
    script_result(page, 'await playground.takeBody("quadruped")')
    click(page, "push-up")
    rates = [of_lanes(page, "state.lane.moment.body.rate", mode)[0] for mode in range(3)]
    # v x / (j a²) about each axis, of the first hip at (0.5, 0.3).
    assert rates == pytest.approx([0.5, 0.5 * 0.5 / (0.6 * 0.25), 0.5 * 0.3 / (1.6 * 0.09)])


def test_a_frozen_oscillator_stands_still_and_a_thawed_one_moves(page):
    click(page, "frozen")
    advance(page, 0.1)
    previous = of_lanes(page, "channel.phase_rad")
    advance(page, 0.2)
    assert of_lanes(page, "channel.phase_rad") == previous
    click(page, "frozen")
    advance(page, 0.2)
    assert of_lanes(page, "channel.phase_rad") != previous


def test_release_puts_everything_back(page):
    click(page, "frozen")
    advance(page, 2.0)
    click(page, "release")
    assert of_lanes(page, "channel.time_s") == [0.0, 0.0]
    assert of_lanes(page, "channel.height_m") == pytest.approx([1.2, 1.2])
    assert of_lanes(page, "moving") == [1.0, 1.0]


@pytest.mark.parametrize(
    ("name", "entry", "value"),
    [
        ("omega", "omega", 6.0),
        ("mass_kg", "body.mass_kg", 0.12),
        ("stiffness_n_per_m", "body.stiffness_n_per_m", 7.0),
        ("gravity_m_per_s2", "body.gravity_m_per_s2", 5.0),
    ],
)
def test_a_slider_changes_its_number_on_both_sides_and_as_they_were_changes_it_back(
    page, name, entry, value
):
    standard = of_lanes(page, entry)
    slide(page, name, value)
    assert of_lanes(page, entry) == pytest.approx([value, value])
    click(page, "usual")
    assert of_lanes(page, entry) == standard


def test_inertias_are_changed_where_a_body_has_some(page):
    script_result(page, 'await playground.takeBody("quadruped")')
    for name in ("pitch_inertia_ratio", "roll_inertia_ratio"):
        slide(page, name, 2.0)
        assert of_lanes(page, f"body.{name}") == [2.0, 2.0]
    script_result(page, 'await playground.takeBody("bar")')
    slide(page, "inertia_ratio", 2.0)
    assert of_lanes(page, "body.inertia_ratio") == [2.0, 2.0]


def test_sigma_is_multiplied_where_it_is_a_number(page):
    slide(page, "sigma", 2.0)
    assert of_lanes(page, "weights")[0] == pytest.approx(2.0)  # V's own is 1


def test_a_leg_that_is_cut_bears_nothing_and_one_leg_stays(page):
    script_result(page, 'await playground.takeBody("bar")')
    click(page, "leg-F")
    assert of_lanes(page, "body.present", 1) == [0.0, 0.0]
    click(page, "leg-H")
    assert of_lanes(page, "body.present", 0) == [1.0, 1.0]
    advance(page, 0.6)
    assert of_lanes(page, "channel.spring_force_n", 1) == [0.0, 0.0]


def test_other_phases_are_those_of_a_new_release(page):
    script_result(page, 'await playground.takeBody("bar")')
    advance(page, 1.0)
    previous = of_lanes(page, "release.phase_rad", 1)
    click(page, "phases")
    assert of_lanes(page, "release.phase_rad", 1) != previous
    assert of_lanes(page, "channel.time_s") == [0.0, 0.0]


def test_a_body_is_chosen_by_its_name(page):
    for name, limbs in (("bar", 2), ("quadruped", 4), ("hopper", 1)):
        page.execute_script("document.querySelector(`[value=${arguments[0]}]`).click()", name)
        until(
            page,
            f"playground.state.busy === 0 && playground.panes[0].runner.body.limbs === {limbs}",
        )


def test_another_controller_drives_the_side_on_which_it_is_chosen(page):
    page.execute_script(
        "const chooser = playground.panes[0].chooser; chooser.value = '2';"
        "chooser.dispatchEvent(new Event('change'))"
    )
    until(page, "playground.panes[0].runner.controller.omega === 4")
    assert of_lanes(page, "omega") == [4.0, 8.0]
    page.execute_script(
        "const chooser = playground.panes[0].chooser; chooser.value = '0';"
        "chooser.dispatchEvent(new Event('change'))"
    )


def test_one_side_alone_is_shown_where_one_is_wanted(page):
    click(page, "compare")
    assert page.execute_script("return playground.panes[1].element.hidden")
    click(page, "compare")
    until(page, "playground.state.busy === 0 && !playground.panes[1].element.hidden")


def test_the_page_can_be_used_by_its_keys(page):
    page.execute_script("document.activeElement.blur()")
    pressed(page, " ")
    assert page.execute_script("return playground.state.playing")
    pressed(page, " ")
    assert not page.execute_script("return playground.state.playing")
    pressed(page, "r")
    pressed(page, "d")
    assert of_lanes(page, "ground_m") == pytest.approx([-0.2, -0.2])
    pressed(page, "f")
    assert of_lanes(page, "moving") == [0.0, 0.0]
    previous = of_lanes(page, "state.lane.moment.body.velocity")
    pressed(page, "p")
    following = of_lanes(page, "state.lane.moment.body.velocity")
    assert np.subtract(following, previous) == pytest.approx([-0.5, -0.5])


def test_every_control_has_a_name_and_takes_the_focus(page):
    nameless = page.execute_script(
        """
        const controls = [...document.querySelectorAll("button, input, select, summary")];
        const visible = controls.filter((each) => each.offsetParent !== null && !each.disabled);
        const named = (each) => each.textContent.trim() || each.labels?.length || each.ariaLabel;
        const focused = (each) => { each.focus(); return document.activeElement === each; };
        const wrong = visible.filter((each) => !named(each) || !focused(each));
        return wrong.map((each) => each.outerHTML);
        """
    )
    assert nameless == []


def test_a_controller_learns_on_a_worker_and_shows_what_it_can(page):
    click(page, "learn")
    until(page, "playground.learner.curve.length >= 2")
    assert "learned here" in page.execute_script(
        "return playground.panes[1].chooser.selectedOptions[0].label"
    )
    curve = page.execute_script("return playground.learner.curve.map((each) => each.best.fitness)")
    assert curve == sorted(curve)
    weight = page.execute_script("return playground.panes[1].runner.weights[0]")
    best = page.execute_script("return playground.learner.learned.weights[0]")
    assert weight == pytest.approx(best, rel=1e-6)
    click(page, "learn")
    assert page.execute_script("return playground.learner.going") is False
    assert "Stopped: generation" in page.execute_script(
        "return playground.learner.status.textContent"
    )


def test_memory_stays_flat_over_a_minute(page):
    script = """
        const bytes = await Promise.all([...playground.engines.values()]);
        const wasm = bytes.map((each) => each.program.memory.buffer.byteLength);
        return [performance.memory.usedJSHeapSize, ...wasm];
    """
    sizes = []
    for _ in range(2):
        for _ in range(12):
            advance(page, 5.0)
        page.execute_cdp_cmd("HeapProfiler.collectGarbage", {})
        sizes.append(script_result(page, script))
    heap, *wasm = np.subtract(sizes[1], sizes[0])
    assert not np.any(wasm)
    assert heap < 300_000


def test_what_is_narrow_scrolls_one_way_only_and_shows_one_side(browser, address):
    page = opened(browser, address, width=390)
    assert page.execute_script("return document.documentElement.scrollWidth") <= 390
    assert page.execute_script("return playground.panes[1].element.hidden")
    small = page.execute_script(
        """
        const controls = [...document.querySelectorAll("button, select, label:has(input)")];
        const visible = controls.filter((each) => each.offsetParent !== null);
        const high = (each) => each.getBoundingClientRect().height;
        return visible.filter((each) => high(each) < 36).map((each) => each.outerHTML);
        """
    )
    assert small == []


def test_a_phone_shows_every_picture_without_scrolling_sideways(browser, address):
    page = opened(browser, address, width=390)
    inside = page.execute_script(
        """
        const boxes = [...playground.panes[0].element.querySelectorAll("canvas")];
        const scrolls = [...document.querySelectorAll("*")].filter((each) =>
          each.scrollWidth > each.clientWidth + 1 && getComputedStyle(each).overflowX === "auto");
        const within = (box) => box.left >= 0 && box.right <= 390 && box.width > 100;
        return [boxes.every((each) => within(each.getBoundingClientRect())), scrolls.length];
        """
    )
    assert inside == [True, 0]


def test_the_ground_drops_in_sight_of_the_leg_on_a_phone(browser, address):
    page = opened(browser, address, width=390)
    inside = """
        const seen = (each) => document.querySelector(each).getBoundingClientRect();
        return ["#drop", ".stage"].map((each) => seen(each).top >= 0 && seen(each).bottom < 800);
    """
    assert page.execute_script(inside) == [True, True]
    page.execute_script("document.querySelector('.plots').scrollIntoView()")
    assert page.execute_script(inside)[0], "it stays above the pictures"


def test_a_link_opens_the_page_as_it_was(browser, address):
    page = opened(browser, address)
    script_result(page, 'await playground.takeBody("quadruped"); playground.state.playing = false')
    slide(page, "mass_kg", 0.15)
    slide(page, "omega", 6)
    click(page, "phases")
    leg = page.execute_script("return playground.world.body.legs[3]")
    click(page, f"leg-{leg}")
    click(page, "frozen")
    click(page, "link")
    link = page.execute_script("return location.href")
    browser.get("about:blank")
    opened(browser, link)
    state = page.execute_script(
        "const { world } = playground;"
        "return [world.body.name, world.numbers.mass_kg, world.omega, world.frozen, world.seed,"
        " world.present]"
    )
    assert state == ["quadruped", 0.15, 6, True, 2, [1, 1, 1, 0]]


def test_the_link_of_the_pages_plays_the_controller_of_the_demo(browser, address):
    pages = [(DOCS / f"{x}.md").read_text("utf-8") for x in ("getting-started", "playground")]
    links = re.findall(r'"playground-page\.html(#.*?)"', "".join(pages))
    (link,) = set(map(html.unescape, links))
    browser.get("about:blank")
    page = opened(browser, address + link)
    advance(page, 20.0)
    label, two, weights, hops = script_result(
        page,
        "const { runner, chooser } = playground.panes[0];"
        "return [chooser.selectedOptions[0].textContent, playground.state.two,"
        " runner.controller.weights, !runner.hops.rests(runner.time)]",
    )
    assert (label, two, hops) == (DEMO, False, True)
    demo = controller_of(resolve(CONTROLLER))
    np.testing.assert_allclose(weights, demo.weights, rtol=1e-7)


def test_a_link_with_numbers_out_of_range_is_moved_into_it(browser, address):
    browser.get("about:blank")
    page = opened(browser, f"{address}#body=hopper&mass_kg=1e9&omega=nonsense&speed=7&left=none")
    state = page.execute_script(
        "const { world } = playground; return [world.body.name, world.numbers.mass_kg, world.omega]"
    )
    assert state == ["hopper", 0.25, None]
    assert page.execute_script("return document.getElementById('trouble').hidden")


def test_a_listener_hears_what_was_done(page):
    click(page, "drop")
    text = page.execute_script("return document.querySelector('#said[role=status]').textContent")
    assert text == "The ground is at -0.2 m."


def test_a_listener_asks_for_the_motion_and_hears_it_of_both_sides(page):
    advance(page, 20.0)
    page.execute_script("document.activeElement.blur()")
    pressed(page, "s")
    text = page.execute_script("return document.getElementById('said').textContent")
    assert "Left: V: nothing learned, 20 seconds after the release, hops at" in text
    assert "Right:" in text


def test_the_tour_shows_three_steps_and_gives_the_focus_back(page):
    click(page, "tour-start")
    titles = []
    while page.execute_script("return !document.getElementById('tour').hidden"):
        titles.append(page.execute_script("return document.activeElement.textContent"))
        assert page.execute_script("return document.querySelectorAll('.toured').length") == 1
        page.execute_script("document.querySelector('#tour .next').click()")
    assert [title[:6] for title in titles] == ["1 of 3", "2 of 3", "3 of 3"]
    assert page.execute_script("return document.activeElement.id") == "tour-start"
    assert page.execute_script("return document.querySelector('.toured')") is None


def test_every_picture_has_a_description(page):
    nameless = """return [...document.querySelectorAll("canvas")].filter(
        (each) => each.offsetParent && !(each.role === "img" && each.ariaLabel)).length"""
    assert page.execute_script(nameless) == 0


def test_who_wants_less_motion_starts_with_a_page_that_stands_still(browser, address):
    page = opened(browser, address, reduced_motion="reduce")
    assert page.execute_script("return playground.state.playing") is False
    assert page.execute_script("return document.getElementById('play').textContent") == "Play"


def test_light_and_dark_have_colours_of_their_own_in_pictures_too(browser, address):
    grounds = []
    for scheme in ("light", "dark"):
        page = opened(browser, address, color_scheme=scheme, reduced_motion="reduce")
        until(page, "playground.state.busy === 0")
        advance(page, 0.1)
        grounds.append(
            page.execute_script(
                "const pen = playground.panes[0].canvases.circle.context.strokeStyle;"
                "return [getComputedStyle(document.documentElement).backgroundColor, pen]"
            )
        )
    (light, pen), (dark, other_pen) = grounds
    assert light != dark
    assert pen != other_pen
