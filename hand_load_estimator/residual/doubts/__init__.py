"""What speaks against recordings, models and findings, each said in a sentence."""
