"""The linker: WGSL files with import lines become one text, with a map back to files and lines.

Import lines have WESL's syntax:

    import package::ray::Ray;                    a file of the package, wgsl/ray.wgsl
    import package::ray::{Ray, point_at as at};  several, renamed
    import slot::transfer::classify;             whatever fills the slot
    import generated::blinn_phong::params;       what the host declares: parameters, resources, constants
    import next::several::layer::span_of;        of the same file for the next layer; NAME_end.wgsl behind the last one

Nothing else is added to WGSL. Files that belong to a layer are instantiated once per layer: the names they declare get the
suffix ``_0``, ``_1`` ...; other names stay as they are written, and a name that two files declare is an error.

Where there are several layers, what is asked of a layer from outside of layers is asked of all: instead of a file that belongs
to a layer the one of the same path below ``several/`` is taken, if there is one, and ``several/slots.wgsl`` for what fills
slots.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from ..errors import ShaderError
from ..stage import SLOTS

_TOKEN = re.compile(
    r"(?P<comment>//[^\n]*|/\*.*?\*/)|(?P<name>[A-Za-z_]\w*)|(?P<number>\d[\w.]*)|(?P<space>\s+)|(?P<mark>.)", re.DOTALL
)
_IMPORT = re.compile(r"^\s*import\b(?P<what>[^;]*)(?P<end>;?)")
_ITEM = re.compile(r"^\s*(?P<name>\w+)(?:\s+as\s+(?P<alias>\w+))?\s*$")
_STAGES = ("vertex", "fragment", "compute")
_DECLARING = ("fn", "struct", "const", "override", "alias", "var")
_WHERE_IN_MESSAGE = re.compile(r"\bwgsl:(\d+):(\d+)")


@dataclass(frozen=True)
class Source:
    """A WGSL text and the name under which errors show it."""

    name: str
    text: str


class Import(NamedTuple):
    """One imported name."""

    path: tuple[str, ...]
    name: str
    local: str
    line: int


class Token(NamedTuple):
    """A piece of text of one kind."""

    kind: str
    text: str
    line: int


@dataclass(frozen=True)
class Module:
    """A parsed source: its imports, the names it declares with their lines, and its tokens."""

    source: Source
    imports: tuple[Import, ...]
    declared: Mapping[str, int]
    tokens: tuple[Token, ...]
    locals: frozenset[str]


@dataclass(frozen=True)
class Generated:
    """What the host declares: WGSL text, and what imported names stand for.

    ``names`` maps ``(module, instance, name)`` to text that takes the name's place; ``instance`` is None outside of layers.
    ``first`` are statements with which every entry point begins.
    """

    text: str = ""
    names: Mapping[tuple[str, int | None, str], str] = field(default_factory=dict)
    first: str = ""


@dataclass(frozen=True)
class Linked:
    """One WGSL text, and for each of its lines the file and line that it came from."""

    text: str
    origins: tuple[tuple[str, int], ...]

    def origin(self, line: int) -> tuple[str, int]:
        """File and line of a line of the text, counted from one."""
        return self.origins[line - 1] if 0 < line <= len(self.origins) else ("generated", line)

    def explain_message(self, message: str) -> str:
        """Replace the positions in a compiler's message by positions in the files."""

        def place(match: re.Match[str]) -> str:
            name, line = self.origin(int(match[1]))
            return f"{name}:{line}:{match[2]}"

        return _WHERE_IN_MESSAGE.sub(place, message)


@lru_cache(maxsize=256)
def has_source(path: str) -> bool:
    """Whether the package has a file below ``airlight/wgsl``."""
    return (files("airlight") / "wgsl" / path).is_file()


@lru_cache(maxsize=256)
def package_source(path: str) -> Source:
    """Source of a file below ``airlight/wgsl``."""
    file = files("airlight") / "wgsl" / path
    try:
        return Source(path, file.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError, IsADirectoryError):
        raise ShaderError(path, "is not part of the package", "check the import's path") from None


def stage_source(wgsl: str | Path, name: str) -> Source:
    """Source of a stage's device half: a path below ``airlight/wgsl``, any ``Path``, or the text itself."""
    if isinstance(wgsl, Path):
        try:
            return Source(str(wgsl), wgsl.read_text(encoding="utf-8"))
        except OSError as error:
            raise ShaderError(str(wgsl), f"cannot be read ({error.strerror})") from error
    if "\n" in wgsl:
        return Source(f"<{name}>", wgsl)
    return package_source(wgsl)


@lru_cache(maxsize=256)
def parse(source: Source) -> Module:
    """Split a source into imports, declarations and tokens."""
    text, imports = _take_imports(source)
    tokens = tuple(_tokens(text))
    declared: dict[str, int] = {}
    inner: set[str] = set()
    code = [t for t in tokens if t.kind not in ("space", "comment")]
    depth = 0
    for at, token in enumerate(code):
        depth += (token.text in "{(") - (token.text in "})") if token.kind == "mark" else 0
        if token.kind == "name" and token.text in _DECLARING and at + 1 < len(code):
            name = _declared_name(code, at + 1)
            if depth == 0 and name:
                if name.text in declared:
                    raise ShaderError(f"{source.name}:{name.line}", f"declares {name.text!r} again")
                declared[name.text] = name.line
            elif name:
                inner.add(name.text)
        elif token.text == "let" and at + 1 < len(code):
            inner.add(code[at + 1].text)
        elif depth and token.kind == "name" and code[at + 1 : at + 2] and code[at + 1].text == ":":
            inner.add(token.text)
    return Module(source, imports, declared, tokens, frozenset(inner))


def _declared_name(code: list[Token], at: int) -> Token | None:
    if code[at].text == "<":
        while at < len(code) and code[at].text != ">":
            at += 1
        at += 1
    return code[at] if at < len(code) and code[at].kind == "name" else None


def _tokens(text: str) -> Iterator[Token]:
    line = 1
    for match in _TOKEN.finditer(text):
        kind, piece = match.lastgroup or "mark", match[0]
        yield Token(kind, piece, line)
        if kind in ("space", "comment"):
            line += piece.count("\n")


def _take_imports(source: Source) -> tuple[str, tuple[Import, ...]]:
    """Blank the import lines, so that lines keep their numbers."""
    imports: list[Import] = []
    kept: list[str] = []
    for number, line in enumerate(source.text.split("\n"), 1):
        match = _IMPORT.match(line)
        if not match:
            kept.append(line)
            continue
        where = f"{source.name}:{number}"
        if not match["end"]:
            raise ShaderError(where, "has an import without ';' on its line")
        head, _, tail = match["what"].strip().rpartition("::")
        items = tail.strip()[1:-1].split(",") if tail.strip().startswith("{") else [tail]
        path = tuple(part.strip() for part in head.split("::"))
        for item in items:
            parsed = _ITEM.match(item)
            if not parsed or not head or path[0] not in ("package", "slot", "generated", "next"):
                raise ShaderError(
                    where,
                    f"has an import that cannot be read: {line.strip()!r}",
                    "write import package::file::name; or slot::, generated::, next::",
                )
            imports.append(Import(path, parsed["name"], parsed["alias"] or parsed["name"], number))
        kept.append("")
    return "\n".join(kept), tuple(imports)


# -- linking

CHOSEN_PER_LAYER = frozenset({"piece", "taps"})
"""What is imported like a slot of layers, but filled by the host: a choice that a layer's stage makes for files it shares."""

Place = tuple[str, int | None]
"""A module by the name of its source, and the layer it is instantiated for; None outside of layers."""


@dataclass
class _Linker:
    slots: Mapping[str, tuple[tuple[str, Source], ...]]
    generated: Generated
    order: list[tuple[Module, int | None, str | None]] = field(default_factory=list)
    done: set[Place] = field(default_factory=set)
    stack: list[Place] = field(default_factory=list)
    names: dict[str, str] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of layers."""
        return max((len(fillers) for fillers in self.slots.values()), default=0)

    def visit(self, source: Source, instance: int | None, slot: str | None, wanted_at: str) -> Module:
        module = parse(source)
        instance = instance if self.is_layered(module) or self.per_layer(slot) else None
        place = (source.name, instance)
        if place in self.stack:
            ring = " -> ".join(name for name, _ in [*self.stack[self.stack.index(place) :], place])
            raise ShaderError(wanted_at, f"closes a ring of imports: {ring}")
        if place in self.done:
            return module
        self.stack.append(place)
        for item in module.imports:
            if item.path[0] != "generated":
                target, slot_of_target, at = self.target(item, module, instance)
                self.visit(target, at, slot_of_target, f"{source.name}:{item.line}")
        self.stack.pop()
        self.done.add(place)
        self.order.append((module, instance, slot))
        return module

    def target(self, item: Import, module: Module, instance: int | None) -> tuple[Source, str | None, int | None]:
        """Source that an import names, the slot that it fills, and the layer that it is wanted for."""
        where = f"{module.source.name}:{item.line}"
        path = "/".join(item.path[1:])
        if item.path[0] == "package":
            return self.of_all(package_source(f"{path}.wgsl"), instance), None, instance
        if item.path[0] == "next":
            following = 0 if instance is None else instance + 1
            is_last = following >= self.count
            return package_source(f"{path}{'_end' * is_last}.wgsl"), None, None if is_last else following
        slot = item.path[1] if len(item.path) == 2 else ""
        if slot not in self.slots:
            raise ShaderError(where, f"imports from slot {'::'.join(item.path[1:])!r}, which nothing fills")
        fillers, per_layer = self.slots[slot], self.per_layer(slot)
        of_all = per_layer and instance is None and self.count > 1
        if of_all:
            source = package_source("several/slots.wgsl")
        elif per_layer:
            instance = instance or 0
            source = fillers[instance][1]
        else:
            source = self.of_all(fillers[0][1], instance)
        at = instance if per_layer or self.count > 1 else None
        declared = parse(source).declared
        if item.name not in declared:
            if slot in SLOTS and item.name in SLOTS[slot].optional:
                file = SLOTS[slot].defaults.get(item.name, item.name)
                return package_source(f"defaults/{file}.wgsl"), None, at
            if of_all:
                raise ShaderError(where, f"imports {item.name!r} of a layer, but there are {len(fillers)} layers")
            raise ShaderError(where, f"imports {item.name!r} from slot {slot}, but {source.name} does not define it")
        return source, None if of_all else slot, at

    def of_all(self, source: Source, instance: int | None) -> Source:
        """The file that speaks for all layers, where a layer's is wanted from outside of several layers."""
        together = f"several/{source.name}"
        wanted = instance is None and self.count > 1 and has_source(together) and self.is_layered(parse(source))
        return package_source(together) if wanted else source

    def per_layer(self, slot: str | None) -> bool:
        """Whether each layer has its own filler of a slot."""
        return _per_layer(slot) or (slot is not None and len(self.slots.get(slot, ())) > 1)

    def is_layered(self, module: Module, above: tuple[str, ...] = ()) -> bool:
        """Whether a module reaches, through its imports, what belongs to a layer."""
        if module.source.name in above:
            return False  # a ring, which ``visit`` reports
        above = (*above, module.source.name)
        for item in module.imports:
            kind, name = item.path[0], item.path[1] if len(item.path) > 1 else ""
            if kind == "slot" and self.per_layer(name):
                return True
            if kind == "generated" and self.generated_is_layered(name, item.name):
                return True
            if kind == "package" and self.is_layered(parse(package_source("/".join(item.path[1:]) + ".wgsl")), above):
                return True
        return False

    def generated_is_layered(self, name: str, what: str) -> bool:
        return any((name, layer, what) in self.generated.names for layer in range(max(self.count, 1)))

    def global_name(self, name: str, instance: int | None) -> str:
        return name if instance is None else f"{name}_{instance}"

    def replacements(self, module: Module, instance: int | None, slot: str | None) -> dict[str, str]:
        """What each name of the module's scope becomes in the linked text."""
        found: dict[str, str] = {name: self.global_name(name, instance) for name in module.declared}
        for item in module.imports:
            where = f"{module.source.name}:{item.line}"
            if item.local in found:
                raise ShaderError(where, f"imports {item.local!r}, which the file declares or imports already")
            if item.path[0] == "generated":
                found[item.local] = self.generated_name(item, where, instance, slot)
                continue
            target, target_slot, at = self.target(item, module, instance)
            parsed = parse(target)
            if item.name not in parsed.declared:
                raise ShaderError(where, f"imports {item.name!r}, which {target.name} does not declare")
            layered = self.is_layered(parsed) or self.per_layer(target_slot)
            found[item.local] = self.global_name(item.name, at if layered else None)
        return found

    def generated_name(self, item: Import, where: str, instance: int | None, slot: str | None) -> str:
        """What the host made of a name; a stage's own module is known by the stage's name and by its slot's."""
        name = item.path[1] if len(item.path) == 2 else ""
        own: str = slot if slot and name in (slot, self.slots[slot][instance or 0 if self.per_layer(slot) else 0][0]) else name
        for key in ((own, instance, item.name), (own, None, item.name), (own, 0, item.name)):
            if key in self.generated.names:
                return self.generated.names[key]
        raise ShaderError(where, f"imports {item.name!r} of generated::{name}, which the host does not declare")


def link(root: Source, slots: Mapping[str, tuple[tuple[str, Source], ...]], generated: Generated) -> Linked:
    """Join a driver with what fills its slots.

    Parameters
    ----------
    root
        The driver's source.
    slots
        For each slot the name and source of its stage; one for each layer where the slot belongs to layers.
    generated
        What the host declares.

    Raises
    ------
    ShaderError
        With file and line: unreadable imports, rings, missing or doubled names, unfilled slots, and names that are used
        without being imported.
    """
    linker = _Linker(slots, generated)
    for slot, fillers in slots.items():
        for _, source in fillers:
            _check_stage(slot, source)
    linker.visit(root, None, None, root.name)
    lines: list[str] = []
    origins: list[tuple[str, int]] = []

    def add(text: str, name: str, note: str = "") -> None:
        new = text.split("\n")
        lines.extend([f"// -- {name}{note}", *new])
        origins.extend([(name, 0), *((name, number) for number in range(1, len(new) + 1))])

    add(generated.text, "generated")
    homes: dict[str, str] = dict.fromkeys(parse(Source("generated", generated.text)).declared, "generated:1")
    for module, instance, _ in linker.order:
        for name, line in module.declared.items():
            full = linker.global_name(name, instance)
            here = f"{module.source.name}:{line}"
            if full in homes:
                raise ShaderError(here, f"declares {full!r}, which {homes[full]} declares already", "rename one of them")
            homes[full] = here
    for module, instance, filled in linker.order:
        replace = linker.replacements(module, instance, filled)
        _check_imported(module, replace, homes)
        note = "" if instance is None else f" (layer {instance})"
        add(_rewritten(module, replace, generated.first), module.source.name, note)
    return Linked("\n".join(lines) + "\n", tuple(origins))


def _per_layer(slot: str | None) -> bool:
    return slot in CHOSEN_PER_LAYER or (slot in SLOTS and SLOTS[slot].per_layer)


def _check_stage(slot: str, source: Source) -> None:
    """Require the functions of the slot's contract."""
    if slot not in SLOTS:
        return
    missing = [name for name in SLOTS[slot].functions if name not in parse(source).declared]
    if missing:
        wanted = ", ".join(f"{name}: {SLOTS[slot].functions[name]}" for name in missing)
        raise ShaderError(f"{source.name}:1", f"does not define what slot {slot} asks for: {wanted}")


def _check_imported(module: Module, replace: Mapping[str, str], homes: Mapping[str, str]) -> None:
    before = ""
    for token in module.tokens:
        if token.kind in ("space", "comment"):
            continue
        if token.kind == "name" and before != "." and token.text not in replace and token.text not in module.locals:
            home = homes.get(token.text)
            if home is not None:
                raise ShaderError(f"{module.source.name}:{token.line}", f"uses {token.text!r} of {home} without importing it")
        before = token.text


def _rewritten(module: Module, replace: Mapping[str, str], first: str) -> str:
    """Text of the module with its names replaced, line by line as it was, but for what entry points do first."""
    out: list[str] = []
    code = [(at, t) for at, t in enumerate(module.tokens) if t.kind not in ("space", "comment")]
    following = {at: code[i + 1][1].text if i + 1 < len(code) else "" for i, (at, _) in enumerate(code)}
    before, in_struct, depth, is_entry = "", False, 0, False
    for at, token in enumerate(module.tokens):
        text = token.text
        if token.kind == "name":
            is_entry = is_entry or (before == "@" and text in _STAGES)
            if text == "struct":
                in_struct = True
            is_member = in_struct and depth == 1 and following[at] == ":"
            if before not in (".", "@") and not is_member:
                text = replace.get(text, text)
        elif token.kind == "mark" and text in "{}":
            depth += 1 if text == "{" else -1
            in_struct = in_struct and depth > 0
            if is_entry:
                text, is_entry = " ".join([text, first] if first else [text]), False
        if token.kind not in ("space", "comment"):
            before = token.text
        out.append(text)
    return "".join(out)
