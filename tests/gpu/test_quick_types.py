"""Quick parsing of C types gives the types that cffi gives by itself."""

from __future__ import annotations

import subprocess
import sys

CODE = """
from wgpu.backends.wgpu_native._ffi import ffi
from airlight.gpu.quick_types import parse_types_quickly
texts = ["WGPUDeviceDescriptor *", "WGPUBindGroupEntry[]", "uint8_t []", "char []", "uintptr_t", "WGPUAdapter[]",
         "void(WGPUDevice const *, WGPUErrorType, WGPUStringView, void *, void *)", "WGPUChainedStruct * "]
plain = [ffi._parser.parse_type(text) for text in texts]
assert parse_types_quickly()
quick = [ffi._parser.parse_type(text) for text in texts]
assert plain == quick, (plain, quick)
try:
    ffi._parser.parse_type("NoSuchType *")
except Exception as error:
    assert "NoSuchType" in str(error), error
else:
    raise AssertionError("an unknown type was parsed")
"""


def test_types_are_the_same():
    subprocess.run([sys.executable, "-c", CODE], check=True, timeout=60)


def test_without_the_expected_insides_nothing_is_done(monkeypatch):
    import wgpu.backends.wgpu_native._ffi as inside

    from airlight.gpu.quick_types import parse_types_quickly

    class Other:
        pass

    monkeypatch.setattr(inside, "ffi", Other())
    assert not parse_types_quickly()
