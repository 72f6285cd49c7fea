"""What arael has to say about a user's input: records, renderers and explanations."""
