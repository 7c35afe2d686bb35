"""Eight pictures round a volume with one renderer, which keeps the device, the uploaded volume and the compiled program.

You should see eight files, turn-0.png to turn-7.png: tubes of a flow that cross, turned by 45 degrees from each to
the next. The first frame takes longest.

Usage: python turntable.py [FOLDER] [WIDTH HEIGHT]
"""

import math
import sys
import time
from dataclasses import replace
from pathlib import Path

import airlight as al

FRAMES = 8


def main(folder: str = ".", width: int = 480, height: int = 360) -> list[al.Image]:
    scene = al.first_picture(al.samples.load("vortex"), (width, height))
    x, y, z = scene.camera.target
    distance = math.dist(scene.camera.eye, scene.camera.target)
    images = []
    with al.Renderer() as renderer:
        for frame in range(FRAMES):
            angle_rad = 2 * math.pi * frame / FRAMES
            eye = (x + distance * math.sin(angle_rad), y - distance * math.cos(angle_rad), z + 0.25 * distance)
            started = time.perf_counter()
            image = renderer.render(replace(scene, camera=replace(scene.camera, eye=eye)), (width, height))
            image.save(Path(folder) / f"turn-{frame}.png")
            print(f"frame {frame}: {1e3 * (time.perf_counter() - started):.0f} ms")
            images.append(image)
    return images


if __name__ == "__main__":
    main(*sys.argv[1:2], *map(int, sys.argv[2:4]))
