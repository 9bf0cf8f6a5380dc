"""How much memory this process holds now."""

from pathlib import Path

_STATUS = Path('/proc/self/status')


def resident_mib():
    """Return the resident set size [MiB] of this process, NaN where the system does not say."""
    try:
        lines = _STATUS.read_text('ascii').splitlines()
    except OSError:
        return float('nan')
    told = next((line for line in lines if line.startswith('VmRSS:')), None)
    return float(told.split()[1]) / 1024.0 if told else float('nan')
