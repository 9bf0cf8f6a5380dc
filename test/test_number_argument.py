"""Numbers of the command line that nothing can be done with are refused in one line."""

import pytest

from hand_load_estimator.cli import main

SEED = 'allowed: 0 to 2147483648'


@pytest.mark.parametrize('arguments, allowed', [
    (('excite', '--robot', 'ur10e', '--seed', '-3'), SEED),
    (('excite', '--robot', 'ur10e', '--seed', '1.5'), SEED),
    (('demo', '--seed', '-1'), SEED),
    (('demo', '--seed', '2147483649'), SEED),
    (('simulate', '--robot', 'ur10e', '--rate', 'nan'), 'allowed: 30 to 1000'),
    (('benchmark', '--suite', 'soak', '--hours', 'nan'), 'allowed: at least 0.001'),
    (('benchmark', '--suite', 'soak', '--hours', 'inf'), 'allowed: at least 0.001'),
    (('benchmark', '--suite', 'soak', '--hours', '0'), 'allowed: at least 0.001'),
    (('benchmark', '--cases', '0'), 'allowed: at least 1'),
    (('benchmark', '--workers', '-1'), 'allowed: at least 0')])
def test_a_number_out_of_bounds_is_refused_in_one_line(tmp_path, capsys, arguments, allowed):
    with pytest.raises(SystemExit) as ended:
        main([*arguments, '--out', str(tmp_path / 'out')])
    said = capsys.readouterr().err
    option, value = arguments[-2:]
    assert ended.value.code == 2 and said.count('\n') == 1
    assert f"argument {option}: got '{value}'; {allowed}" in said
    assert not list(tmp_path.iterdir())
