"""Residuals of recordings: what of them is noise, what is structure, what is held out."""
