"""What acts on the arm from outside for a time: contacts, other loads."""
