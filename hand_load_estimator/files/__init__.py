"""Files of this package: found, read, refused with a sentence, written whole."""
