r"""
4. The Jacobian of reconnection
===============================

ReSTIR GI reuses *points*. A pixel's ray leaves its visible point :math:`x_q` and meets
a surface at :math:`x_s`; another pixel, whose visible point is :math:`x_r`, looks at
the same :math:`x_s`. But what was drawn was a *direction*, and a patch of surface does
not fill the same solid angle for both:

.. math:: \mathrm{d}\omega = \frac{|\cos\varphi|}{d^2}\, \mathrm{d}A
   \quad\Longrightarrow\quad
   \left|\frac{\partial\omega_r}{\partial\omega_q}\right|
   = \frac{|\cos\varphi_r|}{|\cos\varphi_q|} \cdot \frac{d_q^2}{d_r^2} .

This is Equation 11 of the paper, and the whole kernel:

.. literalinclude:: /../reference/resampling/shift.py
   :pyobject: reconnection_jacobian
"""

import matplotlib.pyplot as plt
import numpy as np

from restir_gi.figures.jacobian import jacobian
from restir_gi.reference.numerics.schedule import Schedule
from restir_gi.reference.reports.figures.record import Work
from restir_gi.reference.resampling.shift import reconnection_jacobian

# %%
# Is it the ratio of the solid angles? Take a small triangle on a wall and measure the
# angle that it fills for either point, by the formula of the spherical triangle.


def solid_angle(eye, corners):
    """Solid angle of a triangle, seen from a point."""
    a, b, c = (v / np.linalg.norm(v) for v in corners - eye)
    above = abs(np.dot(a, np.cross(b, c)))
    return 2 * np.arctan2(above, 1 + a @ b + b @ c + c @ a)


x_q, x_r = np.array([0.2, 0.0, 1.0]), np.array([1.3, 0.4, 0.5])
x_s, normal = np.zeros(3), np.array([0.0, 0.0, 1.0])
J = reconnection_jacobian(x_q[None], x_r[None], x_s[None], normal[None])[0]
for size in (0.3, 0.03, 0.003):
    corners = size * np.array([[1.0, 0, 0], [-0.5, 0.9, 0], [-0.5, -0.9, 0]])
    ratio = solid_angle(x_r, corners) / solid_angle(x_q, corners)
    print(f"patch of {size:5.3f} m: ratio {ratio:.6f}, Jacobian {J:.6f}")
assert abs(ratio / J - 1) < 1e-4  # the next term of the expansion goes as size²

# %%
# How large it gets: a wall at the left, a pixel that made the sample one metre away,
# and a pixel that reuses it anywhere on the floor. Close to the wall the patch fills
# hundreds of times the angle, or, edge-on, hardly any.

x, height = np.meshgrid(np.linspace(0.02, 2, 240), np.linspace(-0.6, 0.6, 150))
eyes = np.stack([x, height, np.zeros_like(x)], axis=-1).reshape(-1, 3)
source = np.tile([1.0, 0.0, 0.0], (len(eyes), 1))
wall = np.tile([1.0, 0.0, 0.0], (len(eyes), 1))
J = reconnection_jacobian(source, eyes, np.zeros_like(eyes), wall)
shown = plt.pcolormesh(x, height, np.log2(J.reshape(x.shape)), cmap="RdBu_r",
                       vmin=-6, vmax=6)  # fmt: skip
plt.colorbar(shown, label="log2 of the Jacobian")
plt.plot(0, 0, "k^", label="sample point on the wall")
plt.plot(1, 0, "ko", label="who made it")
plt.xlabel("distance to the wall, m")
plt.ylabel("along the wall, m")
plt.legend()
plt.show()

# %%
# What happens without it
# -----------------------
#
# A sunlit wall lights the floor before it: Figure 7 of the paper, and here with the
# light of the floor in closed form. Left out, the floor before the wall is too dark;
# divided by instead of multiplied with, as the paper's Algorithm 4 prints it, too
# bright.

figure = jacobian(Work(size=48, runs=3, schedule=Schedule()))
plt.figure().figimage(figure.pixels(), resize=True)
plt.show()

# %%
# .. admonition:: Exercise
#
#    The oldest bug of them all. (``python docs/lessons/exercises/exercise_4.py``)
#
# .. literalinclude:: /lessons/exercises/exercise_4.py
#    :pyobject: jacobian
