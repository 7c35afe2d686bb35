"""A volume in a marimo notebook: ``marimo edit viewer_marimo.py``.

You should see the viewer with a vortex, and below it a picture of what the viewer shows.
"""

import marimo

app = marimo.App()


@app.cell
def _():
    import marimo as mo

    import airlight as al

    volume = al.samples.load("vortex", size=64)
    view = al.view(volume)
    mo.ui.anywidget(view)
    return al, view


@app.cell
def _(al, view):
    al.render(view.scene, size=(256, 256))
    return


if __name__ == "__main__":
    app.run()
