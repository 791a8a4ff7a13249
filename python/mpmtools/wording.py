"""Counts as text, for messages and tables."""


def counted(count, noun, plural=None):
    """A count with its noun in the right number: "1 run", "2 runs". plural: of nouns that do not just take an s."""
    return f"{int(count)} {noun if count == 1 else plural or noun + 's'}"


def verb(count, singular, plural):
    """The form of a verb for a count: "is" for 1, else "are"."""
    return singular if count == 1 else plural
