"""What ``airlight render`` does, in VTK: read an NRRD file, draw bone with light, write a PNG. Called by ``cold_start.py``."""

from __future__ import annotations

import os
import sys

if not os.environ.get("DISPLAY") and os.name == "posix":
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import vtkmodules.vtkInteractionStyle
import vtkmodules.vtkRenderingVolumeOpenGL2  # noqa: F401 - these register what draws
from vtkmodules.vtkCommonDataModel import vtkPiecewiseFunction
from vtkmodules.vtkIOImage import vtkNrrdReader, vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkColorTransferFunction,
    vtkRenderer,
    vtkRenderWindow,
    vtkVolume,
    vtkVolumeProperty,
    vtkWindowToImageFilter,
)
from vtkmodules.vtkRenderingVolume import vtkGPUVolumeRayCastMapper

OPACITIES = {-450: 0.0, -150: 0.1, 130: 0.1, 420: 0.6, 1400: 0.85}
COLOURS = {-450: (0.8, 0.5, 0.4), 130: (0.8, 0.5, 0.4), 420: (0.95, 0.85, 0.7), 1400: (1, 1, 1)}


def main(source: str, target: str, size: str) -> None:
    """Read, draw, write."""
    reader = vtkNrrdReader()
    reader.SetFileName(source)
    mapper = vtkGPUVolumeRayCastMapper()
    mapper.SetInputConnection(reader.GetOutputPort())
    opacity, colour = vtkPiecewiseFunction(), vtkColorTransferFunction()
    for value, alpha in OPACITIES.items():
        opacity.AddPoint(value, alpha)
    for value, rgb in COLOURS.items():
        colour.AddRGBPoint(value, *rgb)
    look = vtkVolumeProperty()
    look.SetColor(colour)
    look.SetScalarOpacity(opacity)
    look.SetInterpolationTypeToLinear()
    look.ShadeOn()
    volume = vtkVolume()
    volume.SetMapper(mapper)
    volume.SetProperty(look)
    renderer = vtkRenderer()
    renderer.AddVolume(volume)
    window = vtkRenderWindow()
    window.SetOffScreenRendering(True)
    window.SetSize(*(int(n) for n in size.split("x")))
    window.AddRenderer(renderer)
    camera = renderer.GetActiveCamera()
    camera.SetFocalPoint(0, 0, 0)
    camera.SetPosition(0.55, -0.75, 0.35)
    camera.SetViewUp(0, 0, 1)
    renderer.ResetCamera()
    window.Render()
    picture = vtkWindowToImageFilter()
    picture.SetInput(window)
    picture.ReadFrontBufferOff()
    writer = vtkPNGWriter()
    writer.SetFileName(target)
    writer.SetInputConnection(picture.GetOutputPort())
    writer.Write()


if __name__ == "__main__":
    main(*sys.argv[1:])
