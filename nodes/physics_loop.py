"""The physics thread: takes in messages and orders, steps the world, sends what is due."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from typing import Any, Protocol

from rb_physics.errors import DivergedError

from .commands import Answer, Command, CommandQueue
from .inputs import Inputs
from .pacer import Pacer
from .wrench_inputs import Perform

IDLE = 0.05  # s of wall time between looks at the inbox while nothing moves
INTERRUPTING = ("pause", "reset", "reset_state", "restart")  # orders that end a ~/step in progress
LONGEST_CHUNK = 1000  # steps made in one go at most, so that orders are answered soon


class Sender(Protocol):
    """Where the results of the loop go."""

    def start(self, world: Any) -> None:
        """The world stands at the start of a run, or of a further one after a reset."""

    def steps_until_due(self, world: Any) -> int:
        """How many steps may be made before something must be sent (at least 1)."""

    def accepted(self, world: Any, messages: list) -> None:
        """Messages were accepted and act from the next step on."""

    def stepped(self, world: Any) -> None:
        """Steps were made: send what is due."""

    def send_until(self, deadline: float) -> None:
        """Send what still waits, as long as time.monotonic() is before `deadline`."""

    def flush(self) -> None:
        """Send all that still waits."""

    def idle(self, world: Any) -> None:
        """Nothing moves: see to newcomers."""


class PhysicsLoop:
    """Steps a world until it is stopped.

    One turn is: orders, messages, as many steps as are allowed and as fit before the next event
    (an output that is due, a wrench that expires), then what is due is sent. Orders and messages
    act between steps only, and the same ones at the same steps give the same run.
    """

    def __init__(
        self,
        world: Any,
        inputs: Inputs,
        sender: Sender,
        pacer: Pacer,
        perform: Perform,
        *,
        paused: bool,
        duration: float,
        log: Callable[[str], None],
        save: Callable[[Any], str],
        spawned: Callable[[], Sequence[str]],
    ) -> None:
        self.world = world
        self.commands = CommandQueue()
        self.finished = threading.Event()  # the duration is over, or the loop has ended
        self.error: BaseException | None = None
        self.paused = paused
        self._halted = False  # paused by a divergence: a reset goes on
        self._divergence = ""  # the sentence of it
        self.held = False  # nothing steps, not even ~/step: the node is inactive
        self._inputs = inputs
        self._sender = sender
        self._pacer = pacer
        self._perform = perform
        self._log = log
        self._save = save
        self._spawned = spawned
        self._last_step = round(duration / world.settings.dt) if duration > 0 else None
        self._ordered: Command | None = None  # a ~/step in progress
        self._ordered_until = 0
        self._stopping = threading.Event()

    def run(self) -> None:
        """The body of the thread; returns after `stop`."""
        try:
            self._sender.start(self.world)
            self._pacer.restart(self.step)
            while not self._stopping.is_set():
                self._serve()
                self._receive()
                allowed = self._steps_allowed()
                if allowed > 0:
                    self._receive()  # what came while waiting
                    self._advance(allowed)
        except BaseException as error:  # reported by the main thread, which ends the process
            self.error = error
        finally:
            self.commands.close()
            self._end_ordered(False, "the simulator is shutting down")
            self.finished.set()

    def stop(self) -> None:
        """Let `run` return after the step in progress."""
        self._stopping.set()
        self.commands.wake()

    @property
    def stands_still(self) -> bool:
        """No step is made before somebody orders it; a lockstep run waits for messages only."""
        return self._ordered is None and self.state[1] != "running"

    @property
    def state(self) -> tuple[int, str]:
        """Level (of diagnostics) and text of what it is doing."""
        if self._halted:
            return 2, f"paused: {self._divergence}"
        if self.held:
            return 0, "inactive"
        if self._last_step is not None and self.step >= self._last_step:
            return 0, "the duration is over"
        if self.paused and self._ordered is None:
            return 0, "paused"
        return 0, "running"

    @property
    def step(self) -> int:
        """Number of the next step, counted from time 0."""
        return int(self.world.step_count)

    def _steps_allowed(self) -> int:
        """How many steps may be made now; rests or sleeps when the answer is 0."""
        if self.held:
            self._rest()
            return 0
        if self._ordered is not None:
            return self._ordered_until - self.step
        if self._last_step is not None and self.step >= self._last_step:
            self.finished.set()
            self._rest()
            return 0
        if self.paused:
            self._rest()
            return 0
        lockstep = self._inputs.lockstep
        if lockstep is not None:
            if lockstep.complete:
                return 1
            self._inputs.wait(self.world)
            self._rest()
            return 0
        return self._pacer.wait(self.step, self._sender.send_until)

    def _rest(self) -> None:
        self._sender.idle(self.world)
        self.commands.rest(IDLE)

    def _receive(self) -> None:
        accepted = self._inputs.receive(self.world, self.step, self._perform)
        if accepted:
            self._sender.accepted(self.world, accepted)

    def _advance(self, allowed: int) -> None:
        world, step, inputs = self.world, self.step, self._inputs
        inputs.apply(world, step, self._perform)
        limits = [
            allowed,
            self._sender.steps_until_due(world),
            inputs.motions.steps_unchanged(step),
            LONGEST_CHUNK,
            self._last_step - step if self._last_step is not None else None,
        ]
        count = max(1, min(limit for limit in limits if limit is not None))
        try:
            world.step(count)
        except (
            DivergedError,
            ValueError,
        ) as error:  # the latter where numbers are no more than huge
            self._diverged(error)
            return
        if inputs.lockstep is not None:
            inputs.lockstep.next_step()
        self._sender.stepped(world)
        if self._ordered is not None or inputs.lockstep is not None or self._pacer.factor == 0.0:
            self._sender.flush()
        if self._ordered is not None and self.step >= self._ordered_until:
            self._end_ordered(True, f"at step {self.step}, time {world.time:.9g} s")

    def _diverged(self, error: ValueError | DivergedError) -> None:
        self.paused = self._halted = True
        self._divergence = str(error)
        self._log(f"{error}; the simulation is paused at its last good state, ~/reset starts anew")
        self._end_ordered(False, str(error))

    def _serve(self) -> None:
        while (command := self.commands.take()) is not None:
            if command.name == "step":
                self._order_steps(command, *command.arguments)
                continue
            if command.name in INTERRUPTING:
                self._end_ordered(False, f"ended by ~/{command.name} at step {self.step}")
            try:
                answer = getattr(self, f"_do_{command.name}")(*command.arguments)
            except BaseException:  # ends the loop; nobody should wait for its answer
                command.finish(False, "the simulator failed and ends")
                raise
            command.finish(*answer)

    def _end_ordered(self, success: bool, message: str) -> None:
        command, self._ordered = self._ordered, None
        if command is not None:
            self._pacer.restart(self.step)
            command.finish(success, message)

    def _order_steps(self, command: Command, count: int) -> None:
        if self.held:
            command.finish(False, "the node is inactive: activate it first")
            return
        if self._ordered is not None:
            command.finish(False, "another ~/step is in progress")
            return
        if not self.paused and self._inputs.lockstep is None:
            command.finish(False, "~/step works while paused or in lockstep: call ~/pause first")
            return
        if self._last_step is not None and self.step >= self._last_step:
            command.finish(False, "the duration of the run is over")
            return
        self._ordered = command
        self._ordered_until = self.step + count
        if self._last_step is not None:
            self._ordered_until = min(self._ordered_until, self._last_step)

    def _do_pause(self, pause: bool) -> Answer:
        self.paused, self._halted = pause, False
        self._pacer.restart(self.step)
        now = f"{'paused' if pause else 'running'} at time {self.world.time:.9g} s"
        return True, now + (", once the node is active" if self.held and not pause else "")

    def _do_hold(self, hold: bool) -> Answer:
        self.held = hold
        self._end_ordered(False, "ended: the node was deactivated")
        self._pacer.restart(self.step)
        return True, ""

    def _do_clear_wrenches(self) -> Answer:
        count = self._inputs.wrenches.clear(self.step, self._perform)
        return True, f"cleared {count} applied wrench{'' if count == 1 else 'es'}"

    def _do_reset(self) -> Answer:
        return self._restore("reset")

    def _do_reset_state(self) -> Answer:
        return self._restore("reset_state")

    def _do_restart(self, state: bool, time: bool, spawned: bool) -> Answer:
        """Reset any of state, time and the set of bodies."""
        if state:
            return self._restore("reset" if time else "reset_state", keep_spawned=not spawned)
        if spawned:
            for name in self._spawned():
                self._perform("remove_body", body=name)
        return self._restore("reset_time") if time else (True, "")

    def _restore(self, operation: str, **arguments: bool) -> Answer:
        self._inputs.clear(self.step, self._perform)
        self._perform(operation, **arguments)
        if self._halted:
            self.paused = self._halted = False
        self._sender.start(self.world)
        self._pacer.restart(self.step)
        return True, f"state reset, time is {self.world.time:.9g} s"

    def _do_save(self) -> Answer:
        try:
            return True, self._save(self.world)
        except (OSError, ValueError) as error:
            return False, str(error)

    def _do_call(self, action: Callable[[], str | None]) -> Answer:
        try:
            return True, action() or ""
        except (ValueError, KeyError) as error:
            return False, str(error.args[0])

    def _do_set(self, setter: Callable[[Any], None], value: Any) -> Answer:
        setter(value)
        self._pacer.restart(self.step)
        return True, ""
