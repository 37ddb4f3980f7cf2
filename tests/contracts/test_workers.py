"""Work that other processes do: the same bits, each once, also when one dies."""

import json
import os
import signal
import subprocess
import sys
import time
from contextlib import contextmanager
from itertools import count, islice

import numpy as np
import pytest

from restir_gi.reference.cli import reference as command
from restir_gi.reference.cli.main import main
from restir_gi.reference.images.exr import read_exr
from restir_gi.reference.oracle.backends.inside import InsideBackend
from restir_gi.reference.oracle.backends.running import Limits
from restir_gi.reference.oracle.blackbox.renderer import Renderer
from restir_gi.reference.oracle.builtin.backend import BuiltIn
from restir_gi.reference.oracle.cases import for_ever
from restir_gi.reference.oracle.distributed import Reached, distributed_levels
from restir_gi.reference.oracle.ladder import statistical_levels
from restir_gi.reference.oracle.levels.means import mean_over_runs, replicates
from restir_gi.reference.oracle.parts import whole_contract
from restir_gi.reference.oracle.steps import Asker
from restir_gi.reference.reports.tradeoff.points import Design
from restir_gi.reference.reports.tradeoff.store import open_store
from restir_gi.reference.reports.tradeoff.sweep import Sweep, run_sweep
from restir_gi.reference.reports.tradeoff.trials import run_trial
from restir_gi.reference.scene.named import Named
from restir_gi.reference.system.errors import UsageError
from restir_gi.reference.system.workers import ahead, work, workers

pytestmark = pytest.mark.slow


def sweep_of(*values, runs=3):
    points = tuple(Design("restir-gi-unbiased", v) for v in ((), *values))
    return Sweep(Named("cornell-box", False, 16, 16), 1, 4, runs, 0, points, ())


def test_processes_of_this_machine_do_the_same(tmp_path):
    sweep = sweep_of()
    with workers(2) as executor:
        found = dict(work(executor, run_trial, sweep.tasks()))
    for task, run in found.items():
        assert np.array_equal(run.color, run_trial(task).color)


def killed(task):
    """Take the process along."""
    os.kill(os.getpid(), signal.SIGKILL)


def test_a_process_that_is_killed_is_told():
    with (
        pytest.raises(UsageError, match="was ended from outside"),
        workers(1) as executor,
    ):
        list(work(executor, killed, [1]))


@contextmanager
def cluster(folder):
    """A Dask scheduler and two workers, each a process."""
    address = folder / "scheduler.json"
    python = [sys.executable, "-m", "distributed.cli"]
    about = ["--scheduler-file", str(address), "--no-dashboard"]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    started = []

    def start(program, *words):
        command = [*python[:2], f"distributed.cli.dask_{program}", *about, *words]
        started.append(subprocess.Popen(command, cwd=folder, **quiet))

    try:
        start("scheduler", "--host", "127.0.0.1", "--port", "0")
        while not address.exists():
            time.sleep(0.1)
        for _ in range(2):
            start("worker", "--nthreads", "1", "--no-nanny")
        yield json.loads(address.read_text())["address"], started[1:]
    finally:
        for process in started:
            process.kill()
            process.wait()


def test_a_cluster_loses_nothing_when_a_worker_dies(tmp_path):
    """Of two workers one is killed while it works: each run is there, and right."""
    sweep = sweep_of(("mis=1/M",), runs=6)
    store = open_store(tmp_path / "runs", {})
    with cluster(tmp_path) as (address, (first, _)), workers(1, address) as executor:
        done = []

        def tick(count, total, unit):
            done.append(count)
            if count == 3:
                first.kill()

        run_sweep(sweep, store, executor, tick)
    assert done == list(range(len(sweep.tasks()) + 1))
    assert len(list(store.folder.glob("*/*.npz"))) == len(sweep.tasks())
    for task in sweep.tasks():
        assert np.array_equal(store.get(task).color, run_trial(task).color)
    assert first.wait() == -signal.SIGKILL


def slowly(number):
    """Later numbers are ready before earlier ones."""
    time.sleep(0.2 if number % 2 == 0 else 0.0)
    return number * number


def test_results_that_are_asked_for_in_order_come_in_order():
    with workers(2) as executor:
        found = list(islice(ahead(executor, slowly, count(), 4, for_ever), 6))
        assert found == [0, 1, 4, 9, 16, 25]
        assert list(ahead(executor, slowly, range(3), 8, for_ever)) == [0, 1, 4]


def test_a_cluster_accumulates_the_same_truth(tmp_path, capsys, monkeypatch):
    """To the last bit, and with the same rays, while one of its workers is killed."""
    about = ["cornell-box", "--size", "24x20", "--spp", "200", "--bounces", "6"]
    here, there = tmp_path / "here.exr", tmp_path / "there.exr"
    assert main(["reference", *about, "--out", str(here)]) == 0
    with cluster(tmp_path) as (address, (first, _)):

        @contextmanager
        def deadly(what):
            def tick(done, total, unit):
                if 0 < done < total:
                    first.kill()

            yield tick

        monkeypatch.setattr(command, "progress", deadly)
        words = ["--out", str(there), "--scheduler", address]
        assert main(["reference", *about, *words]) == 0
        assert first.wait() == -signal.SIGKILL
    capsys.readouterr()
    a, b = read_exr(here), read_exr(there)
    for name in ("color", "standard_error"):
        assert np.array_equal(a.layers[name], b.layers[name])
    for key in ("rays.primary", "rays.bounce", "rays.shadow", "spp"):
        assert a.metadata[key] == b.metadata[key], key


RENDER = (
    f"{sys.executable} -m restir_gi.reference render {{scene}} --method path --spp 1"
    " --size {width}x{height} --seed {seed} --out {out}"
)


def test_a_cluster_renders_the_pictures_of_a_renderer(tmp_path, capsys):
    """Those of the same seeds, in order; and the command judges several of them."""
    renderer = Renderer(RENDER, "cornell-box", 1, (8, 8), Limits())
    with cluster(tmp_path) as (address, _):
        with workers(1, address) as executor:
            found = list(ahead(executor, renderer.render, range(100, 104), 3, for_ever))
        about = ["check", RENDER, "--size", "8", "--budget", "25", "--json"]
        code = main([*about, "--scheduler", address])
    for seed, picture in enumerate(found, 100):
        assert np.array_equal(picture, renderer.render(seed))
    assert not np.array_equal(found[0], found[1])
    told = json.loads(capsys.readouterr().out)
    assert code in (0, 3), told
    assert told["pictures"] >= 2


def statistics_of(step):
    return step.title, step.certified, step.more, step.faults


def test_a_cluster_gathers_the_statistics_of_a_backend(tmp_path):
    """The same runs and the same bound as here, while one of its workers is killed."""
    reached = Reached("float64", Limits(), "float32")
    backend, forever = reached.open(), lambda: 1e6
    here = [
        take() for *_, take in statistical_levels(whole_contract(), backend, forever)
    ]
    with cluster(tmp_path) as (address, (first, _)), workers(1, address) as executor:
        there = []
        for _, _, take in distributed_levels(reached, backend, executor, forever):
            there.append(take())
            first.kill()
    assert here
    assert [statistics_of(s) for s in there] == [statistics_of(s) for s in here]
    assert first.wait() == -signal.SIGKILL


def test_what_a_cluster_brings_is_what_is_judged():
    """Control: batches from elsewhere that are a tenth too dark are told."""
    ask = Asker(whole_contract(), InsideBackend(BuiltIn("float64")))

    def dark(first):
        return (0.9 * replicates(ask, "float64", seed) for seed in count(first))

    found = mean_over_runs(ask, "float64", lambda: 1e6, dark)
    assert not found.finding.passed


def test_a_golden_folder_has_no_runs_for_a_cluster(tmp_path, capsys):
    address = "tcp://127.0.0.1:1"
    about = ["check", "float64", "--against", str(tmp_path), "--scheduler", address]
    assert main(about) == 2
    assert "golden folders have none" in capsys.readouterr().err


def gone(group):
    """Whether a group of processes is empty, within ten seconds."""
    for _ in range(100):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return True
        time.sleep(0.1)
    return False


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_sweep_goes_on(tmp_path, number):
    """What is done is kept, no process stays behind, and the end is the same."""
    about = ["cornell-box", "--size", "16x16", "--runs", "40", "--frames", "8"]
    about += ["--spp", "4", "--design", "0", "--sweep", "radius=0.1,0.2"]
    command = [sys.executable, "-m", "restir_gi.reference", "tradeoff", *about]
    command += ["--processes", "2", "--out", str(tmp_path)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.PIPE, "text": True}
    run = subprocess.Popen(command, start_new_session=True, **quiet)
    while len(list(tmp_path.glob("runs/*/*.npz"))) < 3:
        assert run.poll() is None
        time.sleep(0.02)
    # Ctrl-C reaches all processes of a terminal, SIGTERM the one that it is sent to.
    (os.killpg if number == signal.SIGINT else os.kill)(run.pid, number)
    _, told = run.communicate(timeout=60)
    assert run.returncode == 128 + number
    assert "goes on from there" in told
    assert told.count("\n") == 1
    kept = {p: p.read_bytes() for p in tmp_path.glob("runs/*/*.npz")}
    assert 3 <= len(kept) < 80
    assert not list(tmp_path.glob("runs/*/.*.part"))
    assert gone(run.pid)
    assert subprocess.run(command, capture_output=True, check=False).returncode == 0
    assert len(list(tmp_path.glob("runs/*/*.npz"))) == 80
    assert all(path.read_bytes() == contents for path, contents in kept.items())
