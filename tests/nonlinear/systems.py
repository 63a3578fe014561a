"""An independent contact law and small systems, written without the package's kernels."""

from dataclasses import replace

import numpy as np
import scipy.linalg as la

from vanelock.nonlinear import (
    SLIP,
    SLIP_OPEN,
    Contact,
    Contacts,
    Diameter,
    Force,
    System,
    frequency_response,
)


def march(contacts, q, count):
    """Forces (n, t1, t2) of all contacts by the three states of the element, after one period.

    q holds one-sided coefficients (H + 1, ..., c, 3) of (v, u1, u2), several motions at once; the
    result is (count, ..., c, 3).
    """
    angle = 2 * np.pi * np.arange(count) / count
    wave = np.exp(1j * np.outer(angle, np.arange(len(q))))
    u = np.einsum("th,h...->t...", wave, q).real
    kt, mu = contacts.kt, contacts.mu[:, None]
    n = np.maximum(contacts.kn * u[..., 0], 0.0)[..., None]
    slip = mu * n
    moved = kt * np.diff(u[..., 1:], axis=0, prepend=u[-1:, ..., 1:])
    open_ = n == 0
    forces = np.concatenate([n, np.zeros_like(u[..., 1:])], axis=-1)
    t = np.clip(kt * u[0, ..., 1:], -slip[0], slip[0])
    for i in range(1, 2 * count):
        s = i % count
        t = np.where(open_[s], 0.0, np.clip(t + moved[s], -slip[s], slip[s]))
        forces[s, ..., 1:] = t
    return forces


def coefficients(history, harmonics):
    """One-sided coefficients (H + 1, ...) of sampled histories (s, ...)."""
    q = np.fft.rfft(history, axis=0)[: harmonics + 1] / len(history)
    q[1:] *= 2
    return q


def loop_area(u, f):
    """Work of a sampled loop: ∮ f du of both tangential directions."""
    return float(np.sum(f[:, 1:] * (np.roll(u, -1, axis=0) - np.roll(u, 1, axis=0))[:, 1:]) / 2)


def random_system(
    seed,
    *,
    size=20,
    contacts=6,
    mu=0.3,
    preload=1.0,
    amplitude=1.0,
    damping_ratio=0.005,
    sectors=5,
    engine_order=1,
    harmonics=5,
):
    """Hermitian matrices by nodal diameter, contacts within the sector and to the next one."""
    rng = np.random.default_rng(seed)
    own = rng.normal(size=(contacts, 3, size)).astype(complex)
    beyond = rng.normal(size=(contacts, 3, size)) * (rng.random((contacts, 1, 1)) < 0.5) + 0j
    base, coupling = rng.normal(size=(size, size)), 0.2 * rng.normal(size=(size, size))
    diameters = {}
    for k in sorted({(h * engine_order) % sectors for h in range(harmonics + 1)}):
        factor = base + coupling * np.exp(-2j * np.pi * k / sectors)
        K = factor.conj().T @ factor + 0.3 * np.eye(size)
        diameters[k] = Diameter(
            K=K.real if k == 0 else K,
            M=np.diag(np.linspace(0.5, 2, size)),
            own=own,
            next=beyond if sectors > 1 else None,
            output=np.eye(size, dtype=complex)[None, :3],
        )
    push = rng.normal(size=size) + 1j * rng.normal(size=size)
    return System(
        sectors=sectors,
        engine_order=engine_order,
        diameters=diameters,
        contacts=Contacts(
            kn=rng.uniform(0.5, 2, contacts),
            kt=rng.uniform(0.5, 2, (contacts, 2)),
            mu=np.full(contacts, mu),
            v0=preload * rng.uniform(0.3, 1, contacts),
        ),
        force={1: Force(amplitude * push)},
        output_names=("tip",),
        damping_ratio=damping_ratio,
    )


def first_frequency(system):
    """Lowest natural frequency of the first harmonic without contacts, Hz."""
    matrices = system.at(system.nodal_diameter(1))
    return float(np.sqrt(la.eigvalsh(matrices.K, matrices.M)[0]) / (2 * np.pi))


def sliding_system(*, sectors=8, amplitude=1.0, preload=1.0, mu=0.3):
    """Two coordinates a sector and a contact to the next, which slips at the lowest, near 0.18 Hz.

    Its harmonics fall quickly.
    """
    own = np.zeros((1, 3, 2))
    own[0, :, 1], own[0, 1, 0], own[0, 1, 1] = (1, 0, 0.3), 1, 0
    diameters = {}
    for k in range(sectors // 2 + 1):
        beside = 1 - np.cos(2 * np.pi * k / sectors)
        diameters[k] = Diameter(
            K=np.array([[1 + 0.3 * beside, 0.2], [0.2, 3 + 0.4 * beside]]),
            M=np.diag([1.0, 0.8]),
            own=own,
            next=-0.5 * own,
            output=np.array([[[1.0, 0.0], [0.0, 1.0], [0.0, 0.0]]]),
        )
    return System(
        sectors=sectors,
        engine_order=1,
        diameters=diameters,
        contacts=Contacts([0.5], [[0.5, 0.5]], [mu], [preload]),
        force={1: Force([0.03 * amplitude, 0.01 * amplitude])},
        output_names=("tip",),
        damping_ratio=0.01,
    )


GAP_DAMPING, GAP_FORCE = 0.02, 0.15


def gap_oscillator(**changed):
    """A unit mass on a unit spring, with a unit gap to another one: its curve folds twice."""
    stop = Contact(normal=0, kn=1.0, gap=1.0)
    asked = {"C": [[GAP_DAMPING]], "force": {0: GAP_FORCE}, "outputs": {"mass": 0}, **changed}
    return System.from_matrices([[1.0]], [[1.0]], [stop], **asked)


def planar(swing, mu, v0, shake, damping_ratio=None):
    """A mass on unequal springs slides on the ground in a plane; another one shakes the load."""
    K, M = np.diag([1.0, 1.3, 2.0]), np.diag([1.0, 1.0, 0.5])
    own = np.array([[[0, 0, 1], [1, 0, 0], [0, 1, 0]]])
    C = 0.06 * K if damping_ratio is None else None
    return System(
        sectors=1,
        engine_order=0,
        diameters={0: Diameter(K=K, M=M, C=C, own=own)},
        contacts=Contacts([0.9], [[0.8, 0.8]], [mu], [v0]),
        force={1: Force([0.7, swing, shake])},
        damping_ratio=damping_ratio,
    )


PLANE_PATHS = (
    (0.7j, 2.0, 0.0, SLIP),  # nearly a circle under constant load
    (0.5 + 0.2j, 2.0, 1.2, SLIP),  # an ellipse, the normal load varies
    (0.5j, 0.8, 2.0, SLIP_OPEN),
)
"""`swing`, `v0` and `shake` of `planar`, and the state that its contact then has."""


def with_contacts(system, **changed):
    """The system with other values of its contacts."""
    return replace(system, contacts=replace(system.contacts, **changed))


def even(system):
    """With the first tangential stiffness in both directions."""
    return with_contacts(system, kt=system.contacts.kt[:, [0, 0]])


def with_rest(system, push=0.3):
    """Under a static load on every coordinate, too."""
    static = Force(np.full(len(system.at(0).K), push))
    return replace(system, force={**system.force, 0: static})


def rows(system, k):
    """(3c, n) relative displacements of all contacts."""
    return system.contact_rows(k).reshape(-1, len(system.at(k).K))


def stuck_stiffness(system, k):
    """K with the springs of all contacts."""
    B = rows(system, k)
    return system.at(k).K + (B.conj().T * system.contacts.stiffness.reshape(-1)) @ B


def proportional(K, M, ratio):
    """C = Σ 2ζω (M v)(M v)ᴴ over the modes of K and M."""
    values, V = la.eigh(K, M)
    MV = M @ V
    return (MV * (2 * ratio * np.sqrt(values))) @ MV.conj().T


def stuck_damping(system, k):
    """C of the modes with all contacts stuck, by its definition."""
    return proportional(stuck_stiffness(system, k), system.at(k).M, system.damping_ratio or 0.0)


def in_time(system, hertz, periods, steps, friction="orthogonal", slider=(0.0, 0.0)):
    """Coordinates (s, n) and slider (s, 2) in the last period by central differences, one contact.

    The friction element is a spring with a slider that moves on where it is pulled with more than
    μ n, in each direction by itself or in the plane.
    """
    one, contacts = system.diameters[0], system.contacts
    M, C, K, own = one.M.real, one.C.real, one.K.real, one.own[0].real
    kn, kt, mu, v0 = contacts.kn[0], contacts.kt[0], contacts.mu[0], contacts.v0[0]
    dt = 1 / hertz / steps
    left = la.inv(M / dt**2 + C / (2 * dt))
    ahead, back = left @ (2 * M / dt**2 - K), left @ (M / dt**2 - C / (2 * dt))
    turn = np.exp(2j * np.pi * np.arange(steps) / steps)
    push = (system.force[1].vector * turn[:, None]).real
    push = (push + (system.force[0].vector.real if 0 in system.force else 0.0)) @ left.T
    held = left @ own.T
    x, before, w = np.zeros(len(K)), np.zeros(len(K)), np.array(slider)
    path, sliders = np.empty((steps, len(K))), np.empty((steps, 2))
    for i in range(periods * steps):
        v, *u = own @ x
        n = kn * max(v + v0, 0.0)
        away, reach = u - w, mu * n / kt
        if friction == "orthogonal":
            w = u - np.clip(away, -reach, reach)
        elif (size := np.hypot(*away)) > reach[0]:
            w = u - reach[0] / size * away
        path[i % steps], sliders[i % steps] = x, w
        pull = held @ np.array([n, *(kt * (u - w))])
        x, before = ahead @ x - back @ before + push[i % steps] - pull, x
    return path, sliders


def jenkins_element(U, kt, limit):
    """First harmonic's complex stiffness, and work of a cycle, of a spring whose slider slips.

    Masing's loop: `turn` is the angle from a reversal to slip.
    """
    turn = np.arccos(1 - 2 * limit / (kt * U))
    work = 4 * limit * (U - limit / kt)
    return kt / np.pi * (turn - 0.5 * np.sin(2 * turn)) + 1j * work / (np.pi * U**2), work


def drawn_contacts(harmonics, count, seed, plane=False):
    """Contacts of every kind and their motion: closed, opening and open, μ from none to large.

    In the `plane` both tangential directions are as stiff.
    """
    rng = np.random.default_rng(seed)
    kt = rng.uniform(0.5, 2, (count, 2))
    contacts = Contacts(
        kn=rng.uniform(0.5, 2, count),
        kt=kt[:, [0, 0]] if plane else kt,
        mu=rng.choice([0.0, 0.1, 0.3, 1.0, 3.0], count),
        v0=np.zeros(count),
    )
    falling = np.repeat(np.arange(harmonics + 1), 2)[1:].clip(1)
    u = rng.normal(size=(count, 3, 2 * harmonics + 1)) / falling
    u[:, 0, 0] += rng.uniform(-1, 3, count)
    return contacts, u


def alike_contacts(kn=1.0, kt=1.0, mu=1.0, count=1):
    """So many contacts alike, assembled without interference."""
    return Contacts(
        np.full(count, kn), np.full((count, 2), kt), np.full(count, mu), np.zeros(count)
    )


def solved_response(system, hertz, *options, **named):
    """Response at frequencies of which each has its solution; jumps are not looked for."""
    response = frequency_response(system, hertz, *options, **named, find_jumps=False)
    assert response.converged.all()
    return response
