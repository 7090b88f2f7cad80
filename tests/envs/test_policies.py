"""Anyone's policy on the hopper: what it sees and does, its surface, its portrait."""

import base64
import io
import json
import math
import pickle
import sys
import zipfile

import numpy as np
import pytest

pytest.importorskip("gymnasium")

from refusals import refused
from tegotae import TegotaeError
from tegotae.analysis.orbit import NoLimitCycleError, release_paths
from tegotae.analysis.policy import (
    measured_policy,
    policy_orbit,
    policy_paths,
)
from tegotae.analysis.surface import actuation_surface
from tegotae.envs import policies
from tegotae.envs.policies import (
    ClippedFeedbackWarning,
    Meaning,
    Policy,
    from_function,
    load_policy,
)
from tegotae.figures.cycles import portrait_figure, portrait_table
from tegotae.simulation.recorder import Trajectory
from tegotae.systems.controller_file import SavedController
from tegotae.systems.recipe import recipe

FORCES = np.array([0.0, 0.5, 1.0])


def reflex(phase_rad, spring_force_n):
    """The paper's reflex with its oscillator at its own pace."""
    return np.maximum(0.0, 2.0 * np.cos(phase_rad) * spring_force_n)


def bang(spring_force_n, velocity_m_per_s):
    return 4.0 * ((velocity_m_per_s > 0.0) & (spring_force_n > 0.0))


def slowing(phase_rad, spring_force_n):
    """Vanilla Tegotae feedback, `-σ cos φ F_k`."""
    return -2.0 * np.cos(phase_rad) * spring_force_n


@pytest.fixture(scope="module")
def hopping():
    """A function's rollouts from two releases."""
    policy = from_function(reflex, Meaning(omega=8.0))
    return policy, policy_paths(policy, np.array([1.2, 1.3]), duration_s=20.0)


def test_a_function_of_phase_and_force_has_the_surface_that_it_says():
    result = actuation_surface(from_function(reflex), FORCES, columns=5)
    expected = np.maximum(0.0, 2.0 * np.cos(result.phase_rad) * FORCES[:, None])
    np.testing.assert_allclose(result.actuator_force_n, expected, atol=1e-6)
    assert not result.feedback_rad_per_s.any()


def test_a_function_without_a_phase_has_a_surface_over_velocity():
    result = actuation_surface(from_function(bang), FORCES, columns=4)
    assert result.phase_rad is None
    expected = 4.0 * ((result.velocity_m_per_s > 0.0) & (FORCES[:, None] > 0.0))
    np.testing.assert_allclose(result.actuator_force_n, expected)


def test_a_feedback_function_has_the_surface_of_the_controller_that_it_copies():
    """Vanilla feedback as somebody's function, beside the package's own controller of it."""
    meaning = Meaning(acts="feedback", actuation="reflex", omega=8.0)
    result = actuation_surface(from_function(slowing, meaning), FORCES, columns=9)
    plain = SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array([2.0]), 8.0)
    expected = actuation_surface(plain, FORCES, columns=9)
    np.testing.assert_allclose(result.actuator_force_n, expected.actuator_force_n, atol=1e-6)
    np.testing.assert_allclose(result.feedback_rad_per_s, expected.feedback_rad_per_s, atol=1e-6)


def test_a_function_of_single_numbers_is_asked_one_by_one():
    def slow(phase_rad, spring_force_n):
        return max(0.0, math.cos(phase_rad)) * spring_force_n

    result = actuation_surface(from_function(slow), FORCES, columns=5)
    expected = np.maximum(0.0, np.cos(result.phase_rad)) * FORCES[:, None]
    np.testing.assert_allclose(result.actuator_force_n, expected, atol=1e-6)


def test_a_policys_gait_is_measured_as_any_recording(hopping):
    policy, paths = hopping
    result = measured_policy(policy, paths)
    assert result.limit_cycle_period == 1
    assert result.hop_rate == pytest.approx(8.0, rel=0.01)  # it keeps to its clock
    assert 0.0 < result.optimum_share < 1.0


def test_a_policys_orbit_is_one_turn_of_its_limit_cycle(hopping):
    policy, paths = hopping
    orbit = policy_orbit(paths, measured_policy(policy, paths))
    assert orbit.period_s == pytest.approx(2.0 * math.pi / 8.0, rel=0.01)
    assert orbit.height_m[0] == pytest.approx(orbit.apex_height_m[0], abs=1e-3)
    # What it feels on the way is what it answers to.
    stance = orbit.spring_force_n > 0.1
    answered = reflex(orbit.phase_rad, orbit.spring_force_n)[stance]
    assert np.corrcoef(answered, orbit.actuator_force_n[stance])[0, 1] > 0.95


def test_what_does_not_settle_has_no_orbit_and_says_why():
    policy = from_function(lambda spring_force_n: 0.0 * spring_force_n, name="idle")
    paths = policy_paths(policy, np.array([1.2]), duration_s=3.0)
    with pytest.raises(NoLimitCycleError, match="no hop"):
        policy_orbit(paths, measured_policy(policy, paths))


def test_a_leg_that_has_lost_its_length_is_told_from_one_at_rest():
    policy = from_function(bang)
    paths = policy_paths(policy, np.array([1.2]), duration_s=12.0)
    assert paths.failed[-1].tolist() == [True]
    with pytest.raises(NoLimitCycleError, match="no length left"):
        policy_orbit(paths, measured_policy(policy, paths))


@pytest.mark.parametrize("with_phase", [True, False])
def test_a_portrait_shows_every_release(hopping, with_phase):
    _, paths = hopping
    if not with_phase:
        paths = Trajectory(**{n: x for n, x in paths.channels.items() if n != "phase_rad"})
    figure = portrait_figure(paths, rest_length_m=1.0, note="reflex")
    assert len(figure.axes) == 2
    assert len(figure.axes[1].lines) == 6  # thin, thick and release of both
    table = portrait_table(paths)
    assert len(table["time_s"]) == paths.height_m.size
    assert ("phase_rad" in table) is with_phase


def test_a_controller_has_a_portrait_too():
    saved = SavedController.from_weights(recipe("V-reflex-w8").controller(), np.array([2.0]), 8.0)
    paths = release_paths(saved, np.array([1.1, 1.3]), duration_s=2.0)
    assert paths.spring_force_n.shape == (200, 2)
    assert paths.height_m[0] == pytest.approx([1.1, 1.3], abs=0.01)


@pytest.fixture
def model(tmp_path):
    """A function that saves a model of Stable-Baselines3, and returns it with its environment."""
    stable = pytest.importorskip("stable_baselines3")
    from tegotae.envs import make_sb3

    def saved(algorithm="PPO", **settings):
        env = make_sb3("tegotae/Hopper-v0", 2)
        model = getattr(stable, algorithm)("MlpPolicy", env, device="cpu", seed=0, **settings)
        model.save(tmp_path / "model.zip")
        return model, env, tmp_path / "model.zip"

    return saved


def small_relu():
    from torch import nn

    return {"policy_kwargs": {"activation_fn": nn.ReLU, "net_arch": {"pi": [8], "vf": [4]}}}


@pytest.mark.parametrize(
    ("algorithm", "settings"),
    [
        ("PPO", dict),
        ("PPO", small_relu),
        ("PPO", lambda: {"use_sde": True}),
        *[(name, dict) for name in ("A2C", "SAC", "TD3", "DDPG")],
    ],
)
def test_a_model_of_stable_baselines_answers_as_it_does_itself(algorithm, settings, model):
    original, env, path = model(algorithm, **settings())
    policy = load_policy(str(path))
    observed = env.reset() + np.array([[0.0, 0.0], [0.5, -1.0]], np.float32)
    expected = np.clip(original.predict(observed, deterministic=True)[0][:, 0], -1.0, 1.0)
    np.testing.assert_allclose(policy.actions(observed), expected, rtol=1e-6)


def test_a_model_that_observes_less_than_declared_is_refused_and_another_is_drawn(model):
    path = str(model()[2])
    with pytest.raises(TegotaeError, match=r"observes 2 numbers, and it is declared to observe 3"):
        load_policy(path, Meaning(acts="feedback"))
    result = actuation_surface(load_policy(path), FORCES, columns=3)
    assert result.actuator_force_n.shape == (3, 3)


class Harm:
    """Object that writes a file as it is unpickled."""

    def __init__(self, path):
        self.path = path

    def __reduce__(self):
        return open, (str(self.path), "w")


@pytest.mark.parametrize("part", ["a setting", "the weights"])
def test_no_code_of_a_models_file_is_run(part, model, tmp_path):
    _, _, path = model(**small_relu())
    harm = pickle.dumps(Harm(tmp_path / "harmed"), protocol=2)
    with zipfile.ZipFile(path) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    if part == "the weights":
        entries["policy.pth"] = harm
    else:
        document = json.loads(entries["data"])
        for value in document.values():
            if isinstance(value, dict) and ":serialized:" in value:
                value[":serialized:"] = base64.b64encode(harm).decode()
        entries["data"] = json.dumps(document).encode()
    with zipfile.ZipFile(path, "w") as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    if part == "the weights":
        refused(r"model\.zip cannot be loaded as PPO", load_policy, str(path))
    else:
        assert np.isfinite(load_policy(str(path)).actions(np.zeros((1, 2)))).all()
    assert not (tmp_path / "harmed").exists()


def zeros(name: str, count: int = 2**21) -> bytes:
    """An archive of zeros, of a few kilobytes."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr(name, bytes(count))
    return stream.getvalue()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"policy.pth": bytes(2**21)}, "no model of Stable-Baselines3: it unpacks to 2"),
        ({"data": bytes(2**21)}, "no model of Stable-Baselines3: it unpacks to 2"),
        ({"policy.pth": zeros("archive/data.pkl")}, "cannot be loaded as PPO: .*unpacks to 2 MiB"),
        ({"net_arch": [10**6]}, "a policy of 1000000 units; its layers must have at most 512"),
        ({"net_arch": {"pi": [500], "vf": [500]}}, "a policy of 1000 units"),
    ],
)
def test_a_small_file_that_would_take_much_memory_is_refused(changes, said, model, monkeypatch):
    monkeypatch.setattr(policies, "_MOST_BYTES", 2**20)
    _, _, path = model(**small_relu())
    load_policy(path)
    with zipfile.ZipFile(path) as archive:
        entries = {name: archive.read(name) for name in archive.namelist()}
    entries |= {name: content for name, content in changes.items() if name in entries}
    if "net_arch" in changes:
        document = json.loads(entries["data"])
        document["policy_kwargs"] |= changes
        entries["data"] = json.dumps(document).encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in entries.items():
            archive.writestr(name, content)
    assert path.stat().st_size < 2**18
    refused(said, load_policy, path)


def test_a_model_with_parts_of_its_authors_is_refused(model):
    from stable_baselines3.common.torch_layers import FlattenExtractor

    path = model(policy_kwargs={"features_extractor_class": FlattenExtractor})[2]
    refused(r"features_extractor_class .*FILE\.py:FUNCTION", load_policy, str(path))


@pytest.fixture(scope="module")
def network(tmp_path_factory):
    """An ONNX file of `0.5 · spring force - 0.25 · velocity`."""
    onnx = pytest.importorskip("onnx")
    pytest.importorskip("onnxruntime")
    from onnx import TensorProto, helper, numpy_helper

    weights = numpy_helper.from_array(np.array([[0.5], [-0.25]], np.float32), "w")
    graph = helper.make_graph(
        [helper.make_node("MatMul", ["seen", "w"], ["answer"])],
        "policy",
        [helper.make_tensor_value_info("seen", TensorProto.FLOAT, ["n", 2])],
        [helper.make_tensor_value_info("answer", TensorProto.FLOAT, ["n", 1])],
        [weights],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    path = tmp_path_factory.mktemp("onnx") / "net.onnx"
    onnx.save(model, path)
    return path


def test_an_onnx_network_answers_what_it_computes(network):
    policy = load_policy(str(network))
    observed = np.array([[1.0, 0.0], [0.0, 2.0], [4.0, 0.0]])
    np.testing.assert_allclose(policy.actions(observed), [0.5, -0.5, 1.0])


def test_an_answer_in_newton_is_scaled_to_the_largest_force(network):
    policy = load_policy(str(network), Meaning(answer_scale=1.0))
    assert policy.actions(np.array([[2.0, 0.0]])) == pytest.approx([1.0 / 4.0])


def test_an_answer_of_a_function_is_scaled_where_that_is_asked_for():
    result = actuation_surface(from_function(reflex, Meaning(answer_scale=0.5)), FORCES, columns=5)
    expected = np.maximum(0.0, np.cos(result.phase_rad) * FORCES[:, None])
    np.testing.assert_allclose(result.actuator_force_n, expected, atol=1e-6)


def test_feedback_that_is_cut_off_is_said():
    large = from_function(lambda phase_rad: 100.0 * np.cos(phase_rad), Meaning(acts="feedback"))
    with pytest.warns(ClippedFeedbackWarning, match="more than 40 rad/s"):
        actions = large.actions(np.array([[0.0, 1.0], [1.0, 0.0]]))
    assert actions == pytest.approx([1.0, 0.0])


def test_a_function_that_is_said_to_observe_something_else_is_refused():
    with pytest.raises(TegotaeError, match="observe height, and its arguments say phase"):
        from_function(reflex, Meaning(observes=("height",)))


def test_a_function_of_other_arguments_is_refused():
    refused("asks for knee; the arguments of a policy are phase", from_function, lambda knee: knee)


@pytest.mark.parametrize(
    ("answer", "says"),
    [
        (lambda seen: np.full(len(seen), np.nan), "no finite number to"),
        (lambda seen: np.zeros((len(seen), 3)), r"array of shape \(2, 3\); it must give one"),
        (lambda seen: 1 / 0, "failed on observations of shape .* ZeroDivisionError"),
    ],
)
def test_a_policy_that_fails_is_told_in_one_line(answer, says):
    refused(says, lambda: Policy(answer, Meaning()).actions(np.zeros((2, 2))))


@pytest.mark.parametrize(
    ("inputs", "says"),
    [
        ({"acts": "torque"}, "no kind of action is called 'torque'"),
        ({"observes": ("speed",)}, "no observation of this environment is called 'speed'"),
        ({"acts": "feedback", "actuation": "spring"}, "no actuation is called 'spring'"),
        ({"answer_scale": 0.0}, "answer_scale is 0"),
        ({"step_s": 1.0}, "step_s is 1; it must be at most 0.02"),
        ({"step_s": 0.0015}, "step_s is 0.0015; it must be a whole number of ticks of 0.001 s"),
    ],
)
def test_a_meaning_that_cannot_be_is_refused(inputs, says):
    refused(says, Meaning, **inputs)


@pytest.mark.parametrize(
    ("place", "says"),
    [
        ("no.zip", "there is no file no.zip"),
        ("no.onnx", "there is no file no.onnx"),
        ("bad.zip", "bad.zip is no model of Stable-Baselines3"),
        ("bad.onnx", "bad.onnx is no ONNX network"),
        ("walk.pt", "walk.pt is no policy"),
        ("math:pi", "a float cannot be called"),
    ],
)
def test_what_is_no_policy_is_refused_in_one_line(place, says, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("bad.zip", "bad.onnx"):
        (tmp_path / name).write_bytes(b"nothing of the kind")
    if place == "bad.onnx":
        pytest.importorskip("onnxruntime")
    refused(says, load_policy, place)


def test_onnx_without_its_package_names_the_extra(tmp_path, monkeypatch):
    (tmp_path / "net.onnx").write_bytes(b"")
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    refused(r"pip install 'tegotae\[onnx\]'", load_policy, str(tmp_path / "net.onnx"))
