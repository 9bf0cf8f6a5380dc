"""
Node parameters from one declarative table per node.

The table is the single source of declaration, default, unit, description, allowed values,
read-only flag and documentation. A node reads its parameters from `.values`, an immutable object
that is swapped as a whole when an allowed change arrives.
"""

import difflib
import math
from dataclasses import dataclass, make_dataclass

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rcl_interfaces.msg import SetParametersResult
from rclpy.exceptions import ParameterException

from ..errors import ConfigurationError

# rclpy itself declares or reads these for every node.
_RCLPY_OWN = ('use_sim_time', 'start_type_description_service', 'qos_overrides')


@dataclass(frozen=True)
class Parameter:
    """
    One row of a node's parameter table.

    default: bool, int, float, str, or a non-empty tuple of floats or strings; its type is the
    parameter's type. low, high: range of a number or of each number of a tuple. choices: allowed
    texts. size: required length of a tuple. read_only: fixed after start. todo: of a parameter
    that must be given, what to do where it is not; its default only tells the type.
    """

    name: str
    default: object
    description: str
    unit: str = ''
    low: float | None = None
    high: float | None = None
    choices: tuple = ()
    size: int | None = None
    read_only: bool = True
    todo: str = ''

    @property
    def field(self):
        """Name of the attribute of the values object: dots become underscores."""
        return self.name.replace('.', '_')

    @property
    def kind(self):
        """Type as ROS names it, e.g. double or string_array."""
        words = {bool: 'bool', int: 'integer', float: 'double', str: 'string'}
        if isinstance(self.default, tuple):
            return f'{words[type(self.default[0])]}_array'
        return words[type(self.default)]

    @property
    def default_text(self):
        """Default as YAML and documentation write it."""
        if isinstance(self.default, bool):
            return str(self.default).lower()
        return str(list(self.default) if isinstance(self.default, tuple) else self.default)

    @property
    def allowed(self):
        """Allowed values in words; empty when every value of the type is."""
        if self.choices:
            return ' or '.join(self.choices)
        parts = [f'{self.size} values'] if self.size is not None else []
        if self.low is not None or self.high is not None:
            low = '-inf' if self.low is None else f'{self.low:g}'
            high = 'inf' if self.high is None else f'{self.high:g}'
            parts.append(f'{low} to {high}')
        return ', '.join(parts)

    def convert(self, value):
        """Return the value in the table's type; ValueError (a sentence) when not allowed."""
        if isinstance(self.default, tuple):
            if isinstance(value, (str, bytes)) or not hasattr(value, '__len__') or not len(value):
                raise ValueError(f'must be a list that is not empty ({self.kind})')
            if self.size is not None and len(value) != self.size:
                raise ValueError(f'must have {self.size} values, got {len(value)}')
            return tuple(self._scalar(v, self.default[0]) for v in value)
        return self._scalar(value, self.default)

    def _scalar(self, value, like):
        if isinstance(like, float) and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if type(value) is not type(like):
            raise ValueError(f'must be of type {self.kind}, got {value!r}')
        if isinstance(value, float) and not math.isfinite(value):
            raise ValueError(f'must be finite, got {value!r}')
        if self.choices and value not in self.choices:
            raise ValueError(f'is not usable, got {value!r}; allowed: {self.allowed}')
        if (self.low is not None and value < self.low) \
                or (self.high is not None and value > self.high):
            raise ValueError(f'is out of range, got {value!r}; allowed: {self.allowed}')
        return value

    def descriptor(self):
        """Return the ParameterDescriptor shown by `ros2 param describe`."""
        unit = f' [{self.unit}]' if self.unit else ''
        out = ParameterDescriptor(
            description=f'{self.description}{unit}', read_only=self.read_only,
            additional_constraints=self.allowed,
            # So that `rate: 500` is understood where 500.0 is meant; convert() checks the type.
            dynamic_typing=isinstance(self.default, (float, tuple)))
        low = -math.inf if self.low is None else self.low
        high = math.inf if self.high is None else self.high
        if self.low is None and self.high is None:
            return out
        if type(self.default) is float:
            out.floating_point_range = [FloatingPointRange(
                from_value=max(low, -1e300), to_value=min(high, 1e300))]
        elif type(self.default) is int:
            out.integer_range = [IntegerRange(from_value=int(max(low, -2**62)),
                                              to_value=int(min(high, 2**62)), step=1)]
        return out


def _overrides(node):
    """Return what command line and YAML files gave for the node; rclpy has no public way."""
    return getattr(node, '_parameter_overrides', {})


class NodeParameters:
    """
    The declared parameters of a node.

    `.values` is an immutable object with one attribute per row. `changed(values)` is
    called after a change. Raises ConfigurationError for wrong values at start.
    """

    def __init__(self, node, table, changed=None):
        self._table = {row.name: row for row in table}
        self._changed = changed
        self._type = make_dataclass(f'{node.get_name().title()}Parameters',
                                    [row.field for row in table], frozen=True)
        self._where = f'node {node.get_name()}'
        self._warn_of_unknown(node)
        given = {row.field: self._declare(node, row) for row in table}
        self.values = self._type(**given)
        node.add_on_set_parameters_callback(self._validate)
        node.add_post_set_parameters_callback(self._apply)

    def _declare(self, node, row):
        if row.todo and row.name not in _overrides(node):
            raise ConfigurationError(f'{self._where}: parameter {row.name}', 'must be given',
                                     allowed=row.allowed, todo=row.todo)
        default = list(row.default) if isinstance(row.default, tuple) else row.default
        try:
            try:
                value = node.declare_parameter(row.name, default, row.descriptor()).value
            except ParameterException:
                # rclpy's sentence names neither unit nor choices; ours does.
                value = _overrides(node)[row.name].value
            return row.convert(value)
        except ValueError as error:
            raise ConfigurationError(f'{self._where}: parameter {row.name}', error) from None

    def _warn_of_unknown(self, node):
        # rclpy ignores what nobody declares, so a typing error would go unseen.
        for name in _overrides(node):
            if name in self._table or name.split('.')[0] in _RCLPY_OWN:
                continue
            near = difflib.get_close_matches(name, self._table, 1)
            hint = f'did you mean {near[0]}?' if near else f'known: {", ".join(self._table)}'
            node.get_logger().warning(f'parameter {name} is not known and has no effect; {hint}')

    def _after(self, parameters):
        """Return the values after the change; ValueError when a value is not allowed."""
        new = {row.field: getattr(self.values, row.field) for row in self._table.values()}
        for parameter in parameters:
            row = self._table.get(parameter.name)
            if row is None:
                continue
            try:
                new[row.field] = row.convert(parameter.value)
            except ValueError as error:
                raise ValueError(f'{row.name} {error}') from None
        return self._type(**new)

    def _validate(self, parameters):
        try:
            self._after(parameters)
        except ValueError as error:
            return SetParametersResult(successful=False, reason=str(error))
        return SetParametersResult(successful=True)

    def _apply(self, parameters):
        if not any(p.name in self._table for p in parameters):
            return
        self.values = self._after(parameters)
        if self._changed:
            self._changed(self.values)


def markdown_table(table):
    """Return the README table of a parameter table, as text."""
    lines = ['| parameter | default | unit | allowed | description |', '|---|---|---|---|---|']
    for row in table:
        default = 'must be given' if row.todo else f'`{row.default_text}`'
        change = '' if row.read_only else ' (can be changed while running)'
        lines.append(f'| `{row.name}` | {default} | {row.unit} | {row.allowed or row.kind} '
                     f'| {row.description}{change} |')
    return '\n'.join(lines)
