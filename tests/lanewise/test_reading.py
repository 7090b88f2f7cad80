"""Reading of a trace: operations that move entries, those that stay a branch, and refusals."""

import subprocess
import sys

import jax
import jax.numpy as jnp
import numpy as np
import pytest

from lanewise.episode import compile_episode
from lanewise.function import compile_function
from lanewise.machine import load_step
from lanewise.nodes import CannotLower, LanewiseError
from lowered import evaluated, program

X = np.linspace(-2.0, 2.0, 21).astype("float32")


def sorts(x):
    return jnp.sort(jnp.stack([x, -x]), axis=0)


def picks(x):
    return jnp.stack([x, -x])[jnp.argmax(x), :]


@pytest.mark.parametrize(("function", "name"), [(sorts, "sort"), (picks, "argmax")])
def test_what_cannot_be_native_code_is_named_in_one_line_with_its_place(function, name):
    line = function.__code__.co_firstlineno + 1
    with pytest.raises(CannotLower) as raised:
        compile_episode(program(function), (X,), {}, "float32")
    assert str(raised.value) == f"'{name}' (test_reading.py, line {line}) has no native code"
    assert raised.value.operation == name
    assert isinstance(raised.value, LanewiseError)


def moves(x):
    rows = jnp.stack([x, 2.0 * x, 3.0 * x, 4.0 * x])
    order = jnp.asarray([2, 0, 3, 1])
    return {
        "picked": rows[order],
        "last": rows[-1],
        "set": rows.at[1].set(0.5),
        "padded": jnp.pad(x[None], ((1, 0), (0, 0))),
        "running": jnp.cumsum(rows, axis=0),
        "most": rows.max(axis=0),
        "product": jnp.asarray(np.eye(4, dtype="float32")[::-1]) @ rows,
        "turned": jnp.flip(rows, 0) + jnp.roll(rows, 1, axis=0),
        "loop": jax.lax.fori_loop(0, 3, lambda i, y: y + rows[i], x),
        "switch": jax.lax.switch(
            jnp.int32(x[0] > 0.0) + jnp.int32(x[0] > 1.0),
            [lambda: x, lambda: 10.0 * x, lambda: 100.0 * x],
        ),
    }


def test_what_only_moves_entries_or_repeats_them_is_done_beforehand():
    result = evaluated(moves, X)
    for lane, x in enumerate(X):
        expected = moves(jnp.asarray([x]))
        for name, value in expected.items():
            np.testing.assert_allclose(
                result[name][..., lane], np.asarray(value)[..., 0], 1e-6, err_msg=name
            )


WEIGHTS = np.random.default_rng(0).normal(size=(3, 2)).astype("float32")


def controller(state, inputs):
    hidden = jnp.tanh(jnp.asarray(WEIGHTS) @ inputs["felt"])
    phase = state["phase"] + 0.001 * (5.0 + hidden.sum())
    return {"phase": phase, "ticks": state["ticks"] + 1}, {"force": jnp.sin(phase), "on": phase > 1}


BEGUN = {"phase": np.float32(0.5), "ticks": np.int32(0)}
FELT = np.asarray([0.3, -0.7], "float32")


def test_a_function_of_one_lane_steps_as_its_trace_does():
    step = compile_function(controller, BEGUN, {"felt": FELT}).step()
    step.reset(**BEGUN)
    step.inputs["felt"][...] = FELT
    state = {name: jnp.asarray(value) for name, value in BEGUN.items()}
    for _ in range(5):
        step()
        state, outputs = controller(state, {"felt": jnp.asarray(FELT)})
    assert step.state["ticks"] == 5
    assert float(step.state["phase"]) == pytest.approx(float(state["phase"]), rel=1e-6)
    assert float(step.outputs["force"]) == pytest.approx(float(outputs["force"]), rel=1e-6)
    assert step.outputs["on"] == 0


@pytest.mark.parametrize("lanes", [1, 5, 40])
def test_lanes_side_by_side_step_as_each_alone_to_the_bit(lanes):
    def driven(state, inputs):
        far = jnp.where(state["phase"] > 1.0, jnp.tanh(inputs["felt"][0]), inputs["felt"][1])
        return {"phase": state["phase"] + inputs["gain"] * far}, {"on": far > 0.0, "far": far}

    def stepped(felt, count):
        separate = np.zeros(1, "float32")
        arguments = {"felt": np.zeros((2, 1), "float32"), "gain": np.float32(0.0)}
        step = compile_function(driven, {"phase": separate}, arguments, lanes=count).step()
        step.inputs["felt"][..., :count], step.inputs["gain"][...] = felt, 0.5
        step.state["phase"][:count] = 0.9
        for _ in range(3):
            step()
        return [memory[name][:count] for memory, name in read(step)]

    felt = np.random.default_rng(0).normal(size=(2, lanes)).astype("float32")
    together = stepped(felt, lanes)
    for lane in range(lanes):
        alone = stepped(felt[:, [lane]], 1)
        for joint, expected in zip(together, alone, strict=True):
            assert joint[lane] == expected[0]


def read(step):
    return (step.state, "phase"), (step.outputs, "on"), (step.outputs, "far")


PLAIN = """
import sys
from lanewise.machine import load_step
step = load_step(open(sys.argv[1], "rb").read())
step.reset(phase=0.5)
step.inputs["felt"][...] = (0.3, -0.7)
step()
assert "jax" not in sys.modules
print(step.outputs["force"].tobytes().hex())
"""


def test_code_steps_in_a_process_without_jax_to_the_bit(tmp_path):
    kernel = compile_function(controller, BEGUN, {"felt": FELT})
    (tmp_path / "code").write_bytes(kernel.to_bytes())
    command = [sys.executable, "-c", PLAIN, str(tmp_path / "code")]
    printed = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    step = kernel.step()
    step.reset(phase=np.float32(0.5))
    step.inputs["felt"][...] = FELT
    step()
    assert printed.strip() == step.outputs["force"].tobytes().hex()


def test_code_for_another_processor_or_altered_is_refused_before_it_is_loaded():
    kernel = compile_function(controller, BEGUN, {"felt": FELT})
    with pytest.raises(LanewiseError, match="another processor"):
        load_step(kernel.to_bytes("aarch64"))
    content = kernel.to_bytes()
    load_step(content)
    damaged = [b"", b"no code", content + b"\0"]
    for place in range(0, len(content), 61):
        altered = bytes([content[place] ^ 0x10])
        damaged += [content[:place], content[:place] + altered + content[place + 1 :]]
    for code in damaged:
        with pytest.raises(LanewiseError, match="truncated or altered"):
            load_step(code)
