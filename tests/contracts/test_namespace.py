"""One import name, `restir_gi`: the wheel, and a guest that it must not disturb.

A guest is a project that has packages of its own named `reference`, `extensions` and
`tests`.  On its path is the unpacked wheel, entry points included, and not this
checkout.
"""

import json
import os
import re
import shutil
import subprocess
import sys
import sysconfig
from collections.abc import Collection
from pathlib import Path
from textwrap import dedent
from zipfile import ZipFile

import pytest

ROOT = Path(__file__).parents[2]
NAMESPACE = "restir_gi"
FOLDERS = {
    "reference": "reference",
    "extensions": "extensions",
    "hashgrid": "hashgrid",
    "gradient_domain": "gradient_domain",
    "figures": "docs/figures",
}


@pytest.mark.parametrize("name", FOLDERS)
def test_the_namespace_links_to_the_folder(name):
    """Doctests and mypy look through these links, and would find nothing."""
    link = ROOT / NAMESPACE / name
    assert link.is_dir(), f"{link} is no link: git config core.symlinks true"
    assert link.samefile(ROOT / FOLDERS[name])


# ---------------------------------------------------------------- wheel

BUILD = "import sys; from setuptools.build_meta import build_wheel as b; b(sys.argv[1])"


def copy_of_the_checkout(into: Path) -> Path:
    """Copy what a wheel is built of, and the tests, which do not belong into one."""
    skip = shutil.ignore_patterns("__pycache__")
    for folder in (NAMESPACE, *FOLDERS.values(), "tests"):
        shutil.copytree(ROOT / folder, into / folder, symlinks=True, ignore=skip)
    for name in ("pyproject.toml", "setup.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, into)
    return into


def build_wheel(checkout: Path, out: Path) -> Path:
    """Build the wheel of a checkout."""
    out.mkdir()
    command = [sys.executable, "-c", BUILD, out]
    subprocess.run(command, cwd=checkout, check=True, capture_output=True)
    (wheel,) = out.glob("*.whl")
    return wheel


def names_in(wheel: Path) -> set[str]:
    """Names of the files of a wheel."""
    with ZipFile(wheel) as archive:
        return set(archive.namelist())


def faults_of_a_wheel(names: Collection[str]) -> list[str]:
    """Files of the packages that are missing, and files of anything else."""
    expected = {
        f"{NAMESPACE}/{name}/{path.relative_to(ROOT / folder).as_posix()}"
        for name, folder in FOLDERS.items()
        for path in (ROOT / folder).rglob("*.*")
        if path.is_file() and "__pycache__" not in path.parts
    }
    expected |= {f"{NAMESPACE}/__init__.py", f"{NAMESPACE}/py.typed"}
    missing = [f"{name} is missing" for name in expected.difference(names)]
    foreign = [
        f"{name} is foreign"
        for name in expected.symmetric_difference(names) - expected
        if not re.match(r"restir_gi_oracle-[^/]*\.dist-info/", name)
    ]
    return sorted(missing + foreign)


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of the checkout as it stands."""
    folder = tmp_path_factory.mktemp("wheel")
    checkout = copy_of_the_checkout(folder / "checkout")
    return build_wheel(checkout, folder / "dist")


def test_the_wheel_holds_the_four_packages_and_nothing_else(wheel):
    assert faults_of_a_wheel(names_in(wheel)) == []


def test_the_wheel_needs_no_links(wheel, tmp_path):
    """Git for Windows may write them as files of text."""
    checkout = copy_of_the_checkout(tmp_path / "checkout")
    for name, folder in FOLDERS.items():
        (checkout / NAMESPACE / name).unlink()
        (checkout / NAMESPACE / name).write_text(f"../{folder}")
    assert names_in(build_wheel(checkout, tmp_path / "dist")) == names_in(wheel)


def test_control_a_wheel_with_gaps_is_found(tmp_path):
    checkout = copy_of_the_checkout(tmp_path / "checkout")
    (checkout / NAMESPACE / "py.typed").unlink()
    for name in ("__init__.py", "planted.py"):
        (checkout / "tests" / name).touch()
    setup = (checkout / "setup.py").read_text("utf-8")
    entry = '"gradient_domain": "gradient_domain"'
    assert setup.count(entry) == setup.count('"templates/*"') == 1
    setup = setup.replace(entry, '"tests": "tests"').replace("templates", "none")
    (checkout / "setup.py").write_text(setup, "utf-8")

    faults = faults_of_a_wheel(names_in(build_wheel(checkout, tmp_path / "dist")))

    assert "restir_gi/py.typed is missing" in faults
    assert "restir_gi/gradient_domain/__init__.py is missing" in faults
    assert any(fault.endswith("/templates/demo.html is missing") for fault in faults)
    assert "restir_gi/tests/planted.py is foreign" in faults


# ---------------------------------------------------------------- a guest

GUEST = {
    "reference/__init__.py": 'OWNER = "the guest"',
    "reference/pytest_plugin.py": 'raise ImportError("not the plug-in")',
    "extensions/__init__.py": """
        from restir_gi.reference.oracle.builtin.backend import FLOAT32

        jacobian = FLOAT32.jacobian
    """,
    "mine.py": """
        import extensions

        class Mine:
            jacobian = staticmethod(extensions.jacobian)
    """,
    "tests/__init__.py": 'OWNER = "the guest"',
    "tests/test_guest.py": """
        import os
        from pathlib import Path

        import reference
        import restir_gi
        import tests
        from hypothesis import HealthCheck, given, settings
        from mine import Mine
        from restir_gi.reference.strategies import uniforms

        def test_names_are_whose_they_were():
            assert reference.OWNER == tests.OWNER == "the guest"
            installed = os.environ["PYTHONPATH"].split(os.pathsep)[0]
            assert Path(restir_gi.__file__).is_relative_to(installed)

        def test_mine(restir_oracle):
            assert restir_oracle.check(Mine(), budget=120).status == "PASS"

        @settings(
            max_examples=5,
            deadline=None,
            suppress_health_check=[HealthCheck.too_slow],
        )
        @given(uniforms(rows=3))
        def test_strategies_are_there(u):
            assert u.shape == (3,)
    """,
}


@pytest.fixture
def guest(wheel, tmp_path):
    """Run a module of Python in a project of somebody else; returns the result."""
    installed = tmp_path / "installed"
    with ZipFile(wheel) as archive:
        archive.extractall(installed)
    project = tmp_path / "project"
    for name, text in GUEST.items():
        (project / name).parent.mkdir(parents=True, exist_ok=True)
        (project / name).write_text(dedent(text), "utf-8")

    def run(*words):
        # Without `site` (-S) nothing is on the path that is installed in place.
        path = os.pathsep.join([str(installed), sysconfig.get_path("purelib")])
        return subprocess.run(
            [sys.executable, "-S", "-m", *words],
            cwd=project,
            env={**os.environ, "PYTHONPATH": path},
            capture_output=True,
            text=True,
        )

    run.project = project
    return run


def test_a_guest_tests_with_the_fixture_and_the_strategies(guest):
    result = guest("pytest", "-q", "-p", "no:cacheprovider")
    assert result.returncode == 0, result.stdout + result.stderr
    assert "3 passed" in result.stdout


def test_a_guest_is_checked(guest):
    words = ("check", "mine.py:Mine", "--budget", "120", "--json")
    result = guest("restir_gi.reference", *words)
    assert result.returncode == 0, result.stdout + result.stderr
    verdict = json.loads(result.stdout)
    assert verdict["status"] == "PASS"


def test_every_entry_point_of_the_wheel_loads_beside_a_guest(guest):
    """Methods, figures, passes and kernels of the upper packages, too."""
    (guest.project / "every.py").write_text(
        dedent("""
            from importlib.metadata import distribution

            points = distribution("restir-gi-oracle").entry_points
            assert all(point.load() for point in points)
            assert all(point.value.startswith("restir_gi.") for point in points)
            print(len({point.group for point in points}))
        """)
    )
    result = guest("every")
    assert (result.returncode, result.stdout) == (0, "6\n"), result.stderr


def test_control_a_guest_with_the_same_name_would_be_disturbed(guest):
    """Names of the guest do come first: what was no conflict could have been one."""
    (guest.project / "restir_gi").mkdir()
    (guest.project / "restir_gi" / "__init__.py").touch()
    result = guest("pytest", "-q", "-p", "no:cacheprovider")
    assert result.returncode != 0
    assert "No module named 'restir_gi.reference'" in result.stderr
