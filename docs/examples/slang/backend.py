"""A backend in HLSL: Slang compiles it to WGSL, which runs through wgpu-py.

    pip install '.[shader,slang]'
    restir check docs/examples/slang/backend.py

The host's side is that of the WGSL example beside this folder, with the same mistakes
for ``RESTIR_PLANT`` and the same ``RESTIR_ADAPTER``.  ``python backend.py pass_target``
prints what Slang makes of an entry point.
"""

import ctypes
import importlib.util
import sys
from functools import cache
from pathlib import Path

HERE = Path(__file__).parent


def loaded(path):
    """A Python file as a module."""
    found = importlib.util.spec_from_file_location(path.parent.name, path)
    module = importlib.util.module_from_spec(found)
    found.loader.exec_module(module)
    return module


HOST = loaded(HERE.parent / "wgsl" / "backend.py")
PLANTS, best_adapter = HOST.PLANTS, HOST.best_adapter

# Numbers of slang.h.
WGSL, HLSL, COMPUTE, PRECISE = 28, 2, 6, 2


@cache
def compiler():
    """Slang's library, as slangpy brings it, with the types of its calls."""
    package = importlib.util.find_spec("slangpy")
    folder = Path(package.origin).parent if package else HERE
    names = ("libslang-compiler.so*", "libslang-compiler*.dylib", "slang-compiler*.dll")
    files = [file for name in names for file in sorted(folder.glob(name))]
    if not files:
        raise ImportError("no Slang compiler here; pip install slangpy")
    library = ctypes.CDLL(str(files[0]))
    handle, number, text = ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p
    calls = {
        "spCreateSession": (handle, text),
        "spDestroySession": (None, handle),
        "spCreateCompileRequest": (handle, handle),
        "spDestroyCompileRequest": (None, handle),
        "spAddCodeGenTarget": (number, handle, number),
        "spSetTargetFloatingPointMode": (None, handle, number, number),
        "spAddTranslationUnit": (number, handle, number, text),
        "spAddTranslationUnitSourceString": (None, handle, number, text, text),
        "spAddEntryPoint": (number, handle, number, text, number),
        "spCompile": (number, handle),
        "spGetDiagnosticOutput": (text, handle),
        "spGetEntryPointCode": (handle, handle, number, handle),
    }
    for name, (result, *arguments) in calls.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


def as_wgsl(path, entry):
    """The text that Slang makes of one entry point of a file."""
    slang = compiler()
    session = slang.spCreateSession(None)
    request = slang.spCreateCompileRequest(session)
    target = slang.spAddCodeGenTarget(request, WGSL)
    slang.spSetTargetFloatingPointMode(request, target, PRECISE)
    unit = slang.spAddTranslationUnit(request, HLSL, b"restir")
    about = str(path).encode(), path.read_bytes()
    slang.spAddTranslationUnitSourceString(request, unit, *about)
    number = slang.spAddEntryPoint(request, unit, entry.encode(), COMPUTE)
    try:
        if slang.spCompile(request) < 0:
            raise ValueError(slang.spGetDiagnosticOutput(request).decode())
        size = ctypes.c_size_t()
        start = slang.spGetEntryPointCode(request, number, ctypes.byref(size))
        return ctypes.string_at(start, size.value).decode()
    finally:
        slang.spDestroyCompileRequest(request)
        slang.spDestroySession(session)


class SlangBackend(HOST.WgslBackend):
    """The passes of restir.hlsl, compiled on the first call."""

    def _module_of(self, name):
        code = as_wgsl(HERE / "restir.hlsl", f"pass_{name}")
        return self._device.create_shader_module(code=code)


BACKEND = SlangBackend()

if __name__ == "__main__":
    for name in sys.argv[1:]:
        print(as_wgsl(HERE / "restir.hlsl", name))
