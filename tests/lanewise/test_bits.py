"""The same bits everywhere: any width, any number of vectors, any processor, any neighbours."""

import functools
import shutil
import subprocess

import jax.numpy as jnp
import numpy as np
import pytest

from lanewise.episode import TracedEpisode, compile_episode
from lanewise.machine import Code, object_file, target_of
from lowered import available_targets, evaluated, of_everything, same_bits, samples

DTYPES = ("float32", "float64")


def inputs(dtype):
    x = samples(dtype, 60)
    return x, np.random.default_rng(5).permutation(x)


@functools.cache
def reference_bits(dtype):
    return evaluated(of_everything, *inputs(dtype), dtype=dtype)


@pytest.mark.parametrize("dtype", DTYPES)
@pytest.mark.parametrize("vectors", [1, 3])
@pytest.mark.parametrize("target", available_targets())
def test_bits_depend_on_neither_the_processor_nor_the_vectors_of_a_block(target, vectors, dtype):
    result = evaluated(of_everything, *inputs(dtype), dtype=dtype, target=target, vectors=vectors)
    assert same_bits(result, reference_bits(dtype))


def test_bits_do_not_depend_on_threads():
    assert same_bits(
        evaluated(of_everything, *inputs("float32"), threads=3), reference_bits("float32")
    )


def test_bits_of_a_lane_do_not_depend_on_its_neighbours():
    x, y = inputs("float32")
    for some in (slice(5, 6), slice(40, 75), slice(None, None, -1)):
        result = evaluated(of_everything, x[some], y[some])
        expected = {
            name: [part[..., some] for part in value] if isinstance(value, list) else value[some]
            for name, value in reference_bits("float32").items()
        }
        assert same_bits(result, expected)


def episode_kernel(target, dtype="float32"):
    """A kernel of some ticks, with what a lane keeps and what all lanes share."""

    def start(lanes, shared):
        return {"x": lanes["x"], "largest": jnp.zeros_like(lanes["x"])}

    def tick(lanes, shared, state, index):
        result = of_everything(state["x"], lanes["y"])
        step = shared["step"] * (result["branch"][0] - result["ratio"] / lanes["y"])
        x = state["x"] + step + 0.01 * index.astype(state["x"].dtype)
        x = jnp.where(jnp.isfinite(x), jnp.clip(x, -3.0, 3.0), 0.5)
        return {"x": x, "largest": jnp.maximum(state["largest"], x)}

    def frame(lanes, shared, state, last):
        return state, {**state, "high": state["x"] > 1.0}

    lanes = {"x": np.linspace(-2.0, 2.0, 8).astype(dtype), "y": np.ones(8, dtype) + 0.3}
    shared = {"step": np.asarray(0.125, dtype)}
    program = TracedEpisode(start, tick, frame)
    return compile_episode(program, lanes, shared, dtype, target=target), lanes, shared


def rolled_out(kernel, lanes, shared, frames=6, ticks=5):
    outputs = []

    def collect(first, n, channels):
        outputs.append({name: np.array(x[..., :n]) for name, x in channels.items()})

    kernel.run(lanes, shared, frames=frames, ticks_per_frame=ticks, threads=1, collect=collect)
    return outputs[0]


@pytest.mark.parametrize("optimisation", [0, 2, 3])
def test_bits_do_not_depend_on_how_hard_the_compiler_tries(optimisation):
    kernel, lanes, shared = episode_kernel("host")
    usually = rolled_out(kernel, lanes, shared)
    for blocks in (kernel.full, kernel.narrow):
        code = Code.compiled(blocks.module.text(), blocks.module.target, optimisation)
        object.__setattr__(blocks, "code", code)
    assert same_bits(rolled_out(kernel, lanes, shared), usually)


DRIVER = r"""
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
void uniform(void *, void *);
void start(void *, void *, void *, void *);
void episode(void *, void *, void *, void *, void *, int64_t, int64_t, int64_t, int64_t);
static void *memory(long size) { return aligned_alloc(64, (size / 64 + 1) * 64); }
int main(void)
{
    void *shared = memory(SHARED), *common = memory(UNIFORM), *lanes = memory(LANES);
    void *kept = memory(KEPT), *state = memory(STATE), *out = memory(OUT);
    if (fread(shared, 1, SHARED, stdin) != SHARED) return 1;
    if (fread(lanes, 1, LANES, stdin) != LANES) return 1;
    uniform(shared, common);
    start(lanes, common, kept, state);
    episode(lanes, common, kept, state, out, FRAMES, TICKS, BLOCK, 0);
    return fwrite(out, 1, OUT, stdout) == OUT ? 0 : 1;
}
"""


@pytest.mark.parametrize("dtype", DTYPES)
def test_bits_on_a_64_bit_arm_are_those_of_this_machine(tmp_path, dtype):
    tools = ("aarch64-linux-gnu-gcc", "qemu-aarch64")
    missing = [tool for tool in tools if shutil.which(tool) is None]
    if missing:
        pytest.skip(f"needs {' and '.join(missing)}, of Debian's gcc-aarch64-linux-gnu, qemu-user")
    from lanewise.module import EpisodeModule

    kernel, lanes, shared = episode_kernel("host", dtype)
    expected = rolled_out(kernel, lanes, shared)
    parsed = kernel.full.module
    vectors = 8 // target_of("aarch64").lanes_of_vector(dtype)
    module = EpisodeModule(
        parsed.stages, parsed.lanes, parsed.recorded, target_of("aarch64"), dtype, vectors
    )
    text, block, frames, ticks = module.text(), module.block, 6, 5
    (tmp_path / "code.o").write_bytes(object_file(text, module.target))
    (tmp_path / "driver.c").write_text(DRIVER)
    sizes = {
        "SHARED": 8,
        "UNIFORM": module.uniform_bytes,
        "LANES": module.lane_rows.size * block,
        "KEPT": module.invariant_rows.size * block,
        "STATE": module.state_rows.size * block,
        "OUT": module.recorded.size * block * frames,
        "FRAMES": frames,
        "TICKS": ticks,
        "BLOCK": block,
    }
    defines = [f"-D{name}={size}" for name, size in sizes.items()]
    run = ["driver.c", "code.o", "-o", "driver", "-static", "-lm"]
    subprocess.run([tools[0], *defines, *run], check=True, cwd=tmp_path)
    step = np.zeros(8 // np.dtype(dtype).itemsize, dtype)
    step[0] = shared["step"]
    given_to = step.tobytes() + lanes["x"].tobytes() + lanes["y"].tobytes()
    completed = subprocess.run(
        [tools[1], "./driver"], input=given_to, capture_output=True, cwd=tmp_path
    )
    assert completed.returncode == 0
    memory = np.frombuffer(completed.stdout, np.uint8)
    views = module.recorded.views(memory, frames, block)
    for name, view in zip(sorted(expected), views, strict=True):  # entries of a dictionary
        bits = view[:, 0, :]
        if expected[name].dtype == bool:
            bits = bits != 0
        assert same_bits(np.ascontiguousarray(bits), expected[name])
