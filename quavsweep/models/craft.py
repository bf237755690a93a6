"""The quadrotor's parameters: Table 2 of the paper, with units that its equations need.

The printed units of b, d and k1 to k6 do not fit equations (4), (11) and (12): thrust is b Omega^2 and drag torque
d Omega^2, so b is in N s2/rad2 and d in N m s2/rad2; k1 to k3 multiply a velocity, k4 to k6 an angular velocity.
"""

from __future__ import annotations

from quavsweep.models.quantity import Parameter


def _positive(name: str, default: float, unit: str, symbol: str, meaning: str) -> Parameter:
    return Parameter(name, default, unit, symbol, meaning, low=0.0, open_low=True)


TABLE_2 = {
    parameter.name: parameter
    for parameter in (
        _positive("g", 9.81, "m/s2", "g", "acceleration of gravity"),
        _positive("m", 0.468, "kg", "m", "mass"),
        _positive("l", 0.225, "m", "l", "distance from the centre to a rotor's axis"),
        _positive("b", 2.9e-5, "N s2/rad2", "b", "lift coefficient"),
        _positive("d", 1.1e-6, "N m s2/rad2", "d", "drag coefficient of a rotor"),
        _positive("Ir", 3.4e-5, "kg m2", "I_r", "moment of inertia of the rotors"),
        _positive("Ix", 4.9e-3, "kg m2", "I_x", "moment of inertia about the x axis"),
        _positive("Iy", 9.8e-3, "kg m2", "I_y", "moment of inertia about the y axis"),
        _positive("Iz", 8.8e-3, "kg m2", "I_z", "moment of inertia about the z axis"),
        _positive("k1", 2.45e-4, "N s/m", "k_1", "translational drag along x"),
        _positive("k2", 8.82e-4, "N s/m", "k_2", "translational drag along y"),
        _positive("k3", 4.40e-4, "N s/m", "k_3", "translational drag along z"),
        _positive("k4", 2.45e-4, "N m s/rad", "k_4", "rotational drag about x"),
        _positive("k5", 8.82e-4, "N m s/rad", "k_5", "rotational drag about y"),
        _positive("k6", 4.40e-4, "N m s/rad", "k_6", "rotational drag about z"),
    )
}
