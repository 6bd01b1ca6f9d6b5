"""Trainings off the kernel's thread: one worker thread, numpy releases the interpreter in its matrix products."""

from __future__ import annotations

from concurrent.futures import Executor, Future, ThreadPoolExecutor

from wakeful.contracts.learner import Learner
from wakeful.facts.crash_points import reach
from wakeful.facts.inputs import Trained, Training


class Trainer:
    """Runs trainings one after the other in a thread of its own.

    Args:
        learner: trains; the same job gives the same bytes.
        pool: the executor of one thread that does so; its own where None.
    """

    def __init__(self, learner: Learner, pool: Executor | None = None) -> None:
        self._learner = learner
        self._pool = pool if pool is not None else ThreadPoolExecutor(1, thread_name_prefix="wakeful-training")
        self._running: dict[int, tuple[Training, Future[Trained]]] = {}

    def start(self, training: Training) -> None:
        """Begin, or queue, a training."""
        self._running[training.training] = (training, self._pool.submit(self._train, training))

    def _train(self, training: Training) -> Trained:
        card, weights = self._learner.train(training.job)
        reach("publication: trained")
        return Trained(training=training.training, card=card, weights=weights)

    def next_publication_ns(self) -> int | None:
        """The instant at which the first of the running trainings is to be published."""
        return min((training.publish_ns for training, _ in self._running.values()), default=None)

    @property
    def ended(self) -> bool:
        """Whether one has ended."""
        return any(future.done() for _, future in self._running.values())

    def take(self, publish_ns: int) -> list[Trained]:
        """Wait for the trainings that are to be published by then, and hand them over in order."""
        due = sorted(number for number, (training, _) in self._running.items() if training.publish_ns <= publish_ns)
        return [self._running.pop(number)[1].result() for number in due]

    def finished(self) -> list[Trained]:
        """The trainings that have ended, whatever their declared instant: for the live driver."""
        ended = sorted(number for number, (_, future) in self._running.items() if future.done())
        return [self._running.pop(number)[1].result() for number in ended]

    def close(self) -> None:
        """Let go of the thread; a training that has begun is waited for, its answer is not used."""
        self._pool.shutdown(wait=True, cancel_futures=True)
