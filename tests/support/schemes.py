"""Steps and starts of drops for those who take the steps themselves."""

from dataclasses import replace

import numpy as np

from mechstyle.fea.elasticity import law_named
from mechstyle.fea.explicit import RECORD_EVERY, Scheme, Starts, damped_step

NORMALS = np.array([[0.0, 0.0, 1.0], [0.6, 0.0, 0.8], [-0.48, 0.64, 0.6]])


def scheme_of(discretisation, pla, name="stable_neo_hookean", samples=8, **changes):
    law = law_named(name, pla)
    step = 0.85 * damped_step(discretisation, 0.1)[0]
    damping = 2e-5 * np.random.default_rng(3).uniform(0.2, 1.0, len(discretisation.volumes))
    scheme = Scheme(law, step, damping=damping, gravity=9.81e-3, friction=0.3, speed=5.4, stride=RECORD_EVERY, samples=samples)
    return replace(scheme, **changes)


def starts_of(discretisation, normals=NORMALS, speed=5.4):
    return Starts.falling(discretisation.positions, normals, speed)
