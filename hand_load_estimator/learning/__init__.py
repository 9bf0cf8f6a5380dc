"""The only room that trains: sequences, network, training, artefact."""
