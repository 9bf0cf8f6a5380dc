"""Quality of service: three kinds of topics."""

from rclpy.event_handler import PublisherEventCallbacks
from rclpy.qos import DurabilityPolicy, HistoryPolicy, QoSProfile, ReliabilityPolicy

OUTPUT = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=10,
                    reliability=ReliabilityPolicy.RELIABLE,
                    durability=DurabilityPolicy.VOLATILE)
"""Results: reliable, the last ten."""

LATCHED = QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=1,
                     reliability=ReliabilityPolicy.RELIABLE,
                     durability=DurabilityPolicy.TRANSIENT_LOCAL)
"""Facts that hold until they change: a late subscriber gets the last one."""


def measurement(depth):
    """
    Return the profile for sensor inputs: best effort, so that every publisher matches.

    depth: messages kept while the node is busy; at least one second of them.
    """
    return QoSProfile(history=HistoryPolicy.KEEP_LAST, depth=depth,
                      reliability=ReliabilityPolicy.BEST_EFFORT,
                      durability=DurabilityPolicy.VOLATILE)


def publisher(node, kind, topic, profile):
    """
    Return a publisher that waits for no events of its own.

    rclpy adds two event handlers to each publisher, to be looked at whenever any message
    arrives: at 1 kHz they cost a node a tenth of a core. A subscriber whose profile does not
    match is still told so on its own side.
    """
    return node.create_publisher(
        kind, topic, profile,
        event_callbacks=PublisherEventCallbacks(use_default_callbacks=False))
