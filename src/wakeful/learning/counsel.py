"""Whose forecast to believe when a reasoner and the learned model both speak: weights by how well each has forecast."""

from __future__ import annotations

import math
from collections import OrderedDict

import msgspec

from wakeful.facts.asking import Kind, Reply
from wakeful.facts.experience import Verdict
from wakeful.facts.lines import Answered, AnyRecord, Decided, Judged

_REPLY = msgspec.json.Decoder(Reply)
_DIGITS = 9

#: No forecast is held to be less probable than this: one mistake must not silence a voice for ever.
_LEAST = 0.01

#: A loss counts for this share after each further one: about the last thirty forecasts weigh.
_MEMORY = 0.97

#: Forecasts that were never judged are forgotten, the oldest first, above so many.
_KEPT = 10_000


class Counsel:
    """Exponentially weighted pooling of two forecasters by discounted log loss.

    The weights are those of Cesa-Bianchi and Lugosi, *Prediction, Learning, and Games* (2006), Section 2.2, on the losses of
    judged forecasts, discounted so that a voice can regain its weight. State changes only in ``apply``.
    """

    def __init__(self) -> None:
        self._models: OrderedDict[int, dict[str, float]] = OrderedDict()
        self._replies: dict[int, dict[str, float]] = {}
        self._losses = [0.0, 0.0]

    @property
    def weights(self) -> tuple[float, float]:
        """The weight of the model and of the reasoner; they add up to 1."""
        model, reasoner = (-loss for loss in self._losses)
        top = max(model, reasoner)
        shares = math.exp(model - top), math.exp(reasoner - top)
        return round(shares[0] / sum(shares), _DIGITS), round(shares[1] / sum(shares), _DIGITS)

    def pool(self, prior: dict[str, float], learned: bool, reply: Reply, labels: tuple[str, ...]) -> dict[str, float]:
        """The forecast to go on with after deliberation.

        Args:
            prior: the decision's, over ``labels``.
            learned: whether it is a model's; one from guidelines only fills in what the reply leaves open.
            reply: the reasoner's; it may forecast nothing.
            labels: the domain's outcome labels.

        Returns:
            Probabilities over ``labels`` that add up to 1, or ``prior`` where the reply forecasts nothing.
        """
        if reply.forecast not in labels:
            return prior
        said = _spread(reply, {} if learned else prior, labels)
        if not learned or not prior:
            return said
        model, reasoner = self.weights
        return {name: round(model * prior.get(name, 0.0) + reasoner * said[name], _DIGITS) for name in labels}

    def judged(self, process: int) -> bool:
        """Whether a verdict on that process would teach anything: nobody but the model forecast an automatic one."""
        return process in self._models

    def apply(self, record: AnyRecord) -> None:
        """Take up one record; all but decisions, reasoners' answers and verdicts are passed over."""
        if isinstance(record, Decided):
            if record.decision.model and record.process not in self._models:
                self._models[record.process] = record.decision.prior
                if len(self._models) > _KEPT:
                    self._replies.pop(self._models.popitem(last=False)[0], None)
        elif isinstance(record, Answered):
            if record.kind is Kind.DELIBERATE and not record.error and record.process in self._models:
                reply = _REPLY.decode(record.value)
                self._replies[record.process] = _spread(reply, {}, tuple(self._models[record.process]))
        elif isinstance(record, Judged):
            model = self._models.pop(record.process, None)
            said = self._replies.pop(record.process, None)
            if model is not None and said is not None and record.verdict is not Verdict.UNDECIDED:
                for place, forecast in enumerate((model, said)):
                    loss = -math.log(max(_LEAST, forecast.get(record.label, 0.0)))
                    self._losses[place] = _MEMORY * self._losses[place] + loss


def _spread(reply: Reply, prior: dict[str, float], labels: tuple[str, ...]) -> dict[str, float]:
    """The reply's one probability as a distribution: the rest in proportion to ``prior``, evenly without one."""
    if reply.forecast not in labels:
        return {name: 1.0 / len(labels) for name in labels}
    others = [name for name in labels if name != reply.forecast]
    known = sum(prior.get(name, 0.0) for name in others)
    left = 1.0 - reply.forecast_probability
    shares = {name: prior.get(name, 0.0) / known if known > 0 else 1.0 / len(others) for name in others}
    return {
        name: round(reply.forecast_probability if name == reply.forecast else left * shares[name], _DIGITS) for name in labels
    }
