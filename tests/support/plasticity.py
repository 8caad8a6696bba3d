"""J2 plasticity in the multiplicative setting in readable float64 numpy: the reference that the fast kernels are tested against."""

from dataclasses import dataclass, field, replace

import numpy as np
from scipy.optimize import brentq

from mechstyle.fea.elasticity import ElasticLaw


@dataclass(frozen=True)
class Point:
    """A material point: its law, the inverse of C_p, and the plastic strain, all of it and what was gathered in tension."""

    law: ElasticLaw
    strength: float
    hardening: float
    inverse: np.ndarray = field(default_factory=lambda: np.eye(3))
    strain: float = 0.0
    tension: float = 0.0

    def at(self, F):
        """The point after it was brought to a deformation gradient, and its Kirchhoff stress there [MPa]."""
        b, J = F @ self.inverse @ F.T, np.linalg.det(F)
        trial = self.kirchhoff(b, J)
        excess = von_mises(trial) - self.strength - self.hardening * self.strain
        if excess <= 0.0:
            return self, trial
        slope = self.stiffness(b) * np.trace(b)  # by which the equivalent stress falls with the flow
        s = (1.0 - slope / (slope + self.hardening) * excess / von_mises(trial)) * deviator(b)
        after = s + brentq(lambda m: np.linalg.det(m * np.eye(3) + s) - J**2, 0.2, 5.0, xtol=1e-15) * np.eye(3)  # flow keeps volume
        flow, stress, back = 0.5 * (logarithm(b) - logarithm(after)), self.kirchhoff(after, J), np.linalg.inv(F)
        more = np.sum(flow * deviator(stress)) / von_mises(stress)  # its work is that of the stress in the flow
        tension = more if np.trace(stress) > -von_mises(stress) else 0.0
        return replace(self, inverse=back @ after @ back.T, strain=self.strain + more, tension=self.tension + tension), stress

    def stiffness(self, b):
        """The factor μ' between the deviators of b and of the stress [MPa]."""
        return self.law.mu * (1.0 - 1.0 / (1.0 + np.trace(b)))

    def kirchhoff(self, b, J):
        """Kirchhoff stress [MPa]."""
        alpha = 1.0 + 0.75 * self.law.mu / self.law.la
        return self.stiffness(b) * b + self.law.la * (J - alpha) * J * np.eye(3)


def deviator(b):
    return b - np.trace(b) / 3.0 * np.eye(3)


def von_mises(stress):
    return np.sqrt(1.5 * np.sum(deviator(stress) ** 2))


def logarithm(b):
    """Of a symmetric positive matrix."""
    values, axes = np.linalg.eigh(b)
    return (axes * np.log(values)) @ axes.T
