"""Quicker first calls of wgpu: its C types are parsed with the names they mention, instead of with all names there are.

wgpu-py names C types as text, and cffi parses each text after declarations of every type name of the library: 13 ms for each
of the fifty types that a first frame asks for, 0.7 s in all (measured, wgpu-py 0.32, cffi 2.1). The names that a text does not
mention cannot change its meaning, so they are left out while it is parsed. Where cffi's insides are not as expected, nothing
is done, and first calls are slow.
"""

from __future__ import annotations

import re
from typing import Any


def parse_types_quickly() -> bool:
    """Make the parser of wgpu's C library quick; returns whether it was done."""
    try:
        from wgpu.backends.wgpu_native._ffi import ffi

        parser = ffi._parser
        parse, declarations = parser._parse, parser._declarations
    except (ImportError, AttributeError):
        return False
    if not callable(parse) or not isinstance(declarations, dict) or not any(k.startswith("typedef ") for k in declarations):
        return False

    def parse_with_names_mentioned(text: str) -> Any:
        everything = parser._declarations
        mentioned = {f"typedef {word}" for word in re.findall(r"\w+", text)}
        parser._declarations = {name: everything[name] for name in mentioned & everything.keys()}
        try:
            return parse(text)
        finally:
            parser._declarations = everything

    parser._parse = parse_with_names_mentioned
    return True
