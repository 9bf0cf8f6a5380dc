"""What a node says about itself: /diagnostics once a second, one status per concern."""

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from rclpy.clock import Clock
from rclpy.clock_type import ClockType

from .qos import OUTPUT, publisher

OK, WARN, ERROR, STALE = (DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR,
                          DiagnosticStatus.STALE)


def status_message(name, level, message, values, hardware_id=''):
    """Return a DiagnosticStatus; values: mapping or pairs, written as text."""
    pairs = values.items() if hasattr(values, 'items') else values
    return DiagnosticStatus(level=level, name=name, message=message, hardware_id=hardware_id,
                            values=[KeyValue(key=str(k), value=_text(v)) for k, v in pairs])


def _text(value):
    return f'{value:.6g}' if isinstance(value, float) else str(value)


class Diagnostics:
    """
    Publishes /diagnostics once a second of real time.

    `add(concern, report)`: report() returns (level, message, values) each second. The status is
    named `<node>: <concern>`. `publish()` may also be called at once, on a change.
    """

    def __init__(self, node, hardware_id=''):
        self._node, self._hardware_id, self._concerns = node, hardware_id, []
        self._publisher = publisher(node, DiagnosticArray, '/diagnostics', OUTPUT)
        # Real time: an operator must hear of a stopped simulation clock.
        self._timer = node.create_timer(1.0, self.publish,
                                        clock=Clock(clock_type=ClockType.STEADY_TIME))

    def add(self, concern, report):
        """Add a concern with its report function."""
        self._concerns.append((concern, report))

    def publish(self):
        """Publish one status per concern now."""
        name = self._node.get_fully_qualified_name().lstrip('/')
        message = DiagnosticArray()
        message.header.stamp = self._node.get_clock().now().to_msg()
        message.status = [
            status_message(f'{name}: {concern}', *report(), hardware_id=self._hardware_id)
            for concern, report in self._concerns]
        self._publisher.publish(message)
