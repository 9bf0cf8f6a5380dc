"""Ways of estimating the load, one protocol (method.py), one file each."""
