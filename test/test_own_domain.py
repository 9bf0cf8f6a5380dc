"""A domain of one's own: held by one at a time, never the shell's, and the shell's comes back."""

import os

import pytest

from hand_load_estimator.errors import ConfigurationError
from hand_load_estimator.simulation import own_domain as module
from hand_load_estimator.simulation.own_domain import free_domain, own_domain


def test_two_at_a_time_get_two_domains():
    with free_domain() as one, free_domain() as other:
        assert one != other and 1 <= min(one, other) and max(one, other) <= 101


def test_a_robots_domain_of_the_shell_is_left_and_comes_back(monkeypatch):
    with free_domain() as taken:
        pass
    shell = {'ROS_DOMAIN_ID': str(taken), 'ROS_AUTOMATIC_DISCOVERY_RANGE': 'SUBNET',
             'ROS_STATIC_PEERS': '192.168.1.2'}
    for name, value in shell.items():
        monkeypatch.setenv(name, value)
    with own_domain() as number:
        assert number != taken and os.environ['ROS_DOMAIN_ID'] == str(number)
        assert os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] == 'LOCALHOST'
        assert 'ROS_STATIC_PEERS' not in os.environ
    assert {name: os.environ[name] for name in shell} == shell


def test_none_free_is_told(monkeypatch):
    with free_domain() as number:
        monkeypatch.setattr(module, '_DOMAINS', [number])
        with pytest.raises(ConfigurationError, match='none is free'), free_domain():
            pass
