"""Options that several commands share; cyclopts makes them of these dataclasses.

Annotations are values here and in the commands, not text: cyclopts would have to compile each.
"""

from dataclasses import dataclass
from typing import Annotated, Literal

from cyclopts import Group, Parameter

from ..scene import VIEWS
from ..transfer import presets
from .parse import choices

LOOK = Group("Look", sort_key=1)
VIEW = Group("View", sort_key=2)
DRAW = Group("Drawing", sort_key=3)
READ = Group("Reading", sort_key=4)
NOTES = Group("Annotations", sort_key=2)
SERVE = Group("Page", sort_key=5)

SLOTS = ("field", "gradient", "transfer", "modulation", "shade", "lighting", "visibility", "integrate", "tone")


def _stage(slot: str, what: str, example: str = "") -> Parameter:
    return Parameter(group=LOOK, help=f"{what}: {choices(slot)}." + (f" E.g. {example}" if example else ""), metavar="STAGE")


@Parameter(name="*")
@dataclass(frozen=True)
class LookOptions:
    """Transfer function and stages; stages take parameters as in ``blinn_phong:ambient=0.2`` (see ``airlight stages``)."""

    preset: Annotated[
        str | None, Parameter(group=LOOK, metavar="NAME", help=f"A transfer function made ready: {', '.join(presets.names())}.")
    ] = None
    colormap: Annotated[
        str | None,
        Parameter(
            group=LOOK,
            metavar="NAME",
            help="A colour map over the robust range of the data, faint where values are low (see airlight presets "
            "--colormaps). E.g. viridis, magma_r, cmocean:ice.",
        ),
    ] = None
    tf: Annotated[
        str | None,
        Parameter(
            group=LOOK,
            metavar="FUNCTION",
            allow_leading_hyphen=True,
            help="Transfer function: a .toml file, as the functions' save writes it (of one value or of several variables), a "
            ".json file, or points "
            'VALUE:COLOUR:EXTINCTION (extinction per world unit), e.g. "0:black:0 300:#ffaa88:0.02 1200:white:0.5".',
        ),
    ] = None
    auto: Annotated[
        Literal["boundaries", "boundaries2d"] | None,
        Parameter(
            group=LOOK,
            help="Transfer function made of the data that shows the boundaries between materials, each in a colour of its own: "
            "by value, or by value and gradient, which tells boundaries apart that share values.",
        ),
    ] = None
    iso: Annotated[
        tuple[str, ...],
        Parameter(
            group=LOOK,
            metavar="SURFACE",
            negative="",
            consume_multiple=False,
            allow_leading_hyphen=True,
            help="Surface of equal value: VALUE, VALUE:COLOUR or VALUE:COLOUR:OPACITY (opaque unless told), then "
            "BACK-COLOUR:BACK-OPACITY if the side of higher values is another. Repeatable. Alone, or beside the function of "
            "--tf, --preset, --colormap or a scene file.",
        ),
    ] = ()
    field: Annotated[str | None, _stage("field", "Reconstruction")] = None
    gradient: Annotated[str | None, _stage("gradient", "Gradients", "precomputed:method=sobel")] = None
    transfer: Annotated[str | None, _stage("transfer", "Classification")] = None
    modulation: Annotated[str | None, _stage("modulation", "Factor of extinction", "change:full_at=50")] = None
    shade: Annotated[str | None, _stage("shade", "Shading", "blinn_phong:ambient=0.2,shininess=40")] = None
    environment: Annotated[
        str | None,
        Parameter(
            group=LOOK,
            metavar="NAME_OR_FILE",
            help="Light from all directions: studio, sky, white, with parameters as in sky:turbidity=5,to_sun=[1,-1,1], or an "
            "equirectangular .hdr, .exr or .npy picture. Sets --shade environment unless another stage is given.",
        ),
    ] = None
    environment_turn: Annotated[
        float | None,
        Parameter(
            group=LOOK,
            metavar="DEGREES",
            allow_leading_hyphen=True,
            help="Turn of the environment about the vertical, counterclockwise from above.",
        ),
    ] = None
    light: Annotated[
        tuple[str, ...],
        Parameter(
            group=LOOK,
            metavar="LIGHT",
            negative="",
            consume_multiple=False,
            help="Light of the scene: head, directional, point or spot, with parameters: head:intensity=0.5, "
            "directional:to_light=[0,-1,1],color=white,intensity=0.8, point:position=[0,-300,100],radius=200 (in the world; "
            "without a radius there is no fall-off), spot:position=[0,-300,100],target=[0,0,0],angle_deg=20,image=window.npy "
            "(for --driver half_angle). Repeatable; one head light unless told.",
        ),
    ] = ()
    mesh: Annotated[
        tuple[str, ...],
        Parameter(
            group=LOOK,
            metavar="FILE",
            negative="",
            consume_multiple=False,
            help="Mesh that shares its depth with the volume: STL, OBJ, PLY or GLB, with options as in "
            "skull.stl:color=ivory,opacity=0.4,smooth=false. Repeatable.",
        ),
    ] = ()
    layer: Annotated[
        tuple[str, ...],
        Parameter(
            group=LOOK,
            metavar="FILE",
            negative="",
            consume_multiple=False,
            help="Another volume in the scene, in its own place, with the look of the first: tf, preset or colormap, density, "
            "channel and time as in pet.nii.gz:colormap=inferno,density=0.5. Repeatable.",
        ),
    ] = ()
    scale_bar: Annotated[
        bool, Parameter(group=NOTES, negative="", help="A bar of a round length; under perspective as long as at the target.")
    ] = False
    color_bar: Annotated[
        bool, Parameter(group=NOTES, negative="", help="Colours and opacities of the transfer function by value.")
    ] = False
    grid: Annotated[
        bool, Parameter(group=NOTES, negative="", help="Lines at round numbers of the world behind all, with the numbers.")
    ] = False
    axes: Annotated[bool, Parameter(group=NOTES, negative="", help="Arrows along the axes of the world.")] = False
    orientation: Annotated[
        bool, Parameter(group=NOTES, negative="", help="Letters of anatomical directions (L R A P S I) at the borders.")
    ] = False
    pointer: Annotated[
        tuple[str, ...],
        Parameter(
            group=NOTES,
            metavar="X,Y,Z",
            negative="",
            consume_multiple=False,
            allow_leading_hyphen=True,
            help="A cross at a point of the world, with options as in 10,20,30:shape=arrow,size_voxels=8,color=red,label=here. "
            "Repeatable.",
        ),
    ] = ()
    box: Annotated[str | None, Parameter(group=LOOK, metavar="COLOUR", help="Edges of the volume's box, in this colour.")] = (
        None
    )
    lighting: Annotated[str | None, _stage("lighting", "Where a slab is lit")] = None
    visibility: Annotated[str | None, _stage("visibility", "Shadows")] = None
    integrate: Annotated[str | None, _stage("integrate", "What is gathered along a ray", "first_hit:iso=300")] = None
    tone: Annotated[str | None, _stage("tone", "Tone mapping", "reinhard:key=0.18,exposure=1")] = None
    channel: Annotated[str | None, Parameter(group=LOOK, help="Channel, by number (from 0) or name.")] = None
    channels: Annotated[
        str | None,
        Parameter(
            group=LOOK,
            metavar="CHANNELS",
            help="Several channels in one picture, each in a colour: all, or CHANNEL or CHANNEL=COLOUR with commas between, "
            "e.g. 0=green,1=magenta.",
        ),
    ] = None
    time: Annotated[int | None, Parameter(group=LOOK, help="Time step, from 0.")] = None


@Parameter(name="*")
@dataclass(frozen=True)
class ViewOptions:
    """Camera, background and size of the image."""

    size: Annotated[
        str | None, Parameter(group=VIEW, metavar="WxH", help="Width and height in pixels; 512x512 unless told.")
    ] = None
    camera: Annotated[
        str | None,
        Parameter(
            group=VIEW,
            metavar="VIEW",
            allow_leading_hyphen=True,
            help=f'{", ".join(VIEWS)}, or "ex,ey,ez,tx,ty,tz": eye and target in the world; three more numbers give up. Or a '
            f"kind with its parameters ({choices('camera')}), e.g. panorama:eye=[10,20,30],target=[10,50,30] or "
            "dome:eye=[10,20,30],target=[10,50,30],angle_deg=220.",
        ),
    ] = None
    clip: Annotated[
        tuple[str, ...],
        Parameter(
            group=VIEW,
            metavar="CLIP",
            negative="",
            consume_multiple=False,
            help="Part of the world that is drawn: plane:normal=[0,1,0] (what lies where the normal points to; through the "
            "middle of the volume, or point=[x,y,z]), box:low=[x,y,z],high=[x,y,z], sphere:center=[x,y,z],radius=R or "
            "mesh:file=FILE (closed), with keep=outside to draw the rest, capped=true for solid faces, and cuts=front or back "
            "to cut only what is in front of it or behind. Repeatable: what all of them keep is drawn.",
        ),
    ] = ()
    crop: Annotated[
        str | None,
        Parameter(
            group=VIEW,
            metavar="X0:X1,Y0:Y1,Z0:Z1",
            help="Voxels that are drawn, from the first to the one before the last, e.g. 10:90,:,20: (see airlight info).",
        ),
    ] = None
    orthographic: Annotated[bool, Parameter(group=VIEW, negative="", help="Parallel rays.")] = False
    stereo: Annotated[
        bool,
        Parameter(
            group=VIEW,
            negative="",
            help="The views of the left and of the right eye side by side. Their distance: --camera stereo:eye=[...],"
            "target=[...],interocular=65.",
        ),
    ] = False
    background: Annotated[
        str | None,
        Parameter(
            group=VIEW,
            metavar="COLOUR",
            help="CSS name, #rrggbb, linear r,g,b, none for transparent, or environment to see the one that lights the scene.",
        ),
    ] = None


@Parameter(name="*")
@dataclass(frozen=True)
class DrawOptions:
    """How the picture is computed."""

    driver: Annotated[
        str | None,
        Parameter(group=DRAW, metavar="STAGE", help=f"What walks through the volume: {choices('driver')}; march unless told."),
    ] = None
    step: Annotated[
        float | None, Parameter(group=DRAW, help="Length of a step in voxels (the smallest spacing); 1 unless told.")
    ] = None
    tolerance: Annotated[
        float | None,
        Parameter(
            group=DRAW,
            metavar="ERROR",
            help="Greatest error of any pixel and channel, e.g. 0.004 (1/255): steps get smaller where it is needed.",
        ),
    ] = None
    budget: Annotated[
        float | None,
        Parameter(
            group=DRAW,
            metavar="MS",
            help="Milliseconds that the frame may take: chooses the step, and a smaller size if need be.",
        ),
    ] = None
    skip: Annotated[
        Literal["auto", "none", "blocks", "geometry"] | None,
        Parameter(group=DRAW, help="Skipping of empty space; never changes the image."),
    ] = None
    offsets: Annotated[
        Literal["none", "interleaved", "blue_noise"] | None,
        Parameter(
            group=DRAW, help="Offsets of the samples from pixel to pixel, by the driver march: fewer rings, a little noise."
        ),
    ] = None
    passes: Annotated[
        tuple[str, ...],
        Parameter(
            name="--pass",
            group=DRAW,
            metavar="STAGE",
            negative="",
            consume_multiple=False,
            help=f"What is made of the finished picture: {choices('passes')}, with parameters as in "
            "bounding_box:width_px=2; or one of a plugin. Repeatable.",
        ),
    ] = ()
    transport: Annotated[
        str | None,
        Parameter(
            group=DRAW,
            metavar="STAGE",
            help=f"What becomes of lights on their way through the volume, by the driver half_angle, which is chosen with it: "
            f"{choices('transport')}. E.g. translucent:angle_deg=60.",
        ),
    ] = None
    device: Annotated[
        str | None, Parameter(group=DRAW, metavar="NAME", help="Adapter, by a part of its name or kind (see airlight devices).")
    ] = None
    plugin: Annotated[
        tuple[str, ...],
        Parameter(
            group=DRAW,
            metavar="FILE_OR_MODULE",
            negative="",
            consume_multiple=False,
            help="Python code that registers stages (al.register); repeatable.",
        ),
    ] = ()


@Parameter(name="*")
@dataclass(frozen=True)
class ReadOptions:
    """What a reader cannot know, and its limits."""

    dataset: Annotated[str, Parameter(group=READ, help="Array within the file (HDF5, NetCDF, npz, DICOM series ...).")] = ""
    level: Annotated[int, Parameter(group=READ, help="Level of a pyramid; 0 is the finest.")] = 0
    shape: Annotated[str | None, Parameter(group=READ, metavar="XxYxZ", help="Voxels of a raw file.")] = None
    dtype: Annotated[str, Parameter(group=READ, help="Type of a raw file's samples, e.g. uint8, int16, float32.")] = ""
    spacing: Annotated[
        str | None,
        Parameter(group=READ, metavar="X,Y,Z", help="World size of a voxel, for raw files and others that do not say."),
    ] = None
    offset: Annotated[int, Parameter(group=READ, help="Bytes before the samples of a raw file.")] = 0
    big_endian: Annotated[
        bool, Parameter(group=READ, negative="", help="Samples of a raw file have their high byte first.")
    ] = False
    max_memory: Annotated[
        str, Parameter(group=READ, metavar="SIZE", help="Most that a file may unpack to, e.g. 500M; 8G unless told.")
    ] = "8G"


@Parameter(name="*")
@dataclass(frozen=True)
class ServeOptions:
    """Where the page is served, and what it may bring."""

    host: Annotated[
        str,
        Parameter(group=SERVE, metavar="ADDRESS", help="Where it listens; 127.0.0.1, for this machine alone, unless told."),
    ] = "127.0.0.1"
    port: Annotated[int, Parameter(group=SERVE, help="Port; a free one unless told.")] = 0
    browser: Annotated[bool, Parameter(group=SERVE, negative="--no-browser", help="Open the page in the browser.")] = True
    public_url: Annotated[
        str,
        Parameter(
            group=SERVE,
            metavar="URL",
            help="Address under which a proxy, e.g. of a notebook hub, shows the page: https://hub.example.org/user/me/proxy/8000/",
        ),
    ] = ""
    max_upload: Annotated[
        str, Parameter(group=SERVE, metavar="SIZE", help="Most that a page may bring to be opened, e.g. 500M; 4G unless told.")
    ] = "4G"
