"""The one error that people are meant to read."""


class DappleError(Exception):
    """A bake that cannot go on: a sentence that says what is wrong, names the object, and says what to do."""
