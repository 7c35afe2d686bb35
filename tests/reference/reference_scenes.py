"""Scenes with known answers: what the tests of the reference share."""

import numpy as np

from airlight.reference import prepare
from airlight.reference.setup import Sample
from airlight.scene import Camera, Look, Scene
from airlight.transfer import TransferFunction
from airlight.volume import Volume

WHITE = (1.0, 1.0, 1.0)
ONE = (1, 1)


def along_z(x=0.0, y=0.0, z=-10.0, height=1e-3):
    """Orthographic camera whose one ray goes up the z axis through (x, y), from the plane at z."""
    return Camera.orthographic(eye=(x, y, z), target=(x, y, z + 1), up=(0, 1, 0), height=height)


def ramp_z(n, first=0.0, last=1.0, aside=3, **geometry):
    """Values that run linearly from first to last over the n voxels along z."""
    return Volume(np.broadcast_to(np.linspace(first, last, n)[:, None, None], (n, aside, aside)), **geometry)


def scene(volume, function, camera=None, lights=None, **look):
    look = {"field": "linear_exact", "shade": "none"} | look
    return Scene(volume, transfer=function, look=Look(**look), camera=camera or along_z(1.0, 1.0), lights=lights)


def setup_of(volume, function=None, lights=None, **look):
    look = {"field": "linear_exact", "shade": "blinn_phong"} | look
    return prepare(Scene(volume, transfer=function or constant(1.0), look=Look(**look), lights=lights))


def constant(extinction, rgb=WHITE, associated=False):
    return TransferFunction([(0, rgb, extinction)], associated=associated)


def ends(values):
    """Samples with these values, for the transfer stages."""
    value = np.atleast_1d(np.asarray(values, dtype=np.float64))
    n = len(value)
    return Sample(value, np.zeros(n, bool), np.zeros((n, 3)), np.zeros((n, 3)), np.zeros(n))


def rotation(axis, angle_rad):
    k = np.asarray(axis) / np.linalg.norm(axis)
    cross = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    return np.eye(3) + np.sin(angle_rad) * cross + (1 - np.cos(angle_rad)) * cross @ cross


def blob(n=17, sigma=0.35):
    """A smooth bump in a cube of world size 2 about the origin."""
    g = np.linspace(-1, 1, n)
    z, y, x = np.meshgrid(g, g, g, indexing="ij")
    array = np.exp(-((x - 0.1) ** 2 + (y + 0.2) ** 2 + z**2) / (2 * sigma**2))
    return Volume(array, spacing=(2 / (n - 1),) * 3, origin=(-1, -1, -1))
