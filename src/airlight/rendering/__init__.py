"""From a scene to an image: one module a driver, and ``frame`` which tells it from start to end."""
