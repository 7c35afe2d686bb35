"""The linker: imports, slots, instances, generated names, and an error with file and line for each mistake."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from airlight.errors import ShaderError
from airlight.shader import link as linking
from airlight.shader.link import Generated, Source, link, parse

FIELD = Source(
    "my_field.wgsl",
    "import generated::field::params;\nstruct Place { p: vec3f }\nfn locate(p: vec3f) -> Place { return Place(p); }\n"
    "fn field_value(place: Place) -> f32 { return place.p.x * params.gain; }\n"
    "fn extent(place: Place, direction: vec3f) -> f32 { return 1.0; }",
)
NAMES = {("field", i, "params"): f"uniforms.field_{i}" for i in range(2)}


@pytest.fixture
def package(monkeypatch):
    """Package of WGSL files that a test makes."""
    known: dict[str, str] = {}

    def source(path: str) -> Source:
        if path not in known:
            raise ShaderError(path, "is not part of the package")
        return Source(path, known[path])

    monkeypatch.setattr(linking, "package_source", source)
    return known


def linked(text: str, slots=None, generated: Generated | None = None):
    return link(Source("root.wgsl", text), slots or {}, generated or Generated())


def test_imports_are_followed_once_and_lines_are_mapped(package):
    package["a.wgsl"] = "import package::b::two;\nfn one() -> f32 { return two(); }"
    package["b.wgsl"] = "// nothing\nfn two() -> f32 { return 2.0; }"
    result = linked("import package::a::one;\nimport package::b::two;\nfn main() -> f32 { return one() + two(); }")
    assert result.text.count("fn two()") == 1
    line = next(i for i, text in enumerate(result.text.split("\n"), 1) if "fn two()" in text)
    assert result.origin(line) == ("b.wgsl", 2)
    assert result.explain_message(f"wgsl:{line}:4 expected") == "b.wgsl:2:4 expected"


def test_renamed_imports_keep_members_and_comments(package):
    package["a.wgsl"] = "struct Ray { one: f32 }\nfn one() -> f32 { return 1.0; } // one"
    text = linked("import package::a::{one as uno, Ray};\nfn main(r: Ray) -> f32 { return uno() + r.one; } // uno").text
    assert "return one() + r.one; } // uno" in text
    assert "struct Ray { one: f32 }" in text


def test_a_layers_files_are_instantiated_with_suffixes(package):
    package["help.wgsl"] = (
        "import slot::field::{locate, field_value};\nfn at(p: vec3f) -> f32 { return field_value(locate(p)); }"
    )
    package["plain.wgsl"] = "fn same() -> f32 { return 1.0; }"
    gradient = Source(
        "g.wgsl",
        "import package::help::at;\nimport package::plain::same;\nimport slot::field::Place;\n"
        "fn field_gradient(place: Place) -> vec3f { return vec3f(at(place.p) + same()); }",
    )
    slots = {"field": (("f", FIELD), ("f", FIELD)), "gradient": (("g", gradient), ("g", gradient))}
    root = "import generated::layers::first;\nfn main() { }"
    names = NAMES | {("layers", None, "first"): "first"}
    package["several/slots.wgsl"] = ""
    with pytest.raises(ShaderError, match=r"root.wgsl:1 imports 'locate' of a layer, but there are 2 layers"):
        linked("import slot::field::locate;", slots, Generated("", NAMES))
    one = {slot: fillers[:1] for slot, fillers in slots.items()}
    text = linked("import slot::gradient::field_gradient;\nfn main() { }", one, Generated("", names)).text
    for name in ("fn field_gradient_0(place: Place_0)", "fn at_0(", "uniforms.field_0.gain", "fn same()"):
        assert name in text, name
    assert root


def test_what_the_host_chooses_for_a_layer_belongs_to_it(package):
    """Two layers share a file, and a piece of it is another one for each."""
    package["shared.wgsl"] = (
        "import generated::field::params;\nstruct Held { at: f32 }\nfn gain() -> f32 { return params.gain; }"
    )
    shared = "import package::shared::{Held, gain};\nfn between(held: Held) -> f32 { return gain() + held.at"
    one, other = (Source(f"{name}.wgsl", f"{shared} + {number}; }}") for name, number in (("one", "1.0"), ("other", "2.0")))
    field = Source(
        "f.wgsl", f"import slot::piece::between;\n{FIELD.text}\nfn twice(held: Held) -> f32 {{ return between(held); }}"
    )
    field = Source("f.wgsl", f"import package::shared::Held;\n{field.text}")
    linker = linking._Linker({"field": (("f", field),) * 2, "piece": (("one", one), ("other", other))}, Generated("", NAMES))
    for i in range(2):
        linker.visit(field, i, "field", "test")
    assert [(m.source.name, i) for m, i, _ in linker.order] == [
        ("shared.wgsl", 0), ("one.wgsl", 0), ("f.wgsl", 0), ("shared.wgsl", 1), ("other.wgsl", 1), ("f.wgsl", 1),
    ]  # fmt: skip
    assert linker.replacements(parse(field), 1, "field")["between"] == "between_1"
    assert linker.replacements(parse(other), 1, "piece")["Held"] == "Held_1"


def test_both_layers_are_reached_from_their_own_instances(package):
    """A driver for several layers imports one entry a layer; each reaches its own field."""
    linker = linking._Linker({"field": (("f", FIELD), ("f", FIELD))}, Generated("", NAMES))
    for i in range(2):
        linker.visit(FIELD, i, "field", "test")
    assert [(m.source.name, i) for m, i, _ in linker.order] == [("my_field.wgsl", 0), ("my_field.wgsl", 1)]
    assert linker.replacements(parse(FIELD), 1, "field")["params"] == "uniforms.field_1"


@pytest.mark.parametrize(
    ("files", "root", "message"),
    [
        ({}, "import package::a::b", "root.wgsl:1 has an import without ';'"),
        ({}, "\nimport nowhere::a::b;", "root.wgsl:2 has an import that cannot be read"),
        ({}, "import package::gone::b;", "gone.wgsl is not part of the package"),
        ({"a.wgsl": "fn c() {}"}, "import package::a::b;", "root.wgsl:1 imports 'b', which a.wgsl does not declare"),
        ({}, "import slot::shade::light;", "root.wgsl:1 imports from slot 'shade', which nothing fills"),
        ({}, "import generated::x::y;\nfn main() {}", "root.wgsl:1 imports 'y' of generated::x"),
        ({"a.wgsl": "fn b() {}"}, "import package::a::b;\nfn b() {}", "declares 'b', which a.wgsl:1 declares already"),
        ({}, "fn b() {}\nfn b() {}", "root.wgsl:2 declares 'b' again"),
        ({"a.wgsl": "fn b() {}\nfn c() {}"}, "import package::a::b;\nfn m() { c(); }", "root.wgsl:2 uses 'c' of a.wgsl:2"),
        (
            {"a.wgsl": "import package::b::y;\nfn x() {}", "b.wgsl": "import package::a::x;\nfn y() {}"},
            "import package::a::x;",
            "b.wgsl:1 closes a ring of imports: a.wgsl -> b.wgsl -> a.wgsl",
        ),
    ],
)
def test_mistakes_name_file_and_line(package, files, root, message):
    package.update(files)
    with pytest.raises(ShaderError) as caught:
        linked(root)
    assert message in str(caught.value)


def test_entry_points_alone_begin_with_what_the_host_says(package):
    package["a.wgsl"] = "fn one() -> f32 { return 1.0; }"
    root = (
        "import package::a::one;\n@compute @workgroup_size(8) // one {\n"
        "fn main(@builtin(position) p: vec4f)\n{ if (one() > p.x) {} }"
    )
    text = linked(root + "\nfn other() { }", generated=Generated("var<private> held: f32;", first="held = given;")).text
    assert text.count("held = given;") == 1
    assert "\n{ held = given; if (one() > p.x) {} }\nfn other() { }" in text
    assert "held = given;" not in linked(root).text


def test_a_stage_without_its_functions_is_refused():
    with pytest.raises(ShaderError, match=r"half.wgsl:1 does not define what slot field asks for: extent"):
        linked("fn main() {}", {"field": (("half", Source("half.wgsl", "fn locate() {}\nfn field_value() {}")),)})


def test_optional_functions_have_defaults():
    full = "fn begin() {}\nfn take() {}\nfn finish() {}"
    result = link(
        Source("root.wgsl", "import slot::integrate::surface;\nimport package::sample::Sample;\nfn main() {}"),
        {"integrate": (("mine", Source("mine.wgsl", full)),)},
        Generated("alias Values = f32;", {("sizes", None, "Values"): "Values"}),
    )
    assert "fn surface(front: Sample, back: Sample) -> f32 { return 2.0; }" in result.text


@given(st.text(alphabet="abfn(){};:,.<>/*\n import_0 structlet", max_size=300))
def test_any_text_parses_or_fails_with_a_clear_error(text):
    """Nothing but a ShaderError with a place may come out, and lines stay where they were."""
    try:
        module = parse(Source("any.wgsl", text))
    except ShaderError as error:
        place = error.where
    else:
        assert "".join(token.text for token in module.tokens).count("\n") == text.count("\n")
        place = "any.wgsl:0"
    assert place.startswith("any.wgsl:")


def test_several_layers_answer_as_one_and_a_chain_ends_behind_the_last(package, monkeypatch):
    monkeypatch.setattr(linking, "has_source", lambda path: path in package)
    package["ray.wgsl"] = "import slot::field::locate;\nfn way(p: vec3f) -> f32 { return locate(p).p.x; }"
    package["several/ray.wgsl"] = "import next::several::sum::total;\nfn way(p: vec3f) -> f32 { return total(p); }"
    package["several/sum.wgsl"] = (
        "import next::several::sum::total as rest;\nimport package::ray::way;\n"
        "fn total(p: vec3f) -> f32 { return way(p) + rest(p); }"
    )
    package["several/sum_end.wgsl"] = "fn total(p: vec3f) -> f32 { return 0.0; }"
    root = "import package::ray::way;\nfn main() -> f32 { return way(vec3f(0.0)); }"
    text = linked(root, {"field": (("f", FIELD), ("f", FIELD))}, Generated("", NAMES)).text
    for line in (
        "fn main() -> f32 { return way(vec3f(0.0)); }",
        "fn way(p: vec3f) -> f32 { return total_0(p); }",
        "fn total_0(p: vec3f) -> f32 { return way_0(p) + total_1(p); }",
        "fn total_1(p: vec3f) -> f32 { return way_1(p) + total(p); }",
        "fn way_1(p: vec3f) -> f32 { return locate_1(p).p.x; }",
        "fn total(p: vec3f) -> f32 { return 0.0; }",
    ):
        assert line in text, line
    alone = linked(root, {"field": (("f", FIELD),)}, Generated("", NAMES)).text
    assert "fn way(p: vec3f) -> f32 { return locate_0(p).p.x; }" in alone
    assert "several" not in alone


def test_what_only_a_later_layer_has_parameters_for_belongs_to_it(package, monkeypatch):
    monkeypatch.setattr(linking, "has_source", lambda path: path in package)
    package["far.wgsl"] = "import generated::field::params;\nfn far() -> f32 { return params.x; }"
    text = FIELD.text.replace("import generated::field::params;\n", "").replace(" * params.gain", "")
    plain = Source("plain.wgsl", text)
    other = Source("other.wgsl", "import package::far::far;\n" + text.replace("return 1.0", "return far()"))
    package["both.wgsl"] = (
        "import next::both::sum as rest;\nimport slot::field::locate;\n"
        "fn sum(p: vec3f) -> f32 { return locate(p).p.x + rest(p); }"
    )
    package["both_end.wgsl"] = "fn sum(p: vec3f) -> f32 { return 0.0; }"
    names = {("field", 1, "params"): "uniforms.field_1"}
    slots = {"field": (("plain", plain), ("other", other))}
    text = linked("import next::both::sum;\nfn main() -> f32 { return sum(vec3f(1.0)); }", slots, Generated("", names)).text
    assert "fn far_1() -> f32 { return uniforms.field_1.x; }" in text
    assert "fn extent_1(place: Place_1, direction: vec3f) -> f32 { return far_1(); }" in text
