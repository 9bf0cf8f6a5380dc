"""The load before a change, should that turn out to have been a contact."""

from hand_load_estimator.estimators.old_load import AGAIN, OldLoads

UNSURELY = {'surely': False, 'ails': False}


def test_it_comes_back_soon_after_another_time_where_it_is_seen_again():
    loads = OldLoads()
    loads.keep(10.0, 'first')
    assert loads.back(10.5, **UNSURELY) == 'first'
    loads.keep(11.0, 'second')
    assert loads.back(11.5, **UNSURELY) is None, 'not twice'
    assert loads.again(13.0) == 'second' and loads.again(13.1) is None, 'it is held now'


def test_it_comes_back_as_long_as_contacts_are_left_out():
    loads = OldLoads()
    assert loads.again(1.0) is None
    loads.keep(10.0, 'old')
    assert loads.again(10.0 + AGAIN + 0.1) is None and loads.again(9.0) is None
    assert loads.again(10.0 + AGAIN - 0.1) == 'old'
