"""Joint temperatures: a gear with its oil, a sensor beside it, and the room around both."""

from .difficulty import by_size


class Thermal:
    """
    Two nodes per joint; the gear's drives friction, the sensor's is what the robot reports.

    gear, sensor (n,) [degC]. Friction power and a share of the drive loss heat the gear, the
    rest of the drive loss the sensor's node; both cool to the room and exchange heat. Time
    constants are minutes: exchange about 1, cooling about 10.
    """

    def __init__(self, robot, difficulty, start, ambient, rng):
        max_torque = robot.file.max_torque
        self._capacity = by_size(difficulty.heat_capacity, max_torque)
        self._sensor_capacity = self._capacity * difficulty.sensor_share
        cooling = by_size(difficulty.cooling, max_torque)
        self._cooling = 0.5 * cooling
        self._exchange = difficulty.exchange * cooling
        self._loss = by_size(difficulty.drive_loss, max_torque) / max_torque ** 2
        self._in_gear = difficulty.drive_loss_in_gear
        self.ambient = float(ambient)
        spread = difficulty.temperature_spread
        self.gear = start + rng.uniform(-spread, spread, robot.n)
        # Nearer to the room, the sensor lags a gear that was warmed by work.
        lag = self._cooling / (self._cooling + self._exchange) * rng.uniform(0.0, 1.0, robot.n)
        self.sensor = self.gear - lag * (self.gear - ambient)

    def step(self, friction_power, torque_squared, dt):
        """Advance dt [s] under mean friction power (n,) [W] and mean square torque (n,) [Nm^2]."""
        loss = self._loss * torque_squared
        across = self._exchange * (self.gear - self.sensor)
        into_gear = (friction_power + self._in_gear * loss - across
                     - self._cooling * (self.gear - self.ambient))
        into_sensor = ((1.0 - self._in_gear) * loss + across
                       - self._cooling * (self.sensor - self.ambient))
        self.gear = self.gear + dt * into_gear / self._capacity
        self.sensor = self.sensor + dt * into_sensor / self._sensor_capacity
