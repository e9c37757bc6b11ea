"""Posterior samples of fitted parameters."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from ._common import choice, counter, number, refused, whole
from ._errors import Extra, InputError
from ._fit import Fit

if TYPE_CHECKING:
    from numpy.typing import NDArray

    Array: TypeAlias = NDArray[np.float64]
    Tell: TypeAlias = Callable[[int], None] | None


class Posterior:
    """Posterior samples of the parameters, given the recordings.

    Attributes
    ----------
    samples : ndarray of shape (S, P)
        Sampled values as `Instrument.vary` takes them; columns in the order of `names`.
    names : list of str
    acceptance : float
        Share of accepted proposals; 0.2 to 0.5 is good.
    """

    def __init__(self, names: list[str], samples: Array, acceptance: float) -> None:
        self.names, self.samples, self.acceptance = names, samples, acceptance

    @property
    def mean(self) -> dict[str, float]:
        """Means of the samples."""
        return dict(zip(self.names, map(float, self.samples.mean(axis=0)), strict=True))

    @property
    def std(self) -> dict[str, float]:
        """Standard deviations of the samples."""
        return dict(zip(self.names, map(float, self.samples.std(axis=0)), strict=True))

    def interval(self, share: float = 0.95) -> dict[str, tuple[float, float]]:
        """Returns the central interval of every parameter that contains a share of the samples.

        Parameters
        ----------
        share : float
            Share of the samples, 0 to 1.

        Returns
        -------
        dict of str to (float, float)
        """
        share = number("share", share)
        if not 0.0 <= share <= 1.0:
            raise InputError(f"share: found {share}, expected a number from 0 to 1", key="share", found=str(share))
        low, high = np.quantile(self.samples, [(1 - share) / 2, (1 + share) / 2], axis=0)
        return {name: (float(a), float(b)) for name, a, b in zip(self.names, low, high, strict=True)}

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Posterior) and self.names == other.names and np.array_equal(self.samples, other.samples)

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        told = ", ".join(f"{name} {self.mean[name]:.4g} +- {self.std[name]:.1g}" for name in self.names)
        return f"<erard.Posterior of {len(self.samples)} samples, acceptance {self.acceptance:.2f}: {told}>"


def sample(
    found: Fit,
    *,
    sampler: str = "emcee",
    walkers: int | None = None,
    length: int = 200,
    burn: int = 100,
    seed: int = 0,
    progress: bool | None = None,
) -> Posterior:
    """Samples the posterior of a fit, with the fit's Gaussian noise and a uniform prior within its bounds (of factors:
    their logarithms).

    Noise of what drives and misfit beyond all noise widen it as they widen the errors of the fit: the likelihood is that of the sensors' noise, its
    curvature at the best point adjusted (Chandler and Bate, Biometrika 94, 2007).

    Parameters
    ----------
    found : Fit
    sampler : {"emcee", "nuts"}
        "emcee" needs no derivatives; its walkers are played side by side in lanes. "nuts" is Hamiltonian sampling by
        nutpie (`pip install erard[nuts]`) with the model's own derivatives. Each of its steps takes about ten presses
        with derivatives, one after the other, so it is faster only for many correlated parameters.
    walkers : int, optional
        For "emcee", number of walkers, at least twice the number of parameters (default 32); half of them are played
        side by side. For "nuts", number of chains, one after the other (default 2).
    length, burn : int
        Number of steps of each walker to keep, and to discard before them.
    seed : int
    progress : bool, optional
        Whether to count the strokes that are played.

    Returns
    -------
    Posterior
    """
    if not isinstance(found, Fit):
        raise refused("found", found, "what erard.fit found")
    choice("sampler", sampler, ("emcee", "nuts"))
    seed = whole("seed", seed, 0)
    if walkers is None:
        walkers = 32 if sampler == "emcee" else 2
    walkers, length, burn = whole("walkers", walkers), whole("length", length), whole("burn", burn, 0)
    if np.isnan(found._inner_cov).any():
        raise InputError("found: a fit without errors, because its recordings are too short for the correlation of their noise", key="found")
    problem = found._problem
    low, high = problem.bounds()
    count = len(low)
    if sampler == "emcee" and walkers < 2 * count:
        raise InputError(f"walkers: found {walkers}, expected {2 * count} or more", key="walkers", found=str(walkers))

    # Nearer to the best point by so much as the sensors' errors are smaller than all of them.
    sizes = np.sqrt(np.diag(found._sensors_cov))
    sensors, everything = (np.linalg.cholesky(cov / np.outer(sizes, sizes)) for cov in (found._sensors_cov, found._inner_cov))
    nearer = sizes[:, None] * (sensors @ np.linalg.inv(everything)) / sizes

    rng = np.random.default_rng(seed)
    spread = np.sqrt(np.clip(np.diag(found._inner_cov), 0.0, ((high - low) / 6) ** 2))
    first = np.clip(found._point + spread * rng.standard_normal((walkers, count)), low + 1e-9, high - 1e-9)
    with counter(progress, "sample", "strokes") as tell:
        draw = _by_emcee if sampler == "emcee" else _by_nuts
        chain, acceptance = draw(found, first, nearer, low, high, length, burn, seed, tell)
    return Posterior(list(found.x), problem.outer(chain), acceptance)


def _by_emcee(
    found: Fit, first: Array, nearer: Array, low: Array, high: Array, length: int, burn: int, seed: int, tell: Tell
) -> tuple[Array, float]:
    with Extra("bayes"):
        import emcee

    problem = found._problem

    def log_probability(points: Array) -> Array:
        inside = np.all((points > low) & (points < high), axis=1)
        found_log = np.full(len(points), -np.inf)
        if not np.any(inside):
            return found_log
        kept = found._point + (points[inside] - found._point) @ nearer.T
        chi2 = np.sum(problem.residuals(kept, tell) ** 2, axis=1)
        found_log[inside] = np.where(np.isfinite(chi2), -0.5 * chi2, -np.inf)
        return found_log

    walkers, count = first.shape
    sampler = emcee.EnsembleSampler(walkers, count, log_probability, vectorize=True)
    sampler.random_state = np.random.RandomState(seed).get_state()
    sampler.run_mcmc(first, burn + length)
    return sampler.get_chain(discard=burn, flat=True), float(np.mean(sampler.acceptance_fraction))


def _by_nuts(
    found: Fit, first: Array, nearer: Array, low: Array, high: Array, length: int, burn: int, seed: int, tell: Tell
) -> tuple[Array, float]:
    """Samples with the no-U-turn sampler, over logits of the parameters' positions between their bounds."""
    with Extra("nuts"):
        import nutpie
        from nutpie.compiled_pyfunc import from_pyfunc

    problem, width = found._problem, high - low
    chains, count = first.shape

    def place(z: Array) -> Array:
        return low + width / (1.0 + np.exp(-z))

    def make_logp() -> Callable[[Array], tuple[float, Array]]:
        def logp(z: Array) -> tuple[float, Array]:
            share = np.clip(1.0 / (1.0 + np.exp(-z)), 1e-12, 1.0 - 1e-12)
            slope = width * share * (1.0 - share)
            kept = found._point + nearer @ (place(z) - found._point)
            kept = np.clip(kept, low + 1e-9 * width, high - 1e-9 * width)
            left = problem.residuals(kept[None], tell)[0]
            if not np.all(np.isfinite(left)):
                return -np.inf, np.zeros_like(z)
            by_place = -(left @ problem.jacobian(kept, exact=True)) @ nearer
            return -0.5 * float(left @ left) + float(np.sum(np.log(slope))), by_place * slope + 1.0 - 2.0 * share

        return logp

    def make_expand(*_: Any) -> Callable[[Array], dict[str, Array]]:
        return lambda z: {"inner": place(z)}

    starts = iter(np.log((first - low) / (high - first)))
    model = from_pyfunc(
        count, make_logp, make_expand, [np.dtype(np.float64)], [(count,)], ["inner"],
        make_initial_point_fn=lambda _: next(starts, np.log((found._point - low) / (high - found._point))),
    )  # fmt: skip
    trace = nutpie.sample(model, draws=length, tune=burn, chains=chains, cores=1, seed=seed, save_warmup=False, progress_bar=False)
    chain: Array = np.asarray(trace.posterior["inner"]).reshape(-1, count)
    return chain, float(np.mean(np.asarray(trace.sample_stats["mean_tree_accept"])))
