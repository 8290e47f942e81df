"""The filter of the preset `default`: particles are poses, weighed by learnt appearance.

Every frame, particles are drawn from a mixture: about those of the frame before, about peaks of the
map of log-ratios, and where a target may come into view. Their weight is the density of the
predicted belief over that of the whole mixture, times the likelihood of their region.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from cable_tracker.arrays import BoolArray, FloatArray
from cable_tracker.contour.evolution import ContourSettings
from cable_tracker.errors import FrameError
from cable_tracker.particle_filter.estimates import weighted_covariance, weighted_mean
from cable_tracker.particle_filter.existence import (
    PredictedExistence,
    predict_existence,
    update_existence,
)
from cable_tracker.particle_filter.kernel_mixture import kernel_mixture
from cable_tracker.particle_filter.particles import Particles
from cable_tracker.particle_filter.resampling import systematic_resampling
from cable_tracker.particle_filter.weights import effective_sample_size, log_sum_exp
from cable_tracker.target.finding import Finding
from cable_tracker.target.measure.appearance import Appearance, learn_histograms
from cable_tracker.target.measure.clutter import UsualScore, clutter_of, log_ratio_of_likeness
from cable_tracker.target.measure.features import BinMap, bins_of, choose_bins, looked_up
from cable_tracker.target.measure.first_look import look_first, near
from cable_tracker.target.measure.outline import Outline, find_outline
from cable_tracker.target.measure.places import find_places
from cable_tracker.target.measure.region import HueModel, score_poses
from cable_tracker.target.measure.working_frame import WorkingFrame
from cable_tracker.target.model.births import Births
from cable_tracker.target.model.camera_motion import CameraMotion
from cable_tracker.target.model.forecast import Forecast, Proposal, choose_columns, log_mix
from cable_tracker.target.model.own_place import OwnPlace
from cable_tracker.target.model.state import PLACES, POSE_SIZE, PoseColumn, wrap_angle
from cable_tracker.target.model.template import Template, distances_about, make_template
from cable_tracker.target.parameters.parameters import TargetParameters
from cable_tracker.tracking.parameter_table import REFERENCE_RATE, REFERENCE_WIDTH
from cable_tracker.tracking.survival import SurvivalRates, survival_probability

LEAST_PRESENCE, MOST_PRESENCE = 1e-3, 1.0 - 1e-3
"""The probability of presence stays between, so that it can turn again in time."""

PLACE_SPREAD = (0.25, 0.15, 0.12)
"""Of the kernels about peaks: position in roots of the area, log scale, angle [rad]."""

REFINED_SPREAD = (0.06, 0.05, 0.06)
"""The same about the best particles of the frame."""

REFINED = 5
"""So many are the best."""

DRAWN_TAIL = 4.0
"""Degrees of freedom of those kernels."""

SCALES_LOOKED_FOR = (-0.3, 0.0, 0.3)
"""Log scales against the last one at which peaks are looked for."""

CLUSTER = 1.0
"""Particles within this many roots of the area of the best one make the estimate."""

GOOD_OVERLAP = 0.6
"""With the expected shape, of a contour that may teach."""

CLEAR_OF_TARGET = 1.5
"""Random places this far from the target count as clutter, in roots of its area."""

FIRST_LIKENESS, FIRST_GREY_LIKENESS = UsualScore(0.8, 0.01), UsualScore(0.95, 0.0025)
"""Of a target to itself, before any frame has shown it: in colour, and in grey."""

WHOLE_SIZE = 0.2
"""Log scales this far from the usual one still belong to a target that nothing hides."""

WHOLE_HASTE = 3.0
"""The usual size follows so much faster while the whole contour is seen, in its usual shape."""

RIVAL_SCORE = 0.75
"""Another peak whose region scores at least this share of the target's usual score is like it."""

OWN_REACH = 0.8
"""The target is seen at its own place this near to where it is expected, in roots of the area."""

RIVAL_NEAR, RIVAL_FAR, RIVAL_TOUCHES = 1.2, 2.6, 1.9
"""At such distances from the target it may soon cover it, or just has; one that is last seen nearer
than the third has merged with it: in roots of the area."""

RIVAL_FRAMES = 5
"""Both must be seen in so many frames in a row: a target that jumps is beside itself for one."""

RIVAL_TIME = 1.2
"""For so long after one was there, and is not any more, both are taken for one [s]."""

HELD_GAIN = 0.15
"""Of the usual gain of the rates while a rival is near."""

MERGED_SHARPNESS = 0.01
"""Of the usual weight of the score while two are one: it is best in the middle of both."""

MERGED_JUMPS = 0.1
"""Of the usual share of jumps while two are one: each of them goes on as it went."""

SIZE_TAIL = 4.0
"""Degrees of freedom of the log scale about its running mean."""

RESHAPED_EVERY = 3
"""The remembered shape follows every so many lessons, so much faster each time."""

SCORE_RATE = 0.05
"""Share per frame with which the usual score follows."""


@dataclass(frozen=True, slots=True, eq=False)
class _Known:
    """What is known of the target besides where it is. Never changed in place."""

    template: Template
    appearance: Appearance
    usual: UsualScore
    usual_likeness: UsualScore
    usual_log_scale: float
    births: Births
    first_size: float
    lessons: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class _Look:
    """A frame through the eyes of the learnt appearance."""

    frame: WorkingFrame
    bins: BinMap
    ratios: NDArray[np.float32]
    hues: HueModel


@dataclass(frozen=True, slots=True, eq=False)
class _Shown:
    """What the contour of a frame shows: histograms, and how like the target's they are."""

    target: FloatArray
    around: FloatArray
    likeness: float


@dataclass(frozen=True, slots=True, eq=False)
class _Drawn:
    """Particles before they are weighed; the belief holds what is known of sizes."""

    states: FloatArray
    log_prior: FloatArray
    log_proposal: FloatArray
    scores: FloatArray
    own_scores: FloatArray
    predicted: PredictedExistence


class Weighed(NamedTuple):
    """Poses with what is needed to weigh them; every array has one row for each."""

    states: FloatArray
    log_prior: FloatArray
    log_birth: FloatArray
    kernel_values: FloatArray
    scores: FloatArray


class PoseFilter:
    """See the module.

    Parameters
    ----------
    parameters : TargetParameters
        All of them.
    rng : numpy.random.Generator
        The only source of randomness.
    """

    def __init__(self, parameters: TargetParameters, rng: np.random.Generator) -> None:
        self._parameters = parameters
        self._rng = rng
        self._particles: Particles | None = None
        self._known: _Known | None = None
        self._presence = 0.0
        self._estimate = np.zeros(POSE_SIZE)
        self._since_rival = math.inf
        self._rival_frames = 0

    @property
    def particles(self) -> Particles | None:
        """The present belief, in pixels of the working image; None before the first target."""
        return self._particles

    def configure(self, parameters: TargetParameters) -> None:
        """Take other parameters from now on, and keep the belief."""
        self._parameters = parameters

    def use(self, rng: np.random.Generator) -> None:
        """Draw from another generator."""
        self._rng = rng

    def start(self, frame: WorkingFrame, mask: BoolArray, *, is_exact: bool) -> Finding:
        """Learn a target from its pixels in a frame.

        Raises
        ------
        FrameError
            The mask is too small, or does not stand out from its surroundings.
        """
        p = self._parameters
        look = look_first(
            frame, mask, is_exact=is_exact, points=p.template_points, limit=p.ratio_limit,
            settings=self._contours(),
        )  # fmt: skip
        if look.score < p.least_separation:
            raise FrameError(
                "the marked target does not stand out from its surroundings (score"
                f" {look.score:.2f}, needs {p.least_separation:.2f}); mark it where it does"
            )
        self._known = _Known(
            look.template,
            look.appearance,
            self._usual(look.score),
            FIRST_LIKENESS if frame.is_coloured else FIRST_GREY_LIKENESS,
            0.0,
            Births(look.state, 0.0, p.memory_time, frame.shape),
            look.template.size,
        )
        spread = 0.05 * look.template.size
        noise = self._rng.standard_normal((p.particle_count, POSE_SIZE))
        scales = np.array([spread, spread, 0.02, 0.02, 10.0 * spread, 10.0 * spread])
        self._particles = Particles.equally_weighted(look.state + noise * scales)
        self._presence = MOST_PRESENCE
        self._estimate = look.state
        seen = self._look(frame, self._known)
        score = float(self._scores(seen, look.state[None])[0])
        self._known = replace(self._known, usual=self._usual(score))
        weights = np.full(p.particle_count, 1.0 / p.particle_count)
        return self._conclude(seen, weights, score, float(p.particle_count))

    def advance(
        self,
        frame: WorkingFrame,
        dt: float,
        motion: CameraMotion | None,
        others: FloatArray,
    ) -> Finding:
        """Follow the target into the next frame; see `TargetEngine`."""
        assert self._known is not None
        self._age(frame, dt, motion)
        known = self._known
        look = self._look(frame, known)
        drawn = self._draw(look, dt)
        scores = drawn.scores
        self._judge_presence(look, drawn, scores)
        log_weights = drawn.log_prior - drawn.log_proposal
        log_weights += self._sharpness() * drawn.own_scores
        log_weights -= self._crowding(drawn.states, others)
        total = log_sum_exp(log_weights)
        self._particles = Particles(drawn.states, log_weights - total)
        chosen = self._cluster(self._particles)
        self._estimate = weighted_mean(drawn.states, chosen)
        score = float(self._scores(look, self._estimate[None])[0])
        n_eff = effective_sample_size(self._particles.log_weights)
        finding = self._conclude(look, chosen, score, n_eff)
        self._follow_size(dt, is_whole=finding.is_whole)
        return finding

    def _log_size_factor(self, states: FloatArray) -> FloatArray:
        """Return how likely the scales are beside the usual one, against that one, shape (N,)."""
        assert self._known is not None
        # The longer it has not been seen, the less its size is known.
        spread = self._parameters.size_spread * (1.0 + self._known.births.seconds)
        gaps = (states[:, PoseColumn.LOG_SCALE] - self._known.usual_log_scale) / spread
        factors: FloatArray = -0.5 * (SIZE_TAIL + 1.0) * np.log1p(gaps**2 / SIZE_TAIL)
        return factors

    def _follow_size(self, dt: float, *, is_whole: bool) -> None:
        """Let the usual size follow while the target is surely in view."""
        assert self._known is not None
        if self._presence < self._parameters.presence_to_track:
            return
        haste = WHOLE_HASTE if is_whole else 1.0
        share = 1.0 - math.exp(-dt * haste / self._parameters.size_time)
        gap = float(self._estimate[PoseColumn.LOG_SCALE]) - self._known.usual_log_scale
        self._known = replace(
            self._known, usual_log_scale=self._known.usual_log_scale + share * gap
        )

    def _contours(self) -> ContourSettings:
        p = self._parameters
        return ContourSettings(p.contour_regulariser, -1.0, p.contour_iterations)

    def _age(self, frame: WorkingFrame, dt: float, motion: CameraMotion | None) -> None:
        """Carry what is remembered on to the time of the new frame."""
        assert self._known is not None and self._particles is not None
        known = replace(self._known, births=self._known.births.aged(dt))
        if motion is not None:
            self._particles = self._particles.moved_to(
                motion.moved(self._particles.states, frame.zoom)
            )
            self._estimate = motion.moved(self._estimate[None], frame.zoom)[0]
            last = motion.moved(known.births.last[None], frame.zoom)[0]
            known = replace(known, births=replace(known.births, last=last))
        if frame.is_coloured != _is_coloured(known):
            known = self._relearnt(frame, known)
        self._known = known

    def _relearnt(self, frame: WorkingFrame, known: _Known) -> _Known:
        """Learn the appearance anew where the target is expected: colour came or went."""
        bins = choose_bins(frame.channels, frame.is_coloured)
        bin_map = bins_of(frame.channels, bins.lookups)
        expected = find_outline(
            np.zeros(frame.shape, np.float32), self._estimate, known.template,
            self._parameters.prior_softness, self._contours(),
        )  # fmt: skip
        mask = np.zeros(frame.shape, np.bool_)
        if expected is not None:
            mask = expected.in_picture(frame.shape)
        target, around = learn_histograms(bin_map, mask, near(mask), bins.count)
        appearance = Appearance(bins, target, target, around, self._parameters.ratio_limit)
        relearnt = replace(known, appearance=appearance)
        self._known = relearnt
        score = float(self._scores(self._look(frame, relearnt), self._estimate[None])[0])
        return replace(relearnt, usual=self._usual(score))

    def _usual(self, score: float) -> UsualScore:
        return UsualScore(score, (self._parameters.score_spread * score) ** 2)

    def _look(self, frame: WorkingFrame, known: _Known) -> _Look:
        share = self._parameters.first_look_share
        bins = bins_of(frame.channels, known.appearance.bins.lookups)
        p = self._parameters
        weight = p.hue_weight if frame.is_coloured else p.grey_hue_weight
        hues = HueModel(bins, known.appearance.hue_roots(share), weight)
        return _Look(frame, bins, looked_up(bins, known.appearance.log_ratios(share)), hues)

    def _scores(self, look: _Look, states: FloatArray) -> FloatArray:
        assert self._known is not None
        template = self._known.template
        scores: FloatArray = score_poses(
            look.ratios, states, template.inside, template.around, template.size, look.hues
        )
        return scores

    def _size(self) -> float:
        """Return the root of the area that is expected now [px]."""
        assert self._known is not None
        return self._known.template.size * math.exp(self._estimate[PoseColumn.LOG_SCALE])

    def _draw(self, look: _Look, dt: float) -> _Drawn:
        """Draw the particles of a frame, with the densities of belief and proposal at each."""
        p, rng = self._parameters, self._rng
        peaks, strengths = self._peaks(look)
        self._watch_for_rivals(look, peaks, dt)
        forecast = self._forecast(look, dt)
        refined_count = round(p.refinement_share * p.particle_count)
        search_count = round(p.search_share * p.particle_count)
        place_count = round(p.place_share * p.particle_count) if len(peaks) else 0
        follow_count = p.particle_count - place_count - search_count - refined_count
        if follow_count < 1:  # Of a handful, all follow.
            follow_count, place_count, search_count, refined_count = p.particle_count, 0, 0, 0
        mixture = [Proposal(forecast.kernels, forecast.even, follow_count / p.particle_count)]
        parts = [mixture[0].draw(follow_count, rng)]
        if place_count:
            spread = kernel_mixture(peaks, self._about(PLACE_SPREAD), DRAWN_TAIL, strengths)
            mixture.append(Proposal(spread, strengths, place_count / p.particle_count))
            parts.append(mixture[-1].draw(place_count, rng))
        parts.append(forecast.births.draw(search_count, rng)[:, :PLACES])
        drawn = self._weighed(look, np.concatenate(parts), forecast)
        own = self._own_place(drawn, dt)
        if refined_count:
            best = self._best(drawn, own)
            even = np.full(len(best), 1.0 / len(best))
            spread = kernel_mixture(best, self._about(REFINED_SPREAD), DRAWN_TAIL, even)
            mixture.append(Proposal(spread, even, refined_count / p.particle_count))
            more = self._weighed(look, mixture[-1].draw(refined_count, rng), forecast)
            drawn = Weighed(*(np.concatenate(pair) for pair in zip(drawn, more, strict=True)))
        followed = log_mix(drawn.kernel_values, forecast.even, forecast.kernels)
        proposed = [followed + math.log(mixture[0].share)]
        proposed += [part.log_density(drawn.states[:, :PLACES]) for part in mixture[1:]]
        if search_count:
            proposed.append(math.log(search_count / p.particle_count) + drawn.log_birth)
        self._choose_rates(drawn.states, drawn.kernel_values, forecast, dt)
        return _Drawn(
            drawn.states, drawn.log_prior, np.logaddexp.reduce(proposed), drawn.scores,
            own.own_scores(drawn.states, drawn.scores), forecast.predicted,
        )  # fmt: skip

    def _own_place(self, drawn: Weighed, dt: float) -> OwnPlace:
        """Return where the target is expected, and what that says about other places."""
        assert self._known is not None
        x, y = self._estimate[:2] + self._estimate[PLACES:] * dt
        place = OwnPlace(float(x), float(y), OWN_REACH * self._size())
        if self._presence < self._parameters.presence_to_track:
            return place
        return place.seen(drawn.states, drawn.scores, RIVAL_SCORE * self._known.usual.mean)

    def _weighed(self, look: _Look, places: FloatArray, forecast: Forecast) -> Weighed:
        """Return places as poses at rest, with the densities of the belief and their scores."""
        states = np.zeros((len(places), POSE_SIZE))
        states[:, :PLACES] = places
        reference = self._estimate[PoseColumn.ANGLE]
        states[:, 3] = reference + wrap_angle(states[:, 3] - reference)
        log_prior, log_birth, kernel_values = forecast.log_density(states)
        log_prior = log_prior + self._log_size_factor(states)
        return Weighed(states, log_prior, log_birth, kernel_values, self._scores(look, states))

    def _forecast(self, look: _Look, dt: float) -> Forecast:
        """Return the belief before the frame is looked at."""
        assert self._known is not None and self._particles is not None
        p = self._parameters
        frames = dt * REFERENCE_RATE
        ancestors = self._particles.states[
            systematic_resampling(self._particles.weights, p.ancestor_count, self._rng)
        ]
        damping = 1.0 if self._holds_rates() else p.rate_damping
        rates = ancestors[:, PLACES:] * damping**frames
        centres = ancestors[:, :PLACES].copy()
        centres[:, :2] += rates * dt
        reference = self._estimate[PoseColumn.ANGLE]
        centres[:, 3] = reference + wrap_angle(centres[:, 3] - reference)
        survival = self._survival(centres, look, dt)
        predicted = predict_existence(
            self._presence, float(survival.mean()), 1.0 - math.exp(-p.appearance_rate * dt)
        )
        alive = survival / survival.sum()
        kernels = kernel_mixture(
            centres, self._scales(frames, look), p.diffusion_degrees_of_freedom, alive
        )
        jumps = p.jump_share * (MERGED_JUMPS if self._is_merged() else 1.0)
        return Forecast(kernels, rates, alive, self._known.births, predicted, jumps)

    def _about(self, spread: tuple[float, float, float]) -> FloatArray:
        """Return scales of a kernel: position in roots of the area, log scale, angle, (4,)."""
        size = self._size()
        return np.array([spread[0] * size, spread[0] * size, spread[1], spread[2]])

    def _best(self, drawn: Weighed, own: OwnPlace) -> FloatArray:
        """Return the best of the places that have been drawn, shape (K, 4)."""
        scores = own.own_scores(drawn.states, drawn.scores)
        worth = drawn.log_prior + self._sharpness() * scores
        best: FloatArray = drawn.states[np.argsort(-worth)[:REFINED], :PLACES]
        return best

    def _choose_rates(
        self, states: FloatArray, kernel_values: FloatArray, forecast: Forecast, dt: float
    ) -> None:
        """Give every particle the rates of an ancestor that it may come from, corrected."""
        parents = choose_columns(kernel_values, self._rng.random(len(states)))
        unforeseen = states[:, :2] - forecast.kernels.places[parents, :2]
        # A jump that no movement explains says nothing about the rates.
        limit = 0.5 * self._size()
        reach = np.hypot(unforeseen[:, 0], unforeseen[:, 1])
        gain = self._parameters.rate_gain * np.where(reach > limit, 0.0, 1.0)
        if self._holds_rates():
            gain *= 0.0 if self._is_merged() else HELD_GAIN
        states[:, PLACES:] = forecast.rates[parents] + gain[:, None] * unforeseen / dt

    def _watch_for_rivals(self, look: _Look, peaks: FloatArray, dt: float) -> None:
        """Note when something like the target comes near it, or just has been.

        What cannot be told from it may be told by its way: two that cross keep their rates.
        """
        self._since_rival += dt
        if len(peaks) == 0 or self._known is None:
            return
        apart = np.hypot(*(peaks[:, :2] - self._estimate[:2]).T) / self._size()
        beside = (apart > RIVAL_NEAR) & (apart < RIVAL_FAR)
        # The target itself must be seen at its place: else what is beside it may be itself.
        if not beside.any() or not (apart <= RIVAL_NEAR).any():
            self._rival_frames = 0
            return
        poses = np.zeros((len(peaks), POSE_SIZE))
        poses[:, :PLACES] = peaks
        alike = self._scores(look, poses) >= RIVAL_SCORE * self._known.usual.mean
        if not (alike & beside).any() or not (alike & (apart <= RIVAL_NEAR)).any():
            self._rival_frames = 0
            return
        self._rival_frames += 1
        if self._rival_frames >= RIVAL_FRAMES:
            touches = float(apart[beside & alike].min()) < RIVAL_TOUCHES
            # One that is last seen farther away has not merged with the target.
            self._since_rival = 0.0 if touches else math.inf

    def _holds_rates(self) -> bool:
        return self._since_rival <= RIVAL_TIME

    def _is_merged(self) -> bool:
        """Tell whether target and rival are taken for one."""
        return 0.0 < self._since_rival <= RIVAL_TIME

    def _sharpness(self) -> float:
        return self._parameters.sharpness * (MERGED_SHARPNESS if self._is_merged() else 1.0)

    def _scales(self, frames: float, look: _Look) -> FloatArray:
        """Return the scales of the diffusion's kernel, shape (4,)."""
        p = self._parameters
        zoom = look.frame.shape[1] / REFERENCE_WIDTH
        root = math.sqrt(frames)
        place = math.sqrt(p.position_variance) * zoom * root
        scales: FloatArray = np.maximum(
            [place, place, p.scale_sigma * root, math.radians(p.angle_sigma) * root], 1e-6
        )
        return scales

    def _peaks(self, look: _Look) -> tuple[FloatArray, FloatArray]:
        """Return where to propose, shape (K, 4), and the shares of the proposals, shape (K,)."""
        assert self._known is not None
        if self._parameters.place_count == 0:
            return np.empty((0, PLACES)), np.empty(0)
        template, angle = self._known.template, float(self._estimate[PoseColumn.ANGLE])
        extent = template.extent(angle)
        places = find_places(
            look.ratios,
            (extent[0] * template.size, extent[1] * template.size),
            self._scales_looked_for(),
            self._parameters.place_count,
        )
        if not places:
            return np.empty((0, PLACES)), np.empty(0)
        poses = np.array([[place.x, place.y, place.log_scale, angle] for place in places])
        strengths = np.array([place.strength for place in places])
        return poses, strengths / strengths.sum()

    def _scales_looked_for(self) -> FloatArray:
        """Return the log scales at which peaks are looked for."""
        assert self._known is not None
        expected = self._estimate
        if self._presence < self._parameters.presence_to_lose:
            # The estimate is then on something else, whose size says nothing.
            expected = self._known.births.last
        scales: FloatArray = expected[PoseColumn.LOG_SCALE] + np.array(SCALES_LOOKED_FOR)
        return scales

    def _survival(self, centres: FloatArray, look: _Look, dt: float) -> FloatArray:
        p = self._parameters
        height, width = look.frame.shape
        inside = np.minimum(width / 2 - np.abs(centres[:, 0]), height / 2 - np.abs(centres[:, 1]))
        margin = p.leaving_margin * width / REFERENCE_WIDTH
        rates = SurvivalRates(p.disappearance_rate, p.leaving_rate, margin)
        return survival_probability(inside, rates, dt)

    def _judge_presence(self, look: _Look, drawn: _Drawn, scores: FloatArray) -> None:
        """Update the probability that the target is in view."""
        assert self._known is not None
        p = self._parameters
        clutter = clutter_of(
            self._scores(look, self._random_places(look, drawn, scores)),
            p.clutter_share if look.frame.is_coloured else p.grey_clutter_share,
        )
        ratios = clutter.log_ratios(scores, self._known.usual, p.score_spread)
        ratios = np.clip(ratios, -p.evidence_limit, p.evidence_limit)
        evidence = log_sum_exp(drawn.log_prior - drawn.log_proposal + ratios) - math.log(
            len(scores)
        )
        self._presence = update_existence(drawn.predicted, evidence, LEAST_PRESENCE, MOST_PRESENCE)

    def _random_places(self, look: _Look, drawn: _Drawn, scores: FloatArray) -> FloatArray:
        """Return poses anywhere but at the best particle, of its scale and angle."""
        best = drawn.states[int(np.argmax(scores))]
        height, width = look.frame.shape
        count = self._parameters.clutter_places
        states = np.tile(best, (count, 1))
        states[:, :2] = (self._rng.random((count, 2)) - 0.5) * [width, height]
        apart = np.hypot(states[:, 0] - best[0], states[:, 1] - best[1])
        clear: FloatArray = states[apart > CLEAR_OF_TARGET * self._size()]
        return clear

    def _crowding(self, states: FloatArray, others: FloatArray) -> FloatArray:
        """Return what it costs to be where another target is, shape (N,)."""
        if len(others) == 0:
            return np.zeros(len(states))
        gaps = states[:, None, :2] - others[None, :, :2]
        near_others = np.exp(-0.5 * (gaps**2).sum(axis=2) / (0.4 * self._size()) ** 2)
        cost: FloatArray = self._parameters.sharpness * near_others.sum(axis=1)
        return cost

    def _cluster(self, particles: Particles) -> FloatArray:
        """Return the weights of the particles about the best place, shape (N,), summing to one."""
        weights = particles.weights
        states = particles.states
        best = states[int(np.argmax(weights))]
        apart = np.hypot(states[:, 0] - best[0], states[:, 1] - best[1])
        chosen = np.where(apart <= CLUSTER * self._size(), weights, 0.0)
        shares: FloatArray = chosen / chosen.sum()
        return shares

    def _conclude(self, look: _Look, weights: FloatArray, score: float, n_eff: float) -> Finding:
        """Find the outline, learn from it, and say what was found."""
        assert self._known is not None and self._particles is not None
        p, known = self._parameters, self._known
        softness = p.prior_softness if look.frame.is_coloured else p.grey_prior_softness
        outline = find_outline(
            look.ratios, self._estimate, known.template, softness, self._contours()
        )
        shown = self._shown(look, outline)
        self._judge_likeness(shown, is_coloured=look.frame.is_coloured)
        covariance = weighted_covariance(self._particles.states, weights, self._estimate)
        size = self._size()
        sigma = math.sqrt(max(covariance[0, 0], covariance[1, 1]))
        is_near = sigma <= p.converged_position * size
        is_whole = (
            outline is not None
            and outline.overlap >= GOOD_OVERLAP
            and not outline.touches_border(look.frame.shape)
        )
        is_sure = self._presence >= p.presence_to_track and is_near
        if is_sure:
            births = replace(known.births, last=self._estimate.copy(), seconds=0.0)
            self._known = replace(known, births=births)
            usual = known.usual_log_scale
            of_usual_size = abs(self._estimate[PoseColumn.LOG_SCALE] - usual) < WHOLE_SIZE
            if is_whole and of_usual_size and outline is not None and shown is not None:
                self._learn(look, outline, shown, score)
        return Finding(
            state=self._estimate.copy(),
            covariance=covariance,
            size=known.first_size,
            outline=outline,
            is_whole=is_whole,
            presence=self._presence,
            effective_sample_size=n_eff,
            score=score,
            supports_claim=is_sure,
            supports_keeping=self._presence >= p.presence_to_lose and is_near,
        )

    def _shown(self, look: _Look, outline: Outline | None) -> _Shown | None:
        """Return the histograms that the contour shows; None without a contour."""
        assert self._known is not None
        if outline is None or outline.area == 0:
            return None
        mask = outline.in_picture(look.frame.shape)
        appearance = self._known.appearance
        target, around = learn_histograms(look.bins, mask, near(mask), appearance.bins.count)
        likeness = appearance.likeness(target, self._parameters.first_look_share)
        return _Shown(target, around, likeness)

    def _judge_likeness(self, shown: _Shown | None, *, is_coloured: bool) -> None:
        """Update the probability of presence by the colours within the contour."""
        assert self._known is not None
        if shown is None:
            return
        p, known = self._parameters, self._known
        least = p.likeness_spread if is_coloured else p.grey_likeness_spread
        ratio = log_ratio_of_likeness(shown.likeness, known.usual_likeness, least)
        ratio = min(max(ratio, -p.likeness_limit), p.likeness_limit)
        before = PredictedExistence(self._presence, 0.0)
        self._presence = update_existence(
            before, ratio + math.log(self._presence), LEAST_PRESENCE, MOST_PRESENCE
        )

    def _learn(self, look: _Look, outline: Outline, shown: _Shown, score: float) -> None:
        """Let shape, appearance and usual score follow what the contour shows."""
        assert self._known is not None
        p, known = self._parameters, self._known
        appearance = known.appearance.adapted(
            shown.target, shown.around, p.appearance_rate_of_target, p.appearance_rate_around
        )
        template = known.template
        if p.shape_rate > 0.0 and known.lessons % RESHAPED_EVERY == 0:
            template = self._reshaped(outline)
        self._known = replace(
            known,
            appearance=appearance,
            template=template,
            usual=known.usual.seen(score, SCORE_RATE),
            usual_likeness=known.usual_likeness.seen(shown.likeness, SCORE_RATE),
            lessons=known.lessons + 1,
        )

    def _reshaped(self, outline: Outline) -> Template:
        """Return the template moved towards the contour, both about their centroids."""
        assert self._known is not None
        template, p = self._known.template, self._parameters
        rows, columns = np.nonzero(outline.mask)
        left, top, right, bottom = outline.window
        centre = (
            float(columns.mean()) - (right - left - 1) / 2,
            (bottom - top - 1) / 2 - float(rows.mean()),
        )
        size = math.sqrt(outline.area)
        seen = distances_about(outline.mask, centre, size, self._estimate[PoseColumn.ANGLE])
        share = 1.0 - (1.0 - p.shape_rate) ** RESHAPED_EVERY
        blended = (1.0 - share) * template.distances + share * seen
        return make_template(blended.astype(np.float32), template.size, p.template_points)


def _is_coloured(known: _Known) -> bool:
    return known.appearance.bins.shape[2] > 1
