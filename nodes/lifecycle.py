"""`sim_node` as a lifecycle node."""

from __future__ import annotations

from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from rclpy.parameter import Parameter

from . import parameters
from .simulator import Simulator
from .start import one_line

SUCCESS, FAILURE = TransitionCallbackReturn.SUCCESS, TransitionCallbackReturn.FAILURE


class SimNode(LifecycleNode):
    """The states of the simulator.

    configure: scene, log, topics and services are made. activate: time runs. deactivate: time
    stands still. cleanup: the log is closed, topics and services go; configuring again begins a
    new run. shutdown: as cleanup, and the process ends.

    Raises ValueError for parameters that are not allowed.
    """

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self.simulator: Simulator | None = None
        self.error: BaseException | None = None  # why configuring failed, or what broke a run
        self._shut_down = False
        self._configured = False  # once
        self._table = parameters.load_table()
        parameters.declare(self, self._table)
        self.add_on_set_parameters_callback(lambda changes: parameters.check(self._table, changes))
        self.add_post_set_parameters_callback(self._changed)

    @property
    def finished(self) -> bool:
        """The process may end: duration over, run broken, or shut down."""
        return self._shut_down or (
            self.simulator is not None and self.simulator.loop.finished.is_set()
        )

    def close(self) -> None:
        """End the run, if there is one, with its log closed."""
        if self.simulator is not None:
            simulator, self.simulator = self.simulator, None
            self.error = simulator.close() or self.error

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.error = None
        values = {name: self.get_parameter(name).value for name in self._table}
        try:
            self.simulator = Simulator(self, values)
        except Exception as error:  # rclpy has no common class, and would keep the reason to itself
            self.error = error
            if (
                self._configured or not values["autostart"]
            ):  # else the process ends with this sentence
                self.get_logger().error(one_line(error))
            return FAILURE
        self._configured = True
        return SUCCESS

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        assert self.simulator is not None
        self.simulator.activate()
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        assert self.simulator is not None
        self.simulator.deactivate()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.close()
        return SUCCESS

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        self.close()
        self._shut_down = True
        return SUCCESS

    def _changed(self, changes: list[Parameter]) -> None:
        if self.simulator is not None:
            self.simulator.parameters_changed(changes)
