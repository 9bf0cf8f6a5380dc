"""A subscription that catches up quickly after a hiccup."""

_MOST = 50  # messages taken at a time, before services and timers have their turn


def subscribe_draining(node, kind, topic, take, profile):
    """
    Subscribe and call take(message) for every message.

    rclpy's executor takes one message per turn and looks at every entity of the node in each,
    which costs several times what the message does. When messages have queued up they are all
    taken in one turn here.
    """
    def received(message):
        take(message)
        with subscription.handle:
            for _ in range(_MOST):
                waiting = subscription.handle.take_message(kind, False)
                if waiting is None:
                    break
                take(waiting[0])

    subscription = node.create_subscription(kind, topic, received, profile)
    return subscription
