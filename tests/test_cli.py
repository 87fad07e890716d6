"""The command line: what it prints, and that every failure is one sentence."""

from __future__ import annotations

import io
import os
import subprocess
import sys
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

import rb_physics as rb
from rb_physics import cli
from rb_physics import progress as progress_module


def call(*arguments: str) -> Result:
    return CliRunner().invoke(cli.main, list(arguments))


def test_scenes_are_listed_with_their_descriptions() -> None:
    result = call("scenes")
    assert result.exit_code == 0
    assert "tower10" in result.output
    assert "A tower of 10 boxes at rest" in result.output


def test_topics_are_listed_with_type_frame_rate_and_qos(tmp_path: Path) -> None:
    result = call("topics", "single_box", "--node", "robots/sim")
    assert result.exit_code == 0, result.output
    lines = {line.split()[1]: line for line in result.output.splitlines()[1:]}
    line = " ".join(lines["/robots/sim/bodies/box/contact_wrench"].split())
    wrench = "geometry_msgs/msg/WrenchStamped"
    assert line.endswith(f"{wrench} box/com 100 Hz reliable volatile 10")
    assert lines["/robots/sim/bodies/box/wrench"].startswith("in")
    assert "on change" in lines["/tf_static"]
    bad = tmp_path / "topics.yaml"
    bad.write_text("topics:\n  - {name: /clock, content: clok, type: x, direction: out}\n")
    result = call("topics", "--topics", str(bad))
    assert result.exit_code == 1
    assert "topics.yaml:2: topic /clock: content is 'clok' (did you mean clock?)" in result.output
    # Refused here as by the node: a wrench on what can't be pushed.
    bad.write_text(
        "topics:\n  - {name: ~/bodies/NAME/wrench, content: wrench, direction: in, bodies: all,"
        " type: geometry_msgs/msg/WrenchStamped}\n"
    )
    result = call("topics", "single_box", "--topics", str(bad))
    assert result.exit_code == 1
    assert "is for a dynamic body, but 'ground' is static" in result.output


def test_the_package_is_the_command() -> None:
    command = [sys.executable, "-m", "rb_physics", "scenes"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert "tower10" in done.stdout


def test_run_reports_steps_and_the_hash_of_the_same_run_in_python() -> None:
    result = call("run", "single_box", "--duration", "0.05")
    assert result.exit_code == 0, result.output
    assert "50 steps, 2 bodies" in result.output
    world = rb.load_scene("single_box").build()
    world.step(50)
    assert f"state hash {world.state_hash:016x}" in result.output


def test_run_takes_a_path_and_records_into_a_new_folder(tmp_path: Path) -> None:
    scene = tmp_path / "mine.yaml"
    scene.write_text("bodies: [{name: stone, mass: 1, shape: {type: sphere, radius: 0.1}}]")
    folder = tmp_path / "run"
    result = call("run", str(scene), "--duration", "0.1", "--record", str(folder), "--no-rerun")
    assert result.exit_code == 0, result.output
    assert str(folder) in result.output
    assert (folder / "metadata.yaml").is_file()
    assert list(folder.glob("*.mcap"))
    assert not list(folder.glob("*.rrd"))
    again = call("run", str(scene), "--duration", "0.1", "--record", str(folder))
    assert again.exit_code == 1
    assert "exist" in again.output


def test_recorded_and_unrecorded_runs_end_in_the_same_state(tmp_path: Path) -> None:
    plain = call("run", "demo", "--duration", "0.3")
    recorded = call(
        "run", "demo", "--duration", "0.3", "--record", str(tmp_path / "r"), "--no-rerun"
    )
    lines = [r.output.split("state hash ")[1].split()[0] for r in (plain, recorded)]
    assert lines[0] == lines[1]


def test_info_summarises_a_run(tmp_path: Path) -> None:
    folder = tmp_path / "run"
    assert (
        call("run", "demo", "--duration", "0.2", "--record", str(folder), "--no-rerun").exit_code
        == 0
    )
    result = call("info", str(folder))
    assert result.exit_code == 0, result.output
    assert "/sim_node/poses" in result.output
    assert "demo" in result.output


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("run", "demmo"), "no packaged scene 'demmo'; did you mean 'demo'?"),
        (("run", "nowhere.yaml"), "the scene file nowhere.yaml does not exist"),
        (("run", "demo", "--duration", "-1"), "-1"),
        (("run", "demo", "--duration", "nan"), "nan"),
        (("run", "demo", "--duration", "1e-9"), "less than one step of 0.001 s"),
        (("run", "demo", "--no-rerun"), "--no-rerun goes with --record DIR only"),
        (("run", "demo", "--record", "/proc/run"), "/proc/run"),
        (("info", "nowhere"), "nowhere"),
        (("view", "nowhere", "--png", "new.png"), "nowhere"),
        (("nonsense",), "No such command 'nonsense'"),
    ],
)
def test_failure_is_a_sentence_and_a_non_zero_exit(
    arguments: tuple[str, ...], message: str
) -> None:
    result = call(*arguments)
    assert result.exit_code != 0
    assert isinstance(result.exception, SystemExit), "a traceback"
    assert message in result.output


def test_unexpected_errors_are_not_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    def fail(name: str) -> None:
        raise ValueError("a bug")

    monkeypatch.setattr("rb_physics.scene.load_scene", fail)
    assert str(call("run", "demo").exception) == "a bug"


def test_missing_library_is_named() -> None:
    code = """
import sys
sys.modules["yaml"] = None  # as if it were not installed
from rb_physics.cli import main
main(["run", "demo"])
"""
    done = in_a_process(code)
    assert done.returncode == 1
    assert done.stderr.startswith("Error: yaml is missing from this environment: pip install")


def in_a_process(
    code: str, *arguments: str, cwd: Path | None = None
) -> subprocess.CompletedProcess[str]:
    path = os.pathsep.join(filter(None, [str(Path(rb.__file__).parents[1]), *sys.path]))
    return subprocess.run(
        [sys.executable, "-c", code, *arguments],
        capture_output=True, text=True, timeout=60, cwd=cwd, env={**os.environ, "PYTHONPATH": path},
    )  # fmt: skip


def test_command_works_from_any_folder(tmp_path: Path) -> None:
    code = "from rb_physics.cli import main; main()"
    done = in_a_process(code, "run", "single_box", "--duration", "0.01", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "10 steps" in done.stdout
    assert done.stderr == ""


def test_progress_is_a_bar_on_a_terminal_and_lines_elsewhere(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(progress_module, "LINE_EVERY", 0.0)
    plain = io.StringIO()
    with progress_module.Progress(20, 0.1, plain) as progress:
        progress(10)
        progress(10)
    assert plain.getvalue() == "1.0 of 2.0 s simulated\n2.0 of 2.0 s simulated\n"

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    terminal = Terminal()
    with progress_module.Progress(20, 0.1, terminal) as progress:
        progress(10)
        progress(10)
    assert "100%" in terminal.getvalue()
    assert "2.0/2.0 s simulated" in terminal.getvalue()
