"""
Keep contacts out of the estimate, whatever tells them: see contact_gate, push_watch, rest_watch.

A push that at any one moment another load explains first looks like a change of the load. The
watch then compares both, and the method goes back to the load before (LoadRegression.take_back).
"""

from .contact_gate import ContactGate, OVER
from .load_prior import load_prior
from .old_load import TAKEN_BACK
from .push_watch import PushWatch
from .rest_watch import ANOTHER_LOAD, NOTHING, RestWatch


class ContactWatch:
    """
    Watch for contacts along a LoadRegression that looks for load changes.

    model: TorqueModel; uncertainties: number of model columns.
    """

    def __init__(self, model, regression, uncertainties):
        robot = model.robot
        self._regression = regression
        self._gate = ContactGate(robot.joints, model.residuals.rmse, regression.change,
                                 robot.effort.torque_constants_std)
        self._rest = RestWatch(robot.joints, model.noise, regression.change)
        self._pushes = PushWatch(robot, load_prior(robot), regression.change, uncertainties)
        self.began, self._again = False, 0.0

    @property
    def contact(self):
        """What is in contact, in words, or an empty string."""
        return self._gate.reason

    @property
    def reason(self):
        """Why torques are not the load's: a contact, a joint that sticks; or an empty string."""
        return self._gate.reason or self._rest.reason

    def look_for_push(self, sample, columns, prediction):
        """
        Tell whether the change of load just now was a push, by a sample and its joined_columns.

        With every sample, before update.
        """
        if self._gate.reason and not self._pushes.begun:
            self._pushes.begin(self._regression.present_belief(),
                               self._regression.evidence_needed(), TAKEN_BACK)
        difference = self._regression.beside_tared(columns, prediction.difference)
        return (self._pushes.take(sample, columns, difference, prediction.density)
                and not self._gate.reason)

    def hold(self):
        """Be in contact until the push has ended, for which a change has been taken back."""
        self._gate.hold()

    def update(self, sample, prediction, innovation, spread, load_torque):
        """
        Take a MotionSample, its Prediction and what innovation_of says of it.

        Return whether it is a contact's, to be left out, and whether another load is held since
        about now. began: whether a contact has just begun.
        """
        before, pushed = self._gate.reason, self._pushes.told
        contact = self._gate.update(prediction, innovation, load_torque, sample.dt, pushed)
        beyond = self._rest.update(sample, innovation, spread, prediction)
        if beyond != NOTHING and not (contact and pushed):
            contact = self._gate.refuses(prediction, innovation, load_torque)
        self.began = bool(self._gate.reason and not before)
        if before and not contact:
            self._pushes.end()
        return contact, beyond == ANOTHER_LOAD and not contact

    def old_load_again(self, sample, columns, prediction):
        """
        Tell whether the load before the last change explains what is left out, and ours does not.

        With every sample of a contact, after update. It has done so for as long as ends a contact.
        """
        older = self._regression.older_belief
        alone = not self._gate.explained and older is not None and self._gate.explains(
            prediction, self._regression.beside_tared(columns, prediction.difference)
            - columns.dot(older.mean), columns[:, :10].dot(older.mean[:10]))
        self._again = self._again + sample.dt if alone else 0.0
        return self._again >= OVER

    def changed(self):
        """Begin anew after a change of the load, which may turn out to have been a push."""
        self.clear()
        self._pushes.begin(self._regression.older_belief, self._regression.evidence_needed(),
                           TAKEN_BACK)

    def clear(self):
        """Begin anew."""
        self._gate.clear()
        self._rest.restart()
        self._pushes.end()
        self._again = 0.0
