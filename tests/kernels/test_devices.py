"""OpenCL devices are found, or one line says why there is none."""

import os
import subprocess
import sys
from types import SimpleNamespace

import pyopencl as cl
import pytest
from makeup_video.kernels import devices
from makeup_video.kernels.devices import NoDeviceError, UnknownDeviceError, pick
from makeup_video.kernels.program import Device


def test_devices_are_picked_by_number_and_by_name():
    first = pick()
    assert pick("0") == first
    assert pick(first.name[:6].upper()) == first
    for wrong in ("99", "no such device"):
        with pytest.raises(UnknownDeviceError, match=r"there is: 0 ") as caught:
            pick(wrong)
        assert "\n" not in str(caught.value)


def test_a_number_beyond_the_devices_is_a_part_of_a_name(monkeypatch):
    platform = SimpleNamespace(name="Card")
    names = ("RTX 3080", "RTX 4090", "Arc 1")
    found = [SimpleNamespace(name=name, platform=platform) for name in names]
    monkeypatch.setattr(devices, "_found", lambda: found)
    picked = [pick(choice).name for choice in ("4090", "1", "0")]
    assert picked == ["RTX 4090", "RTX 4090", "RTX 3080"]


def test_pocl_comes_first_among_platforms(monkeypatch):
    class Platform:
        def __init__(self, name, names):
            self.name, self.names = name, names

        def get_devices(self):
            if not self.names:
                raise cl.RuntimeError("clGetDeviceIDs failed: DEVICE_NOT_FOUND")
            return self.names

    platforms = [Platform("Card", ["gpu"]), Platform("Empty", []),
                 Platform("Portable Computing Language", ["cpu"])]  # fmt: skip
    monkeypatch.setattr(cl, "get_platforms", lambda: platforms)
    monkeypatch.setenv("POCL_DEVICES", "any")
    assert devices.devices() == ["cpu", "gpu"]


def test_the_device_without_threads_comes_first_by_default(monkeypatch):
    code = "from makeup_video.kernels.devices import devices; print(*[d.name for d in devices()])"
    names = []
    for chosen in (None, "pthread"):
        environment = {name: value for name, value in os.environ.items() if name != "POCL_DEVICES"}
        environment |= {"POCL_DEVICES": chosen} if chosen else {}
        names.append(
            subprocess.check_output([sys.executable, "-c", code], text=True, env=environment)
        )
    assert names[0].startswith("basic") and "pthread" in names[0]
    assert names[1].startswith("pthread") and "basic" not in names[1]


def test_pocl_is_asked_again_without_names_it_does_not_know(monkeypatch):
    monkeypatch.delenv("POCL_DEVICES", raising=False)
    found = devices._found()
    monkeypatch.setattr(devices, "_found", lambda: [] if "POCL_DEVICES" in os.environ else found)
    assert devices.devices() == found
    assert "POCL_DEVICES" not in os.environ


def no_platform():
    raise cl.LogicError("clGetPlatformIDs failed: PLATFORM_NOT_FOUND_KHR")


@pytest.mark.parametrize("platforms", [no_platform, list])
def test_without_any_device_one_line_says_what_to_install(monkeypatch, platforms):
    monkeypatch.setattr(cl, "get_platforms", platforms)
    with pytest.raises(NoDeviceError, match="pip install pocl-binary-distribution") as caught:
        Device()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("variable", "value", "message"),
    [
        (
            "POCL_DEVICES",
            "junk",
            "POCL_DEVICES='junk' names a device that PoCL does not know: unset",
        ),
        ("POCL_DEVICES", "", "POCL_DEVICES='' names a device"),
        ("OCL_ICD_VENDORS", "{file}", "found none where the environment says to look (OCL_ICD_VEN"),
    ],
)
def test_a_variable_that_hides_every_device_is_named(tmp_path, variable, value, message):
    (tmp_path / "empty.icd").touch()
    code = "from makeup_video.kernels.devices import devices; devices()"
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, variable: value.format(file=tmp_path / "empty.icd")},
        check=False,
        capture_output=True,
        text=True,
    )
    last = done.stderr.splitlines()[-1]
    assert "NoDeviceError: " in last and message in last and "pip install" not in last
