"""The same scenes in VTK, headless: volume, camera, function, light.

VTK composites whatever numbers it is given, so it gets linear colours, and what it draws is linear. Its opacity belongs to a
unit of length: ``1 - exp(-extinction * unit)``. What cannot be matched: pictures of 8 bits (an error of up to 0.5/255, RMSE
0.3/255), rays that end at an opacity of 254/255 (GPU mapper), classification of single samples instead of slabs, no
gradient threshold, and a specular term of its own.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..scene import Layer, Scene
from ..stages.camera import Orthographic
from ..stages.integrate import FirstHit
from ..stages.shade import BlinnPhong
from ..transfer import TransferFunction
from ..volume import Volume

POINTS_PER_SEGMENT = 256
MAPPERS = {"VTK GPU mapper": "vtkGPUVolumeRayCastMapper", "VTK CPU mapper": "vtkFixedPointVolumeRayCastMapper"}


def mappers_of(scene: Scene) -> dict[str, str]:
    """VTK's mappers by label that draw a scene: surfaces of equal value are drawn by the one on the GPU alone."""
    if surface_value(scene.layers[0]) is not None:
        return {label: mapper for label, mapper in MAPPERS.items() if "GPU" in mapper}
    return MAPPERS


def surface_value(layer: Layer) -> float | None:
    """Value of the surface that a layer is drawn as; None where it is a volume."""
    integrate = layer.look.integrate
    return integrate.iso if isinstance(integrate, FirstHit) else None


def load_vtk() -> Any:
    """Import VTK's rendering, without a display where there is none.

    Raises
    ------
    ImportError
        Where VTK is not installed.
    """
    if not os.environ.get("DISPLAY") and os.name == "posix":
        os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    import vtk

    return vtk


@dataclass(frozen=True, eq=False)
class VtkPicture:
    """A scene in VTK, ready to be drawn at any step."""

    window: Any
    renderer: Any
    mapper: Any
    volume: Any
    spacing: float

    def draw(self, step: float) -> np.ndarray[Any, Any]:
        """Draw with a distance of samples in voxels; linear colours (h, w, 3) over black."""
        from vtkmodules.util.numpy_support import vtk_to_numpy
        from vtkmodules.vtkRenderingCore import vtkWindowToImageFilter

        self.mapper.SetSampleDistance(step * self.spacing)
        self.volume.Modified()
        self.window.Render()
        read = vtkWindowToImageFilter()
        read.SetInput(self.window)
        read.ReadFrontBufferOff()
        read.ShouldRerenderOff()
        read.Update()
        width, height = self.window.GetSize()
        pixels = vtk_to_numpy(read.GetOutput().GetPointData().GetScalars())
        return np.asarray(pixels.reshape(height, width, 3)[::-1].astype(np.float64) / 255)

    def close(self) -> None:
        """Release the window."""
        self.window.Finalize()


def vtk_picture(scene: Scene, size: tuple[int, int], mapper: str) -> VtkPicture:
    """Build a scene of one layer with a plain spacing and at most one directional light."""
    vtk = load_vtk()
    layer, camera = scene.layers[0], scene.camera
    ray_caster = getattr(vtk, mapper)()
    ray_caster.SetInputData(image_data(vtk, layer.volume))
    ray_caster.SetAutoAdjustSampleDistances(False)
    ray_caster.SetLockSampleDistanceToInputSpacing(False)
    ray_caster.SetImageSampleDistance(1.0)
    is_surface = surface_value(layer) is not None
    (ray_caster.SetBlendModeToIsoSurface if is_surface else ray_caster.SetBlendModeToComposite)()
    volume = vtk.vtkVolume()
    volume.SetMapper(ray_caster)
    volume.SetProperty(volume_property(vtk, layer))
    renderer = vtk.vtkRenderer()
    renderer.SetBackground(0, 0, 0)
    renderer.AddVolume(volume)
    aim(vtk, renderer, camera)
    light(vtk, renderer, scene, camera)
    window = vtk.vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetMultiSamples(0)
    window.SetSize(*size)
    window.AddRenderer(renderer)
    return VtkPicture(window, renderer, ray_caster, volume, min(layer.volume.spacing))


def image_data(vtk: Any, volume: Volume) -> Any:
    """Samples on a grid with spacing and origin."""
    from vtkmodules.util.numpy_support import numpy_to_vtk

    data = vtk.vtkImageData()
    data.SetDimensions(*volume.size)
    data.SetSpacing(*volume.spacing)
    data.SetOrigin(*volume.origin)
    data.GetPointData().SetScalars(numpy_to_vtk(np.ascontiguousarray(volume.array).ravel(), deep=True))
    return data


def volume_property(vtk: Any, layer: Layer) -> Any:
    """Function with opacities of one voxel's length, and shading; or an opaque surface in its colour."""
    function, iso = layer.transfer, surface_value(layer)
    assert isinstance(function, TransferFunction)
    unit = min(layer.volume.spacing)
    # Extinction is linear between control points, opacity is not: give it many points.
    dense = [np.linspace(a, b, POINTS_PER_SEGMENT, endpoint=False) for a, b in zip(function.values, function.values[1:])]  # noqa: B905
    values = np.concatenate([*dense, function.values[-1:]])
    rgb, extinction = function(values)
    colour, opacity = vtk.vtkColorTransferFunction(), vtk.vtkPiecewiseFunction()
    colour.SetColorSpaceToRGB()
    for value, (r, g, b), e in zip(values, rgb, extinction, strict=True):
        colour.AddRGBPoint(value, r, g, b)
        opacity.AddPoint(value, 1.0 if iso is not None else 1 - np.exp(-e * unit))
    made = vtk.vtkVolumeProperty()
    if iso is not None:
        made.GetIsoSurfaceValues().SetValue(0, iso)
    made.SetColor(colour)
    made.SetScalarOpacity(opacity)
    made.SetScalarOpacityUnitDistance(unit)
    made.SetInterpolationTypeToLinear()
    shade = layer.look.shade
    made.SetShade(isinstance(shade, BlinnPhong))
    if isinstance(shade, BlinnPhong):
        made.SetAmbient(shade.ambient)
        made.SetDiffuse(shade.diffuse)
        made.SetSpecular(shade.specular)
        made.SetSpecularPower(shade.shininess)
    return made


def aim(vtk: Any, renderer: Any, camera: Any) -> None:
    """Give the renderer the camera."""
    made = renderer.GetActiveCamera()
    made.SetPosition(*camera.eye)
    made.SetFocalPoint(*camera.target)
    made.SetViewUp(*camera.up)
    if isinstance(camera, Orthographic):
        made.ParallelProjectionOn()
        made.SetParallelScale(camera.height / 2)
    else:
        made.SetViewAngle(camera.fov_deg)
    renderer.ResetCameraClippingRange()


def light(vtk: Any, renderer: Any, scene: Scene, camera: Any) -> None:
    """Give the renderer the scene's directional light."""
    renderer.AutomaticLightCreationOff()
    renderer.TwoSidedLightingOn()
    for lamp in scene.lights:
        made = vtk.vtkLight()
        made.SetLightTypeToHeadlight()
        made.SetIntensity(lamp.intensity)
        made.SetColor(*lamp.colour)
        renderer.AddLight(made)
