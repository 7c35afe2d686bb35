"""Render a real volume with a look of one's own and save it: the picture at the top of the README.

You should see a fly from the side: flight muscles and eyes shaded in amber, wings and legs as a thin blue veil.
The volume is fetched by pip the first time (10 MB, micro-CT, MIT licence) and kept in a cache.

Usage: python fly.py [OUTPUT] [WIDTH HEIGHT]
"""

import sys

import airlight as al

VOLUME = "fly"
FUNCTION = al.TransferFunction(
    [  # value, colour (sRGB, since it is a word), extinction per voxel: this file has no unit of length
        (12, "#102a50", 0.0),
        (22, "#2a5a90", 0.008),
        (45, "#4a80a8", 0.025),
        (66, "#c86828", 0.05),
        (92, "#dc8a38", 0.3),
        (130, "#f8c878", 0.9),
        (220, "#fff2d8", 2.0),
    ]
)
CAMERA = al.Camera.perspective(eye=(352, -235, -86), target=(131, 112, 80), up=(0, 0, -1), fov_deg=25)
LIGHTS = [
    al.Light.directional(to_light=(-0.5, -0.6, -0.9), color=(1, 0.95, 0.85), intensity=1.1),
    al.Light.directional(to_light=(1, 0.3, 0.4), color=(0.45, 0.6, 1), intensity=0.6),
]
LOOK = al.Look(gradient="sobel", shade=al.shade.BlinnPhong(ambient=0.2, diffuse=0.75, specular=0.3, shininess=30))


def main(output: str = "fly.png", width: int = 800, height: int = 600) -> al.Image:
    volume = al.samples.load(VOLUME)
    scene = al.Scene(volume, transfer=FUNCTION, camera=CAMERA, look=LOOK, lights=LIGHTS, background="black")
    image = al.render(scene, size=(width, height), step=0.5)
    image.save(output)
    return image


if __name__ == "__main__":
    print(main(*sys.argv[1:2], *map(int, sys.argv[2:4])))
