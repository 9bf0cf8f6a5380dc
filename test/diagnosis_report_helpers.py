"""Diagnoses made by hand, and the page of one as a browser reads it."""

import dataclasses
from html.parser import HTMLParser
import re

import numpy as np

from hand_load_estimator.residual.diagnosis import (Alternative, CONFIRMED, Diagnosis,
                                                    Evidence, Finding, FineTuning, LoadError,
                                                    Picture, SUSPECTED, UNKNOWN)

JOINTS = ('shoulder_pan_joint', 'shoulder_lift_joint', 'elbow_joint', 'wrist_1_joint',
          'wrist_2_joint', 'wrist_3_joint')
VOID = {'meta', 'img', 'br', 'wbr'}


def picture(joint, variable, x, function, noise=0.15):
    """Return residual bins scattered about function(x), and that function as the fit."""
    curve = function(x)
    mean = curve + noise * np.random.default_rng(3).normal(size=len(x))
    return Picture(joint, variable, x, mean, np.full(len(x), noise), curve, curve - 0.12,
                   curve + 0.12)


def ripple():
    """Return a torque ripple of the elbow, beyond doubt."""
    return Finding(
        'torque_ripple', ('elbow_joint',),
        {'amplitude': (2.71, 0.031, 'Nm'), 'phase': (0.82, 0.012, 'rad'),
         'period': (0.0628, 0.0, 'rad')},
        np.array([0.0, 0.0, 0.71, 0.0, 0.0, 0.0]),
        Evidence(1412.0, 96.0, 11.2, 18, 143, 1.92, 'cable_drag', 655.0), (), '', False,
        CONFIRMED, (picture('elbow_joint', 'position within one period [rad]',
                            np.linspace(0.0, 0.0628, 26), lambda x: 2.7 * np.sin(100.0 * x)),))


def spring():
    """Return a spring on two joints that these recordings cannot tell from a link's inertia."""
    joints = ('shoulder_lift_joint', 'wrist_1_joint')
    position = np.linspace(-1.8, 1.8, 30)
    pictures = (picture(joints[0], 'position [rad]', position, lambda q: 6.0 * np.sin(q - 0.4)),
                picture(joints[1], 'position [rad]', position, lambda q: 0.8 * np.sin(q), 0.06))
    parameters = {f'torque ({joints[0]})': (6.02, 0.4, 'Nm'),
                  f'slope ({joints[1]})': (-3.1e-5, 4e-6, 'Nm s/(rad K^2)')}
    return Finding(
        'gravity_spring', joints, parameters, np.array([0.0, 0.46, 0.0, 0.31, 0.0, 0.0]),
        Evidence(84.0, 19.0, 11.2, 18, 143, 4.1, 'cable_drag', 12.5),
        (Alternative('link_inertia', joints, 2.5, 4.0),
         Alternative('cable_drag', joints[:1], 12.5, 9.0)),
        'turn shoulder_lift_joint by a full turn, slowly.', True, SUSPECTED, pictures)


def unknown():
    """Return structure that no effect of the vocabulary explains."""
    speed = np.linspace(-2.0, 2.0, 32)
    return Finding(
        UNKNOWN, ('wrist_2_joint',), {}, np.array([0.0, 0.0, 0.0, 0.0, 0.37, 0.0]),
        Evidence(51.0, 11.0, 11.2, 18, 143, 0.4), (), '', False, SUSPECTED,
        (picture('wrist_2_joint', 'velocity [rad/s]', speed,
                 lambda v: v / (0.2 + (np.abs(v) - 1.0) ** 2) / 5.0, 0.08),), ('velocity',))


def swing():
    """Return structure of two joints that rings with one frequency."""
    time = np.linspace(0.0, 10.0, 200)
    return Finding(
        UNKNOWN, JOINTS[3:5], {'frequency': (0.88, 0.015, 'Hz')},
        np.array([0.0, 0.0, 0.0, 0.62, 0.57, 0.0]),
        Evidence(269.0, 46.0, 131.0, 12, 1900, 0.8), (), '', False, CONFIRMED,
        (picture('wrist_1_joint', 'time [s]', time, lambda t: np.sin(5.5 * t)),), ('time',))


def found():
    """Return a diagnosis with three findings."""
    return Diagnosis(
        'ur10e', JOINTS, np.array([1.31, 5.2, 2.41, 0.83, 0.57, 0.36]),
        np.array([1.30, 3.1, 1.33, 0.71, 0.46, 0.36]),
        np.array([1.2, 1.22, 0.93, 0.35, 0.36, 0.34]), (ripple(), spring(), unknown()),
        np.array([0.02, 0.31, 0.004, 0.12, 0.04, np.nan]),
        ('cannot tell the temperature of Coulomb from that of viscous friction because all '
         'recordings are between 24 and 26 degC',),
        LoadError(0.412, 0.0141, 12), LoadError(0.122, 0.0062, 12), '',
        ('monday_cold', 'monday_warm', 'tuesday_fast'), 'the recording tuesday_fast', 97.4,
        ('wrist_1_joint: slow change over time, largest in monday_cold',))


def tuned(before=LoadError(0.098, 0.0051, 12), after=LoadError(0.087, 0.0048, 12)):
    """Return the same diagnosis with an artefact fine-tuned from the better model."""
    return dataclasses.replace(found(), fine_tuning=FineTuning('the <first>', before, after))


def nothing():
    """Return the diagnosis of a model that lacks nothing."""
    error = np.array([1.24, 1.25, 0.94, 0.36, 0.36, 0.35])
    return Diagnosis('ur10e', JOINTS, error, error, 0.98 * error, (), np.full(6, 0.01),
                     load_reason='no loaded recordings with known loads were given.',
                     recordings=('monday',), tested_on='the last quarter of monday',
                     seconds=41.0)


class Reader(HTMLParser):
    """Collects visible text, images and tags that are not closed in order."""

    def __init__(self, text):
        super().__init__()
        self.open, self.text, self.images, self.attributes = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.attributes += attrs
        if tag == 'img':
            self.images.append(dict(attrs))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if 'style' not in self.open:
            self.text.append(data)

    def words(self):
        return re.sub(r'\s+', ' ', ''.join(self.text).replace('\u00ad', ''))
